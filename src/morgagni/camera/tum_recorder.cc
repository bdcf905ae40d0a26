// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/tum_recorder.h"

#include <cmath>
#include <system_error>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/pending_folder.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> invalid(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

tl::unexpected<Error> io_error(const fs::path& path, const std::error_code& status) {
  return make_error(ErrorCode::kIo, fmt::format("{}: {}", path.string(), status.message()));
}

/// TUM: `stamp tx ty tz qx qy qz qw`, RAS+ and metres. LPS becomes RAS by turning x and y around.
std::string truth_line(double timestamp_s, const Eigen::Isometry3d& ct_from_camera) {
  const Eigen::Vector3d ras_from_lps(-1.0, -1.0, 1.0);
  const Eigen::Matrix3d rotation = ras_from_lps.asDiagonal() * ct_from_camera.linear();
  const Eigen::Vector3d position_m =
      ras_from_lps.cwiseProduct(ct_from_camera.translation()) / 1000.0;
  const Eigen::Quaterniond q(rotation);
  return fmt::format("{:.6f} {:.7f} {:.7f} {:.7f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                     timestamp_s,
                     position_m.x(),
                     position_m.y(),
                     position_m.z(),
                     q.x(),
                     q.y(),
                     q.z(),
                     q.w());
}

std::string intrinsics_json(const RgbdCalibration& calibration) {
  const PinholeCamera& camera = calibration.depth;
  nlohmann::ordered_json json = {{"fx", camera.focal_x_px},
                                 {"fy", camera.focal_y_px},
                                 {"cx", camera.center_x_px},
                                 {"cy", camera.center_y_px},
                                 {"width", camera.width_px},
                                 {"height", camera.height_px},
                                 {"depth_scale", 1000.0},
                                 {"distortion", camera.distortion}};
  if (calibration.depth_correction) {
    json["depth_correction"] =
        nlohmann::ordered_json::parse(depth_correction_to_json(*calibration.depth_correction));
  }
  return json.dump(1) + "\n";
}

bool has_size(int width, int height, const PinholeCamera& camera) {
  return width == camera.width_px && height == camera.height_px;
}

}  // namespace

struct TumRecorder::Impl {
  Impl(fs::path target, PendingFolder pending_folder)
      : folder(std::move(target)), pending(std::move(pending_folder)) {}

  [[nodiscard]] Result<void> check(const RgbdFrame& frame,
                                   double timestamp_s,
                                   bool has_truth) const;

  fs::path folder;
  PendingFolder pending;
  bool is_finished = false;
  std::optional<RgbdCalibration> calibration;
  std::size_t num_frames = 0;
  double last_timestamp_s = 0.0;
  std::string color_list = "# timestamp filename\n";
  std::string depth_list = "# timestamp filename\n";
  std::string truth;
};

Result<void> TumRecorder::Impl::check(const RgbdFrame& frame,
                                      double timestamp_s,
                                      bool has_truth) const {
  if (is_finished) return invalid("the recording is finished");
  if (!frame.calibration) return invalid("a frame without calibration cannot be recorded");
  const PinholeCamera& depth = frame.calibration->depth;
  const PinholeCamera& color = frame.calibration->color;
  const Eigen::Isometry3d& color_from_depth = frame.calibration->color_from_depth;
  if (depth != color || !color_from_depth.isApprox(Eigen::Isometry3d::Identity(), 1e-9)) {
    return make_error(ErrorCode::kUnsupported,
                      "the TUM layout has one pinhole for depth and colour, this camera has two");
  }
  if (calibration && *calibration != *frame.calibration) {
    return invalid("the camera's calibration changed during the recording");
  }
  if (!has_size(frame.depth_mm.width(), frame.depth_mm.height(), depth) ||
      !has_size(frame.color.width(), frame.color.height(), color)) {
    return invalid(fmt::format("frame {} is not {}x{} as its calibration says",
                               frame.frame_id,
                               depth.width_px,
                               depth.height_px));
  }
  if (!std::isfinite(timestamp_s) || (num_frames > 0 && timestamp_s <= last_timestamp_s)) {
    return invalid(
        fmt::format("time stamp {} does not come after {}", timestamp_s, last_timestamp_s));
  }
  if (num_frames > 0 && has_truth == truth.empty()) {
    return invalid("the truth must be given for every frame or for none");
  }
  return {};
}

TumRecorder::TumRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TumRecorder::TumRecorder(TumRecorder&&) noexcept = default;
TumRecorder& TumRecorder::operator=(TumRecorder&&) noexcept = default;
TumRecorder::~TumRecorder() = default;

Result<TumRecorder> TumRecorder::create(const fs::path& folder) {
  std::error_code status;
  if (fs::exists(folder, status) &&
      (!fs::is_directory(folder, status) || !fs::is_empty(folder, status))) {
    return invalid(fmt::format("{}: exists and is not an empty folder", folder.string()));
  }
  MOR_TRY(auto pending, PendingFolder::create(folder));
  for (const char* part : {"rgb", "depth"}) {
    fs::create_directory(pending.path() / part, status);
    if (status) return io_error(pending.path() / part, status);
  }
  return TumRecorder(std::make_unique<Impl>(folder, std::move(pending)));
}

Result<void> TumRecorder::add(const RgbdFrame& given,
                              double timestamp_s,
                              const std::optional<Eigen::Isometry3d>& ct_from_camera) {
  const RgbdFrame& frame = as_sensed(given);
  MOR_CHECK(impl_->check(frame, timestamp_s, ct_from_camera.has_value()));
  const auto& folder = impl_->pending.path();
  const auto name = fmt::format("{:06}.png", impl_->num_frames);
  MOR_CHECK(write_file(folder / "depth" / name, encode_png(frame.depth_mm.view())));
  MOR_CHECK(write_file(folder / "rgb" / name, encode_png(frame.color.view())));
  impl_->depth_list += fmt::format("{:.6f} depth/{}\n", timestamp_s, name);
  impl_->color_list += fmt::format("{:.6f} rgb/{}\n", timestamp_s, name);
  if (ct_from_camera) impl_->truth += truth_line(timestamp_s, *ct_from_camera);
  impl_->calibration = *frame.calibration;
  impl_->last_timestamp_s = timestamp_s;
  ++impl_->num_frames;
  return {};
}

Result<void> TumRecorder::add_file(std::string_view name, std::string_view text) {
  if (impl_->is_finished) return invalid("the recording is finished");
  const auto path = impl_->pending.path() / name;
  if (fs::path(name).has_parent_path() || fs::exists(path)) {
    return invalid(fmt::format("'{}' is no name of a further file of a recording", name));
  }
  return write_file(path, text);
}

Result<void> TumRecorder::finish() {
  if (impl_->is_finished || impl_->num_frames == 0) {
    return invalid(fmt::format("{}: no frames to finish", impl_->folder.string()));
  }
  const auto& aside = impl_->pending.path();
  MOR_CHECK(write_file(aside / "rgb.txt", impl_->color_list));
  MOR_CHECK(write_file(aside / "depth.txt", impl_->depth_list));
  MOR_CHECK(write_file(aside / "intrinsics.json", intrinsics_json(*impl_->calibration)));
  if (!impl_->truth.empty()) {
    constexpr const char* kHead =
        "# timestamp tx ty tz qx qy qz qw   camera in the CT's world (RAS+), metres\n";
    MOR_CHECK(write_file(aside / "groundtruth.txt", kHead + impl_->truth));
  }
  MOR_CHECK(impl_->pending.commit());
  impl_->is_finished = true;
  return {};
}

}  // namespace mor
