// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include <spdlog/fmt/fmt.h>

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dctk.h"
#include "dcmtk/dcmnet/diutil.h"
#include "query_keys.h"
#include "scu.h"
#include "services.h"

namespace mor::dimse {
namespace {

/// What a case can be made of: CTs, and structures that were drawn in them.
constexpr std::array kWanted = {UID_CTImageStorage,
                                UID_EnhancedCTImageStorage,
                                UID_LegacyConvertedEnhancedCTImageStorage,
                                UID_SegmentationStorage,
                                UID_SurfaceSegmentationStorage,
                                UID_RTStructureSetStorage,
                                UID_EncapsulatedSTLStorage,
                                UID_SecondaryCaptureImageStorage};

/// Each coding for itself, so that the peer can send every object as it keeps it.
std::vector<Proposal> retrieve_proposals() {
  std::vector<Proposal> all = {
      {UID_GETStudyRootQueryRetrieveInformationModel, plain_codings(), ASC_SC_ROLE_DEFAULT}};
  for (const char* kind : kWanted) {
    for (const auto& coding : plain_codings()) all.push_back({kind, {coding}, ASC_SC_ROLE_SCP});
    for (const auto& coding : further_codings()) all.push_back({kind, {coding}, ASC_SC_ROLE_SCP});
  }
  return all;
}

Result<int> outcome(const Scu& scu, const OFCondition& status, const char* service) {
  if (status.bad()) return tl::unexpected<Error>(scu.error_of(status));
  const auto code = static_cast<Uint16>(scu.final_status());
  constexpr unsigned kSomeFailed = 0xB000;
  if (code == STATUS_Success || code == kSomeFailed) return scu.num_failed();
  constexpr unsigned kUnknownDestination = 0xA801;
  if (code == kUnknownDestination) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} does not know the destination of the C-MOVE: have it entered "
                                  "there with this computer's address and port (--aet, --listen)",
                                  scu.peer()));
  }
  return make_error(ErrorCode::kIo,
                    fmt::format("{} ends the {} with status {:04X}: {}",
                                scu.peer(),
                                service,
                                code,
                                DU_cmoveStatusString(code)));
}

}  // namespace

Result<int> get(const Task& task) {
  DcmDataset keys;
  MOR_CHECK(put_keys(task, keys));
  Scu scu(task);
  MOR_CHECK(scu.connect(retrieve_proposals()));
  MOR_TRY(const auto context,
          scu.context_of(UID_GETStudyRootQueryRetrieveInformationModel, "C-GET (try --by move)"));
  const auto status = scu.sendCGETRequest(context, &keys, nullptr);
  auto num_failed = outcome(scu, status, "C-GET");
  if (num_failed) (void)scu.releaseAssociation();
  return num_failed;
}

Result<int> move(const Task& task) {
  constexpr const char* kModel = UID_MOVEStudyRootQueryRetrieveInformationModel;
  DcmDataset keys;
  MOR_CHECK(put_keys(task, keys));
  Scu scu(task);
  MOR_CHECK(scu.connect({{kModel, plain_codings()}}));
  MOR_TRY(const auto context, scu.context_of(kModel, "C-MOVE"));
  const auto status = scu.sendMOVERequest(context, task.calling_aet.c_str(), &keys, nullptr);
  auto num_failed = outcome(scu, status, "C-MOVE");
  if (num_failed) (void)scu.releaseAssociation();
  return num_failed;
}

}  // namespace mor::dimse
