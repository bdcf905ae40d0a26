// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/volume_import.h"

#include <chrono>
#include <system_error>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/import_process.h"
#include "morgagni/ct/internal/series_join.h"
#include "morgagni/ct/label_map.h"

namespace mor {
namespace {

constexpr std::chrono::seconds kTimeLimit{600};

Result<std::filesystem::path> program_for(const std::filesystem::path& path) {
  std::error_code failure;
  if (!std::filesystem::exists(path, failure))
    return make_error(ErrorCode::kNotFound, "there is no file or folder " + path.string());
  return internal::find_import_program();
}

}  // namespace

Result<Volume> import_volume(const std::filesystem::path& path,
                             const ImportOptions& options,
                             const Progress& progress) {
  if (!options.join.empty()) return internal::import_joined(path, options, progress);
  MOR_TRY(const auto program, program_for(path));
  return internal::run_import_process(
      program, {kReadVolumeTask, path, options.series}, kTimeLimit, progress);
}

Result<std::vector<CtSeries>> list_ct_series(const std::filesystem::path& path,
                                             const Progress& progress) {
  MOR_TRY(const auto program, program_for(path));
  return internal::run_series_process(program, {kListSeriesTask, path, {}}, kTimeLimit, progress);
}

Result<std::string> weakness_of_import() {
  MOR_TRY(const auto program, internal::find_import_program());
  return internal::run_limits_process(program, kTimeLimit);
}

Result<LabelMap> import_label_map(const std::filesystem::path& path, const Progress& progress) {
  MOR_TRY(const auto program, program_for(path));
  return internal::run_label_process(program, {kReadLabelsTask, path, {}}, kTimeLimit, progress);
}

Result<std::vector<LabelMap>> import_label_maps(const std::filesystem::path& path,
                                                const Progress& progress) {
  MOR_TRY(const auto program, program_for(path));
  std::vector<LabelMap> maps;
  MOR_TRY(LabelMap first, import_label_map(path, progress));
  maps.push_back(std::move(first));
  for (int number = 2; number <= maps.front().num_in_file; ++number) {
    MOR_TRY(LabelMap next,
            internal::run_label_process(
                program, {kReadLabelsTask, path, std::to_string(number)}, kTimeLimit, progress));
    maps.push_back(std::move(next));
  }
  return maps;
}

}  // namespace mor
