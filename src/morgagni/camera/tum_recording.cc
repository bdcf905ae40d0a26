// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/tum_recording.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uintmax_t kMaxListBytes = 64U << 20U;
constexpr std::uintmax_t kMaxIntrinsicsBytes = 1U << 20U;
constexpr double kMaxPairingGapS = 0.020;
/// More pictures without a partner than this share are no accident of starting and stopping.
constexpr double kMaxUnpairedShare = 0.1;
/// Nanoseconds since 1970 still fit a 64-bit clock until the year 2262.
constexpr double kMaxTimestampS = 9.0e9;

struct Entry {
  double timestamp_s = 0.0;
  fs::path file;
};

tl::unexpected<Error> bad(const fs::path& path, std::string_view what) {
  return make_error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", path.string(), what));
}

std::string_view next_word(std::string_view& text) {
  const auto begin = std::min(text.find_first_not_of(" \t\r"), text.size());
  const auto end = std::min(text.find_first_of(" \t\r", begin), text.size());
  const auto word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

bool stays_inside(const fs::path& folder, const fs::path& file) {
  if (file.empty() || file.is_absolute()) return false;
  std::error_code status;
  const auto target = fs::weakly_canonical(folder / file, status);  // Follows symbolic links.
  if (status) return false;
  const auto inside = target.lexically_relative(folder);
  return !inside.empty() && *inside.begin() != ".." && inside != ".";
}

Result<Entry> parse_entry(std::string_view line, const fs::path& list, const fs::path& folder) {
  Entry entry;
  auto rest = line;
  const auto stamp = next_word(rest);
  const auto [end, status] =
      std::from_chars(stamp.data(), stamp.data() + stamp.size(), entry.timestamp_s);
  entry.file = fs::path(next_word(rest));
  const bool is_stamp = status == std::errc() && end == stamp.data() + stamp.size() &&
                        std::abs(entry.timestamp_s) <= kMaxTimestampS;
  if (!is_stamp || entry.file.empty() || !next_word(rest).empty()) {
    return bad(list, fmt::format("'{:.80}' is not a time stamp in seconds and a file name", line));
  }
  if (!stays_inside(folder, entry.file)) {
    return bad(list, fmt::format("'{}' leaves the recording's folder", entry.file.string()));
  }
  entry.file = folder / entry.file;
  return entry;
}

Result<std::vector<Entry>> read_list(const fs::path& list, const fs::path& folder) {
  MOR_TRY(const auto text, read_text_file(list, kMaxListBytes));
  std::vector<Entry> entries;
  for (std::string_view rest = text; !rest.empty();) {
    const auto end = rest.find('\n');
    const auto line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    auto words = line;
    const auto first = next_word(words);
    if (first.empty() || first.front() == '#') continue;
    MOR_TRY(auto entry, parse_entry(line, list, folder));
    if (!entries.empty() && !(entry.timestamp_s > entries.back().timestamp_s)) {
      return bad(list,
                 fmt::format("time stamp {:.6f} does not come after {:.6f}",
                             entry.timestamp_s,
                             entries.back().timestamp_s));
    }
    entries.push_back(std::move(entry));
  }
  if (entries.empty()) return bad(list, "lists no pictures");
  return entries;
}

Result<double> number(const Json& json, const char* key, const fs::path& path) {
  const auto value = json.find(key);
  if (value != json.end() && value->is_number()) return value->get<double>();
  return bad(path, fmt::format("has no number '{}'", key));
}

Result<int> size_px(const Json& json, const char* key, const fs::path& path) {
  MOR_TRY(const double value, number(json, key, path));
  if (value >= 1.0 && value <= kMaxPngSidePx && value == std::floor(value)) {
    return static_cast<int>(value);
  }
  return bad(path, fmt::format("{} must be in [1, {}], got {}", key, kMaxPngSidePx, value));
}

Result<void> read_distortion(const Json& json, const fs::path& path, PinholeCamera& camera) {
  const auto values = json.find("distortion");
  if (values == json.end() || values->is_null()) return {};
  if (!values->is_array() || values->size() != camera.distortion.size()) {
    return bad(path, "distortion must hold five numbers: k1, k2, p1, p2, k3");
  }
  for (std::size_t i = 0; i < camera.distortion.size(); ++i) {
    const auto& value = (*values)[i];
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
      return bad(path, fmt::format("distortion number {} is no finite number", i));
    }
    camera.distortion[i] = value.get<double>();
  }
  return {};
}

/// Our own addition to the layout.
Result<std::shared_ptr<const DepthCorrection>> read_correction(const Json& json,
                                                               const fs::path& path) {
  const auto value = json.find("depth_correction");
  if (value == json.end()) return nullptr;
  auto correction = depth_correction_from_json(value->dump());
  if (!correction) return bad(path, correction.error().message);
  return std::make_shared<const DepthCorrection>(*std::move(correction));
}

struct Intrinsics {
  PinholeCamera camera;
  std::shared_ptr<const DepthCorrection> correction;
  double depth_units_per_mm = 1.0;
};

Result<Intrinsics> read_intrinsics(const fs::path& path) {
  MOR_TRY(const auto text, read_text_file(path, kMaxIntrinsicsBytes));
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return bad(path, "is not a JSON object");
  Intrinsics intrinsics;
  auto& camera = intrinsics.camera;
  MOR_TRY(camera.width_px, size_px(json, "width", path));
  MOR_TRY(camera.height_px, size_px(json, "height", path));
  MOR_TRY(camera.focal_x_px, number(json, "fx", path));
  MOR_TRY(camera.focal_y_px, number(json, "fy", path));
  MOR_TRY(camera.center_x_px, number(json, "cx", path));
  MOR_TRY(camera.center_y_px, number(json, "cy", path));
  MOR_CHECK(read_distortion(json, path, camera));
  if (const auto checked = camera.check(); !checked) return bad(path, checked.error().message);
  MOR_TRY(intrinsics.correction, read_correction(json, path));
  MOR_TRY(const double units_per_m, number(json, "depth_scale", path));
  if (!(units_per_m >= 1.0 && units_per_m <= 1e6)) {
    return bad(
        path,
        fmt::format("depth_scale (units per metre) must be in [1, 1000000], got {}", units_per_m));
  }
  intrinsics.depth_units_per_mm = units_per_m / 1000.0;
  return intrinsics;
}

const Entry& nearest_entry(const std::vector<Entry>& entries, double timestamp_s) {
  const auto after = std::lower_bound(
      entries.begin(), entries.end(), timestamp_s, [](const Entry& entry, double stamp_s) {
        return entry.timestamp_s < stamp_s;
      });
  if (after == entries.begin()) return *after;
  if (after == entries.end()) return entries.back();
  const auto& before = *std::prev(after);
  return timestamp_s - before.timestamp_s <= after->timestamp_s - timestamp_s ? before : *after;
}

template <class T>
Result<void> check_size(const Image<T>& image, const PinholeCamera& camera, const fs::path& path) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return {};
  return bad(path,
             fmt::format("is {}x{}, intrinsics.json says {}x{}",
                         image.width(),
                         image.height(),
                         camera.width_px,
                         camera.height_px));
}

void convert_to_mm(Image<std::uint16_t>& depth, double units_per_mm) {
  if (units_per_mm == 1.0) return;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const double mm = std::round(depth.data()[i] / units_per_mm);
    depth.data()[i] = static_cast<std::uint16_t>(std::min(mm, 65535.0));
  }
}

}  // namespace

Result<TumRecording> TumRecording::open(const fs::path& folder) {
  std::error_code status;
  if (!fs::is_directory(folder, status)) {
    return make_error(ErrorCode::kNotFound, fmt::format("{}: no such folder", folder.string()));
  }
  const auto root = fs::canonical(folder, status);
  if (status) {
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", folder.string(), status.message()));
  }
  MOR_TRY(const auto intrinsics, read_intrinsics(root / "intrinsics.json"));
  MOR_TRY(const auto depths, read_list(root / "depth.txt", root));
  MOR_TRY(const auto colors, read_list(root / "rgb.txt", root));

  TumRecording recording;
  recording.depth_units_per_mm_ = intrinsics.depth_units_per_mm;
  recording.calibration_ = std::make_shared<const RgbdCalibration>(RgbdCalibration{
      intrinsics.camera, intrinsics.camera, Eigen::Isometry3d::Identity(), intrinsics.correction});
  for (const auto& depth : depths) {
    const auto& color = nearest_entry(colors, depth.timestamp_s);
    if (std::abs(color.timestamp_s - depth.timestamp_s) > kMaxPairingGapS) continue;
    recording.pairs_.push_back({depth.timestamp_s, depth.file, color.file});
  }
  const auto longest = std::max(depths.size(), colors.size());
  const auto num_unpaired = longest - recording.size();
  if (static_cast<double>(num_unpaired) > kMaxUnpairedShare * static_cast<double>(longest)) {
    return bad(root,
               fmt::format("depth.txt ({} pictures) and rgb.txt ({}) do not match: only {} pairs "
                           "are within 20 ms of each other",
                           depths.size(),
                           colors.size(),
                           recording.size()));
  }
  if (num_unpaired > 0) log::warn("{}: {} pictures have no partner", root.string(), num_unpaired);
  return recording;
}

std::chrono::nanoseconds TumRecording::since_start(std::size_t i) const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(timestamp_s(i) - timestamp_s(0)));
}

Result<std::shared_ptr<const RgbdFrame>> TumRecording::read(std::size_t i) const {
  if (i >= size()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("frame {} of a recording with {} frames", i, size()));
  }
  const auto& pair = pairs_[i];
  auto frame = std::make_shared<RgbdFrame>();
  frame->frame_id = i;
  frame->calibration = calibration_;
  frame->captured_at = std::chrono::steady_clock::time_point(
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(
          std::chrono::duration<double>(pair.timestamp_s)));
  MOR_TRY(frame->depth_mm, read_png_gray16(pair.depth));
  MOR_CHECK(check_size(frame->depth_mm, calibration_->depth, pair.depth));
  MOR_TRY(frame->color, read_png_rgb(pair.color));
  MOR_CHECK(check_size(frame->color, calibration_->color, pair.color));
  convert_to_mm(frame->depth_mm, depth_units_per_mm_);
  return frame;
}

}  // namespace mor
