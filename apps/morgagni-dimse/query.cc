// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/fmt/fmt.h>

#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dctk.h"
#include "dcmtk/dcmnet/diutil.h"
#include "query_keys.h"
#include "scu.h"
#include "services.h"

namespace mor::dimse {

Result<void> put_keys(const Task& task, DcmDataset& dataset) {
  auto status = dataset.putAndInsertString(DCM_QueryRetrieveLevel, task.level.c_str());
  bool is_ascii = true;
  for (const auto& [tag, value] : task.keys) {
    const auto number = std::stoul(tag, nullptr, 16);
    const DcmTag key(static_cast<Uint16>(number >> 16U), static_cast<Uint16>(number & 0xFFFFU));
    if (status.good()) status = dataset.putAndInsertString(key, value.c_str());
    for (const char letter : value) is_ascii = is_ascii && static_cast<signed char>(letter) > 0;
  }
  if (status.good() && !is_ascii)
    status = dataset.putAndInsertString(DCM_SpecificCharacterSet, "ISO_IR 192");
  if (status.good()) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the query cannot be made: {}", status.text()));
}

Result<int> echo(const Task& task) {
  Scu scu(task);
  MOR_CHECK(scu.connect({{UID_VerificationSOPClass, plain_codings()}}));
  MOR_TRY(const auto context, scu.context_of(UID_VerificationSOPClass, "C-ECHO"));
  const auto status = scu.sendECHORequest(context);
  if (status.bad()) return tl::unexpected<Error>(scu.error_of(status));
  (void)scu.releaseAssociation();
  return 0;
}

Result<int> find(const Task& task) {
  constexpr const char* kModel = UID_FINDStudyRootQueryRetrieveInformationModel;
  DcmDataset keys;
  MOR_CHECK(put_keys(task, keys));
  Scu scu(task);
  MOR_CHECK(scu.connect({{kModel, plain_codings()}}));
  MOR_TRY(const auto context, scu.context_of(kModel, "C-FIND"));
  const auto status = scu.sendFINDRequest(context, &keys, nullptr);
  if (status.bad()) return tl::unexpected<Error>(scu.error_of(status));
  if (scu.has_too_many()) {
    (void)scu.abortAssociation();  // A C-CANCEL would have to wait for what is on its way.
    return 0;
  }
  if (scu.final_status() != STATUS_Success) {
    return make_error(ErrorCode::kIo,
                      fmt::format("{} refuses the query: {}",
                                  scu.peer(),
                                  DU_cfindStatusString(static_cast<Uint16>(scu.final_status()))));
  }
  (void)scu.releaseAssociation();
  return 0;
}

}  // namespace mor::dimse
