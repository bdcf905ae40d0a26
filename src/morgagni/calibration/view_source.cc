// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/view_source.h"

#include <algorithm>
#include <map>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/calibration/board_pattern.h"
#include "morgagni/camera/simulated_board_camera.h"
#include "morgagni/core/image_png.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSimulated = "simulated-board:";
constexpr std::size_t kMaxPictures = 2000;
constexpr double kFocalOfWidth = 0.87;  // 60 degrees.

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

struct Role {
  enum Kind { kColor, kInfrared, kDepth } kind = kColor;
  std::string name;
};

Role role_of(const std::string& stem) {
  constexpr std::pair<std::string_view, Role::Kind> kPrefixes[] = {
      {"color_", Role::kColor}, {"infrared_", Role::kInfrared}, {"depth_", Role::kDepth}};
  for (const auto& [prefix, kind] : kPrefixes) {
    if (stem.starts_with(prefix)) return {kind, stem.substr(prefix.size())};
  }
  return {Role::kColor, stem};
}

/// The first picture of a kind sets the size for all.
template <class T>
Result<void> check_size(const Image<T>& image,
                        const fs::path& path,
                        std::optional<std::pair<int, int>>& size) {
  const std::pair<int, int> own(image.width(), image.height());
  if (!size) size = own;
  if (*size == own) return {};
  return bad(
      fmt::format("{}: is {}x{}, others here are {}x{}: the pictures must come from one camera",
                  path.string(),
                  own.first,
                  own.second,
                  size->first,
                  size->second));
}

PinholeCamera unknown_lens(int width_px, int height_px) {
  const double focal_px = kFocalOfWidth * width_px;
  return {width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), {}};
}

}  // namespace

Result<std::vector<StillPictures>> read_still_pictures(const fs::path& folder) {
  std::error_code status;
  if (!fs::is_directory(folder, status)) {
    return make_error(ErrorCode::kNotFound, fmt::format("{}: no such folder", folder.string()));
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  if (files.empty()) return bad(fmt::format("{}: holds no PNG picture", folder.string()));
  if (files.size() > kMaxPictures) {
    return bad(fmt::format(
        "{}: holds {} pictures, at most {} are read", folder.string(), files.size(), kMaxPictures));
  }
  std::map<std::string, StillPictures> by_name;
  std::optional<std::pair<int, int>> color_size;
  std::optional<std::pair<int, int>> depth_size;
  for (const auto& file : files) {
    const Role role = role_of(file.stem().string());
    auto& pictures = by_name[role.name];
    pictures.name = role.name;
    if (role.kind == Role::kDepth) {
      MOR_TRY(pictures.depth_mm, read_png_gray16(file));
      MOR_CHECK(check_size(*pictures.depth_mm, file, depth_size));
    } else {
      MOR_TRY(auto picture, read_png_rgb(file));
      MOR_CHECK(check_size(picture, file, role.kind == Role::kColor ? color_size : depth_size));
      (role.kind == Role::kColor ? pictures.color : pictures.infrared) = std::move(picture);
    }
  }
  std::vector<StillPictures> result;
  for (auto& [name, pictures] : by_name) result.push_back(std::move(pictures));
  return result;
}

RgbdCalibration unknown_calibration(const std::vector<StillPictures>& pictures) {
  std::optional<PinholeCamera> color;
  std::optional<PinholeCamera> depth;
  for (const auto& each : pictures) {
    if (!color && each.color) color = unknown_lens(each.color->width(), each.color->height());
    if (depth) continue;
    if (each.infrared) depth = unknown_lens(each.infrared->width(), each.infrared->height());
    if (each.depth_mm) depth = unknown_lens(each.depth_mm->width(), each.depth_mm->height());
  }
  RgbdCalibration calibration;
  if (color || depth) calibration.color = color ? *color : *depth;
  calibration.depth = depth ? *depth : calibration.color;
  return calibration;
}

Result<std::unique_ptr<RangeCamera>> open_camera_before_board(const std::string& name,
                                                              const CalibrationBoard& board,
                                                              std::stop_token stop,
                                                              const SayWaiting& say) {
  MOR_CHECK(board.check());
  if (name.starts_with(kSimulated)) {
    MOR_TRY(const auto options, SimulatedBoardOptions::parse(name.substr(kSimulated.size())));
    MOR_TRY(auto camera, SimulatedBoardCamera::create(board_picture(board), options));
    return std::unique_ptr<RangeCamera>(std::move(camera));
  }
  if (name.starts_with("simulated:")) {
    return bad("the simulated body holds no board: try simulated-board:");
  }
  return open_camera(name, nullptr, std::move(stop), {}, say);
}

}  // namespace mor
