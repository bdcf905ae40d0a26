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

}  // namespace mor::internal
