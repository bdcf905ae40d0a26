// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/simulated_camera.h"

#include <algorithm>
#include <cmath>

#include "morgagni/camera/internal/depth_bias.h"
#include "morgagni/camera/internal/exposure.h"
#include "morgagni/camera/internal/hand_path.h"
#include "morgagni/camera/internal/kinect_noise.h"
#include "morgagni/camera/internal/scene/clutter.h"
#include "morgagni/camera/internal/scene/scene.h"
#include "morgagni/camera/internal/view_places.h"
#include "morgagni/camera/internal/wait_until.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFocalOfWidth = 525.0 / 640.0;
PinholeCamera pinhole(const SimulatedCameraOptions& options) {
  const double focal_px = kFocalOfWidth * options.width_px;
  return {.width_px = options.width_px,
          .height_px = options.height_px,
          .focal_x_px = focal_px,
          .focal_y_px = focal_px,
          .center_x_px = 0.5 * (options.width_px - 1),
          .center_y_px = 0.5 * (options.height_px - 1)};
}

/// What the camera says of itself: the truth, but for the error asked for.
std::shared_ptr<const RgbdCalibration> stated_calibration(PinholeCamera camera,
                                                          double focal_error_percent) {
  camera.focal_x_px *= 1.0 + 0.01 * focal_error_percent;
  camera.focal_y_px *= 1.0 + 0.01 * focal_error_percent;
  return std::make_shared<const RgbdCalibration>(
      RgbdCalibration{camera, camera, Eigen::Isometry3d::Identity()});
}

/// Far enough for the body to fill at most three quarters of the picture, and never nearer than the
/// 600 mm at which a hand holds a tablet; its front must stay within the usual clip at 1 m.
double fitting_distance_mm(const Eigen::AlignedBox3f& bounds, const PinholeCamera& camera) {
  constexpr double kShare = 0.75;
  const Eigen::Vector3d size_mm = bounds.sizes().cast<double>();
  const double for_width = camera.focal_x_px * size_mm.x() / (kShare * camera.width_px);
  const double for_height = camera.focal_y_px * size_mm.z() / (kShare * camera.height_px);
  return std::clamp(std::max(for_width, for_height) - 0.5 * size_mm.y(), 600.0, 750.0);
}

/// The colour sensor's grain, the same for every channel's place in the table of draws.
void add_grain(Image<Rgb8>& color, std::uint64_t seed, std::uint64_t frame_id) {
  static const internal::NormalTable kNormal;
  constexpr float kSd = 1.8F;
  std::array<std::int8_t, 4096> grain{};
  for (std::size_t i = 0; i < grain.size(); ++i) {
    grain[i] = static_cast<std::int8_t>(std::lrint(kSd * kNormal(internal::scramble(seed ^ i))));
  }
  for (int y = 0; y < color.height(); ++y) {
    internal::RowRandom random(~seed, frame_id, static_cast<std::uint64_t>(y));
    auto* bytes = reinterpret_cast<std::uint8_t*>(color.view().row(y));
    // A run of the table at a random place, a new one every 256 bytes.
    for (int begin = 0; begin < 3 * color.width(); begin += 256) {
      const auto* run = grain.data() + (random.next() >> 40U) % (grain.size() - 256);
      const int count = std::min(256, 3 * color.width() - begin);
      for (int i = 0; i < count; ++i) {
        bytes[begin + i] = static_cast<std::uint8_t>(std::clamp(bytes[begin + i] + run[i], 0, 255));
      }
    }
  }
}

Image<std::uint16_t> rounded(const Image<float>& depth_mm) {
  Image<std::uint16_t> result(depth_mm.width(), depth_mm.height());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result.data()[i] = static_cast<std::uint16_t>(std::min(depth_mm.data()[i] + 0.5F, 65535.0F));
  }
  return result;
}

}  // namespace

struct SimulatedCamera::Impl {
  Impl(const std::shared_ptr<const TriangleMesh>& skin, const SimulatedCameraOptions& chosen)
      : options(chosen),
        camera(pinhole(chosen)),
        calibration(stated_calibration(camera, chosen.focal_error_percent)),
        path(skin->bounds(),
             chosen.distance_mm.value_or(fitting_distance_mm(skin->bounds(), camera)),
             chosen.path,
             chosen.seed),
        views(skin, chosen.distance_mm, chosen.seed, chosen.walk_mm),
        scene(*skin,
              camera,
              chosen.seed,
              chosen.skin == SimulatedSkin::kMarked,
              chosen.table_uneven_mm),
        noise(camera.focal_x_px, chosen.seed) {
    if (chosen.bias_mm > 0.0) {
      bias.emplace(chosen.width_px, chosen.height_px, chosen.bias_mm, chosen.seed);
    }
    if (chosen.clutter == SimulatedClutter::kNone) return;
    clutter.emplace(*skin,
                    scene.table_top_mm(),
                    chosen.clutter,
                    chosen.path == SimulatedPath::kViews,
                    chosen.seed);
  }

  [[nodiscard]] double time_s(std::uint64_t frame_id) const {
    return static_cast<double>(frame_id) / options.frames_per_s;
  }
  [[nodiscard]] Clock::duration since_start(std::uint64_t frame_id) const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(time_s(frame_id)));
  }

  SimulatedCameraOptions options;
  PinholeCamera camera;
  std::shared_ptr<const RgbdCalibration> calibration;
  internal::HandPath path;
  internal::ViewPlaces views;
  internal::Scene scene;
  std::optional<internal::Clutter> clutter;
  std::optional<internal::DepthBias> bias;
  internal::KinectNoise noise;
  std::uint64_t next_id = 0;
  std::optional<Clock::time_point> started_at;
};

SimulatedCamera::SimulatedCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SimulatedCamera::~SimulatedCamera() = default;

Result<std::unique_ptr<SimulatedCamera>> SimulatedCamera::create(
    std::shared_ptr<const TriangleMesh> skin, const SimulatedCameraOptions& options) {
  MOR_CHECK(options.check());
  if (!skin || skin->empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the simulated camera needs a case with a skin surface to look at");
  }
  return std::unique_ptr<SimulatedCamera>(
      new SimulatedCamera(std::make_unique<Impl>(skin, options)));
}

const RgbdCalibration& SimulatedCamera::calibration() const {
  return *impl_->calibration;
}

Eigen::Isometry3d SimulatedCamera::ct_from_camera(std::uint64_t frame_id) const {
  if (impl_->options.path == SimulatedPath::kViews) {
    const std::uint64_t hold = impl_->options.frames_a_view;
    return impl_->views.ct_from_camera(frame_id / hold, impl_->time_s(frame_id % hold));
  }
  return impl_->path.ct_from_camera(impl_->time_s(frame_id));
}

std::shared_ptr<RgbdFrame> SimulatedCamera::draw(std::uint64_t frame_id) const {
  const bool is_views = impl_->options.path == SimulatedPath::kViews;
  const std::uint64_t arrangement = is_views ? frame_id / impl_->options.frames_a_view : frame_id;
  const auto things = impl_->clutter ? impl_->clutter->at(arrangement, impl_->time_s(frame_id))
                                     : internal::PaintedMesh{};
  auto picture = impl_->scene.draw(ct_from_camera(frame_id), things);
  if (impl_->bias) impl_->bias->apply(picture.depth.z_mm);
  auto frame = std::make_shared<RgbdFrame>();
  frame->frame_id = frame_id;
  frame->calibration = impl_->calibration;
  frame->color = std::move(picture.color);
  internal::expose(
      frame->color,
      internal::exposure_gains(
          impl_->options.exposure_swing, impl_->options.seed, frame_id, impl_->time_s(frame_id)));
  if (impl_->options.has_noise) {
    frame->depth_mm = impl_->noise.apply(picture.depth, frame_id);
    add_grain(frame->color, impl_->options.seed, frame_id);
  } else {
    frame->depth_mm = rounded(picture.depth.z_mm);
  }
  return frame;
}

std::shared_ptr<const RgbdFrame> SimulatedCamera::frame_at(std::uint64_t frame_id) const {
  auto frame = draw(frame_id);
  frame->captured_at = Clock::time_point(impl_->since_start(frame_id));
  return frame;
}

Result<std::shared_ptr<const RgbdFrame>> SimulatedCamera::next_frame(std::stop_token stop) {
  auto due = Clock::now();
  if (impl_->options.is_real_time) {
    if (!impl_->started_at) impl_->started_at = due;
    const std::chrono::duration<double> running = due - *impl_->started_at;
    const auto current = static_cast<std::uint64_t>(running.count() * impl_->options.frames_per_s);
    impl_->next_id = std::max(impl_->next_id, current);
    due = *impl_->started_at + impl_->since_start(impl_->next_id);
  }
  const bool has_ended =
      impl_->options.num_frames > 0 && impl_->next_id >= impl_->options.num_frames;
  if (stop.stop_requested() || has_ended) return nullptr;
  // Drawn ahead and handed over when it is due, as a sensor does: its age is not the simulation's
  // time.
  auto frame = draw(impl_->next_id++);
  if (impl_->options.is_real_time && !internal::wait_until(due, stop)) return nullptr;
  frame->captured_at = due;
  return frame;
}

}  // namespace mor
