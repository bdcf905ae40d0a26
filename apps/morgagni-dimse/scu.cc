// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scu.h"

#include <algorithm>
#include <cstdlib>

#include <spdlog/fmt/fmt.h>

#include "dataset_tags.h"
#include "dcmtk/dcmdata/dctk.h"
#include "dcmtk/dcmnet/diutil.h"
#include "dcmtk/oflog/appender.h"
#include "dcmtk/oflog/spi/logevent.h"
#include "messages.h"

namespace mor::dimse {
namespace {

constexpr Uint32 kMaxPduBytes = ASC_MAXIMUMPDUSIZE;

/// DCMTK's texts have several lines.
std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (std::size_t at; (at = text.find('\n')) != std::string::npos;) text.replace(at, 1, ", ");
  return text;
}

/// Why an association was rejected, which DCMTK says to its log only.
class RejectionReader : public dcmtk::log4cplus::Appender {
 public:
  ~RejectionReader() override { destructorImpl(); }
  void close() override { closed = true; }

  /// "Called AE Title Not Recognized", or nothing.
  [[nodiscard]] std::string reason() const {
    constexpr std::string_view kBefore = "Reason: ";
    const auto start = text_.find(kBefore);
    if (start == std::string::npos) return {};
    const auto from = start + kBefore.size();
    return text_.substr(from, text_.find('\n', from) - from);
  }

 protected:
  void append(const dcmtk::log4cplus::spi::InternalLoggingEvent& event) override {
    const std::string text(event.getMessage().c_str());
    if (text.find("Association Rejected") != std::string::npos) text_ = text;
  }

 private:
  std::string text_;
};

}  // namespace

std::vector<std::string> plain_codings() {
  return {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax};
}

std::vector<std::string> further_codings() {
  return {UID_BigEndianExplicitTransferSyntax,
          UID_JPEGProcess14SV1TransferSyntax,
          UID_JPEGProcess14TransferSyntax,
          UID_JPEGLSLosslessTransferSyntax,
          UID_JPEG2000LosslessOnlyTransferSyntax,
          UID_RLELosslessTransferSyntax,
          UID_JPEGLSLossyTransferSyntax,
          UID_JPEG2000TransferSyntax,
          UID_JPEGProcess2_4TransferSyntax,
          UID_JPEGProcess1TransferSyntax};
}

Scu::Scu(const Task& task) : task_(task), store_(task) {
  setPeerHostName(task.host.c_str());
  setPeerPort(task.port);
  setPeerAETitle(task.called_aet.c_str());
  setAETitle(task.calling_aet.c_str());
  setMaxReceivePDULength(kMaxPduBytes);
  setDIMSEBlockingMode(DIMSE_NONBLOCKING);
  setDIMSETimeout(task.timeout_s);
  setACSETimeout(task.timeout_s);
  setConnectionTimeout(static_cast<Sint32>(task.timeout_s));
  setStorageMode(DCMSCU_STORAGE_BIT_PRESERVING);
  setStorageDir(task.folder.c_str());
}

std::string Scu::peer() const {
  return fmt::format("{}:{}", task_.host, task_.port);
}

Error Scu::error_of(const OFCondition& status) const {
  if (const auto why = refused_certificate(); !why.empty()) {
    return {ErrorCode::kInvalidArgument,
            fmt::format("{}: its TLS certificate is not trusted: {}", peer(), why)};
  }
  if (status == DUL_ASSOCIATIONREJECTED || status.code() == DULC_ASSOCIATIONREJECTED) {
    return {ErrorCode::kInvalidArgument,
            fmt::format("{} refuses {} to call {}: {}",
                        peer(),
                        task_.calling_aet,
                        task_.called_aet,
                        rejection_.empty() ? one_line(status.text()) : rejection_)};
  }
  if (status == DIMSE_NODATAAVAILABLE || status == DUL_READTIMEOUT) {
    return {ErrorCode::kTimeout,
            fmt::format("{} did not answer within {} s", peer(), task_.timeout_s)};
  }
  if (status == DUL_PEERABORTEDASSOCIATION)
    return {ErrorCode::kIo, fmt::format("{} broke the connection off", peer())};
  if (status == NET_EC_NoAcceptablePresentationContexts)
    return {ErrorCode::kUnsupported, fmt::format("{} offers nothing of what is asked for", peer())};
  return {ErrorCode::kIo, fmt::format("{}: {}", peer(), one_line(status.text()))};
}

OFCondition Scu::negotiate() {
  auto* reader = new RejectionReader;  // The logger's pointer owns it.
  dcmtk::log4cplus::SharedAppenderPtr appender(reader);
  DCM_dcmnetLogger.addAppender(appender);
  DCM_dcmnetLogger.setLogLevel(OFLogger::DEBUG_LOG_LEVEL);
  const auto status = negotiateAssociation();
  DCM_dcmnetLogger.setLogLevel(OFLogger::OFF_LOG_LEVEL);
  DCM_dcmnetLogger.removeAppender(appender);
  rejection_ = reader->reason();
  return status;
}

Result<void> Scu::connect(const std::vector<Proposal>& proposals) {
  for (const auto& proposal : proposals) {
    OFList<OFString> codings;
    for (const auto& coding : proposal.transfer_syntaxes) codings.push_back(coding.c_str());
    const auto added =
        addPresentationContext(proposal.abstract_syntax.c_str(), codings, proposal.role);
    if (added.bad()) return tl::unexpected<Error>(error_of(added));
  }
  MOR_TRY(tls_, make_tls(task_.tls, NET_REQUESTOR, task_.host));
  auto status = initNetwork();
  if (status.good() && tls_) status = useSecureConnection(tls_.get());
  if (status.good()) status = negotiate();
  if (status.bad()) return tl::unexpected<Error>(error_of(status));
  return {};
}

Result<T_ASC_PresentationContextID> Scu::context_of(const std::string& abstract_syntax,
                                                    const std::string& service) {
  const auto id = findPresentationContextID(abstract_syntax.c_str(), "");
  if (id != 0) return id;
  return make_error(ErrorCode::kUnsupported, fmt::format("{} does not offer {}", peer(), service));
}

OFCondition Scu::handleFINDResponse(T_ASC_PresentationContextID context,
                                    QRResponse* response,
                                    OFBool& wait_for_next) {
  const auto handled = DcmSCU::handleFINDResponse(context, response, wait_for_next);
  if (response == nullptr) return handled;
  final_status_ = response->m_status;
  if (response->m_dataset == nullptr) return handled;
  if (num_matches_ == task_.max_matches) {
    has_too_many_ = true;
    wait_for_next = OFFalse;
    return handled;
  }
  ++num_matches_;
  auto& dataset = *response->m_dataset;
  (void)dataset.convertToUTF8();
  say_match(tags_of(dataset,
                    {DCM_StudyInstanceUID,
                     DCM_SeriesInstanceUID,
                     DCM_SOPInstanceUID,
                     DCM_PatientID,
                     DCM_PatientName,
                     DCM_StudyDate,
                     DCM_StudyDescription,
                     DCM_AccessionNumber,
                     DCM_ModalitiesInStudy,
                     DCM_Modality,
                     DCM_SeriesNumber,
                     DCM_SeriesDescription,
                     DCM_NumberOfStudyRelatedInstances,
                     DCM_NumberOfSeriesRelatedInstances}));
  return handled;
}

void Scu::remember(const RetrieveResponse& response) {
  final_status_ = response.m_status;
  if (!DICOM_PENDING_STATUS(response.m_status)) num_failed_ = response.m_numberOfFailedSubops;
}

OFCondition Scu::handleCGETResponse(T_ASC_PresentationContextID context,
                                    RetrieveResponse* response,
                                    OFBool& go_on) {
  if (response != nullptr) remember(*response);
  return DcmSCU::handleCGETResponse(context, response, go_on);
}

OFCondition Scu::handleMOVEResponse(T_ASC_PresentationContextID context,
                                    RetrieveResponse* response,
                                    OFBool& wait_for_next) {
  if (response != nullptr) remember(*response);
  return DcmSCU::handleMOVEResponse(context, response, wait_for_next);
}

OFCondition Scu::handleSTORERequestFile(T_ASC_PresentationContextID* context,
                                        const OFString& /*filename*/,
                                        T_DIMSE_C_StoreRQ* request) {
  if (const auto room = store_.check_room(); !room) {
    say_failed(room.error());
    std::exit(1);
  }
  const auto part = store_.part_file();
  auto status = DcmSCU::handleSTORERequestFile(context, part.c_str(), request);
  if (status.good()) {
    if (const auto kept = store_.keep(part, request->AffectedSOPInstanceUID); !kept) {
      say_refused(kept.error().message);
      status = EC_InvalidValue;
    }
  }
  if (status.bad()) store_.discard(part);
  return status;
}

void Scu::notifyRECEIVEProgress(unsigned long num_bytes) {
  if (num_bytes <= task_.max_object_bytes) return;
  say_failed({ErrorCode::kInvalidArgument,
              fmt::format("{} sends an object of more than {} MB, the limit (--max-object-mb)",
                          peer(),
                          task_.max_object_bytes / 1000000)});
  std::exit(1);
}

}  // namespace mor::dimse
