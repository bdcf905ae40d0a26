// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/pacs/dimse_protocol.h"

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dctk.h"
#include "dcmtk/dcmnet/scp.h"
#include "messages.h"
#include "object_store.h"
#include "scu.h"
#include "services.h"
#include "tls.h"

namespace mor::dimse {
namespace {

constexpr Uint16 kOutOfResources = 0xA700;
constexpr Uint16 kCannotUnderstand = 0xC000;
constexpr int kMaxRefusalsTold = 20;

/// What cases are made of, then what else studies consist of, as far as an association goes.
std::vector<const char*> accepted_kinds() {
  constexpr std::size_t kMaxKinds = 127;  // And C-ECHO.
  std::vector<const char*> kinds = {UID_LegacyConvertedEnhancedCTImageStorage,
                                    UID_EncapsulatedSTLStorage,
                                    UID_SurfaceSegmentationStorage};
  const auto has = [&kinds](std::string_view kind) {
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
  };
  for (int i = 0; i < numberOfDcmLongSCUStorageSOPClassUIDs; ++i) {
    const char* kind = dcmLongSCUStorageSOPClassUIDs[i];
    if (kinds.size() < kMaxKinds && !has(kind)) kinds.push_back(kind);
  }
  return kinds;
}

/// One association: C-ECHO and C-STORE.
class Receiver : public DcmSCP {
 public:
  explicit Receiver(const Task& task) : task_(task), store_(task) {}

  Result<void> set_up(DcmTLSTransportLayer* tls) {
    auto& config = getConfig();
    config.setAETitle(task_.called_aet.c_str());
    config.setRespondWithCalledAETitle(OFTrue);
    config.setMaxReceivePDULength(ASC_MAXIMUMPDUSIZE);
    config.setConnectionBlockingMode(DUL_NOBLOCK);
    config.setConnectionTimeout(task_.timeout_s);
    config.setACSETimeout(task_.timeout_s);
    config.setDIMSEBlockingMode(DIMSE_NONBLOCKING);
    config.setDIMSETimeout(task_.timeout_s);
    config.setHostLookupEnabled(OFFalse);
    config.setTransportLayer(tls);
    OFList<OFString> plain;
    for (const auto& coding : plain_codings()) plain.push_back(coding.c_str());
    OFList<OFString> codings = plain;
    for (const auto& coding : further_codings()) codings.push_back(coding.c_str());
    auto status = config.addPresentationContext(UID_VerificationSOPClass, plain);
    for (const char* kind : accepted_kinds())
      if (status.good()) status = config.addPresentationContext(kind, codings);
    if (status.good()) return {};
    return make_error(ErrorCode::kInternal, status.text());
  }

  [[nodiscard]] const std::string& error() const { return error_; }

 protected:
  void notifyAssociationRequest(const T_ASC_Parameters& parameters,
                                DcmSCPActionType& /*action*/) override {
    caller_ = parameters.DULparams.callingAPTitle;
    say_caller(caller_);
  }

  OFBool checkCalledAETitleAccepted(const OFString& called) override {
    if (task_.any_called_aet || called == task_.called_aet.c_str()) return OFTrue;
    say_refused(
        fmt::format("{} called for {}, not for {}", caller_, called.c_str(), task_.called_aet));
    return OFFalse;
  }

  OFBool checkCallingAETitleAccepted(const OFString& calling) override {
    const auto& accepted = task_.accepted_callers;
    if (accepted.empty() ||
        std::find(accepted.begin(), accepted.end(), calling.c_str()) != accepted.end())
      return OFTrue;
    say_refused(fmt::format("{} is not among --accept", calling.c_str()));
    return OFFalse;
  }

  OFBool stopAfterCurrentAssociation() override { return OFTrue; }
  OFBool stopAfterConnectionTimeout() override { return OFTrue; }

  void notifyDIMSEError(const OFCondition& status) override {
    error_ = status == DIMSE_NODATAAVAILABLE ? fmt::format("said nothing for {} s", task_.timeout_s)
                                             : status.text();
  }

  void notifyAbortRequest() override { error_ = "broke the connection off"; }

  void notifyRECEIVEProgress(const unsigned long num_bytes) override {
    if (num_bytes <= task_.max_object_bytes) return;
    store_.discard(part_);
    say_failed({ErrorCode::kInvalidArgument,
                fmt::format("sends an object of more than {} MB, the limit (--max-object-mb)",
                            task_.max_object_bytes / 1000000)});
    std::exit(1);
  }

  OFCondition handleIncomingCommand(T_DIMSE_Message* message,
                                    const DcmPresentationContextInfo& context) override {
    if (message->CommandField != DIMSE_C_STORE_RQ)
      return DcmSCP::handleIncomingCommand(message, context);
    auto& request = message->msg.CStoreRQ;
    Uint16 answer = STATUS_Success;
    const auto received = receive_object(request, context.presentationContextID, answer);
    if (received.bad()) return received;
    return sendSTOREResponse(context.presentationContextID, request, answer);
  }

 private:
  /// @param answer  What the sender is told of an object that came whole.
  OFCondition receive_object(T_DIMSE_C_StoreRQ& request,
                             T_ASC_PresentationContextID context,
                             Uint16& answer) {
    const auto room = store_.check_room();
    // What there is no room for is read to its end all the same, and goes nowhere.
    part_ = room ? store_.part_file() : "/dev/null";
    const auto received = receiveSTORERequest(request, context, part_.c_str());
    if (!room) {
      refuse(room.error().message);
      answer = kOutOfResources;
      return received;
    }
    if (received.bad()) {
      store_.discard(part_);
      return received;
    }
    if (const auto kept = store_.keep(part_, request.AffectedSOPInstanceUID); !kept) {
      store_.discard(part_);
      refuse(kept.error().message);
      answer = kept.error().code == ErrorCode::kIo ? kOutOfResources : kCannotUnderstand;
    }
    return EC_Normal;
  }

  void refuse(const std::string& why) {
    if (++num_refusals_ <= kMaxRefusalsTold) say_refused(why);
  }

  const Task& task_;
  ObjectStore store_;
  std::string part_;
  std::string caller_;
  std::string error_;
  int num_refusals_ = 0;
};

}  // namespace

Result<int> receive(const Task& task) {
  MOR_TRY(const auto tls, make_tls(task.tls, NET_ACCEPTOR));
  Receiver receiver(task);
  MOR_CHECK(receiver.set_up(tls.get()));
  dcmExternalSocketHandle.set(kSocketFd);
  const auto opened = receiver.openListenPort();
  if (opened.bad()) return make_error(ErrorCode::kInternal, opened.text());
  (void)receiver.acceptAssociations();
  if (!receiver.error().empty()) return make_error(ErrorCode::kIo, receiver.error());
  return 0;
}

}  // namespace mor::dimse
