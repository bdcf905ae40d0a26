// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/calibration_file.h"

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/core/files.h"

namespace mor::internal {
namespace {

constexpr std::uintmax_t kMaxBytes = 1U << 20U;

}  // namespace

Result<RgbdCalibration> read_calibration_file(const std::filesystem::path& path,
                                              const RgbdCalibration& like) {
  MOR_TRY(const auto text, read_text_file(path, kMaxBytes));
  auto calibration = calibration_from_json(text);
  if (!calibration) {
    return make_error(calibration.error().code,
                      fmt::format("{}: {}", path.string(), calibration.error().message));
  }
  const auto check = [&](const PinholeCamera& given, const PinholeCamera& camera) -> Result<void> {
    if (given.width_px == camera.width_px && given.height_px == camera.height_px) return {};
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{}: is for pictures of {}x{}, the camera's have {}x{}",
                                  path.string(),
                                  given.width_px,
                                  given.height_px,
                                  camera.width_px,
                                  camera.height_px));
  };
  MOR_CHECK(check(calibration->depth, like.depth));
  MOR_CHECK(check(calibration->color, like.color));
  return calibration;
}

Result<RgbdCalibration> choose_calibration(const std::string& file,
                                           const KnownCalibration& known,
                                           const std::string& device_id,
                                           const RgbdCalibration& by_design) {
  if (!file.empty()) {
    MOR_TRY(auto calibration, read_calibration_file(file, by_design));
    if (calibration.origin.empty()) calibration.origin = file;
    return calibration;
  }
  if (!known || device_id.empty()) return by_design;
  MOR_TRY(auto found, known(device_id, by_design));
  return std::move(found).value_or(by_design);
}

}  // namespace mor::internal
