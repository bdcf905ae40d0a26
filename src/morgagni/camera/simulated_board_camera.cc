// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/simulated_board_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/depth_bias.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/kinect_noise.h"
#include "morgagni/camera/internal/random.h"
#include "morgagni/camera/internal/scene/board_view.h"
#include "morgagni/camera/internal/wait_until.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using internal::Draws;
using internal::scramble;

constexpr int kWidthPx = 640;
constexpr int kHeightPx = 480;
constexpr double kFramesPerS = 15.0;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kReferenceMm = 800.0;
/// The wiggle of a time-of-flight camera repeats over the distance; its second harmonic too.
constexpr double kWigglePeriodMm = 900.0;
/// BoardBacking::kTurns.
constexpr std::uint64_t kPosesInAir = 36;
constexpr std::uint64_t kPosesOnWall = 14;
/// On the wall the camera moves, from here on and tilted by at most so much.
constexpr double kNearestOnWallMm = 500.0;
constexpr double kMostTiltOnWallDeg = 15.0;

/// A Kinect v1 as designed, near enough; the time-of-flight camera has the same lenses here.
RgbdCalibration design() {
  RgbdCalibration calibration;
  calibration.depth = {kWidthPx, kHeightPx, 580.0, 580.0, 319.5, 239.5, {}};
  calibration.color = {kWidthPx, kHeightPx, 525.0, 525.0, 319.5, 239.5, {}};
  calibration.color_from_depth.translation().x() = -25.0;
  return calibration;
}

PinholeCamera as_built(PinholeCamera camera, Draws& draw) {
  const double scale = draw(0.98, 1.02);
  camera.focal_x_px *= scale;
  camera.focal_y_px *= scale * draw(0.997, 1.003);
  camera.center_x_px += draw(-7.0, 7.0);
  camera.center_y_px += draw(-7.0, 7.0);
  camera.distortion = {
      draw(-0.14, 0.14), draw(-0.12, 0.12), draw(-0.0015, 0.0015), draw(-0.0015, 0.0015), 0.0};
  return camera;
}

RgbdCalibration as_built(std::uint64_t seed) {
  Draws draw(scramble(seed ^ 0x4255494C54U));
  RgbdCalibration built = design();
  built.depth = as_built(built.depth, draw);
  built.color = as_built(built.color, draw);
  built.color_from_depth.translation() +=
      Eigen::Vector3d(draw(-2.0, 2.0), draw(-1.5, 1.5), draw(-1.5, 1.5));
  const Eigen::Vector3d turn(draw(-0.7, 0.7), draw(-0.7, 0.7), draw(-0.7, 0.7));
  built.color_from_depth.linear() =
      Eigen::AngleAxisd(turn.norm() * kRadPerDeg, turn.normalized()).toRotationMatrix();
  return built;
}

/// A smooth field over the picture whose root mean square is 1.
Image<float> smooth_shape(std::uint64_t seed) {
  Image<float> shape(kWidthPx, kHeightPx, static_cast<float>(kReferenceMm));
  internal::DepthBias(kWidthPx, kHeightPx, 1.0, seed).apply(shape);
  for (std::size_t i = 0; i < shape.size(); ++i) {
    shape.data()[i] -= static_cast<float>(kReferenceMm);
  }
  return shape;
}

Image<std::uint16_t> time_of_flight_noise(const Image<float>& z_mm,
                                          std::uint64_t seed,
                                          std::uint64_t frame_id) {
  static const internal::NormalTable kNormal;
  Image<std::uint16_t> seen(z_mm.width(), z_mm.height());
  for (int y = 0; y < z_mm.height(); ++y) {
    internal::RowRandom random(seed, frame_id, static_cast<std::uint64_t>(y));
    for (int x = 0; x < z_mm.width(); ++x) {
      const float z = z_mm(x, y);
      const float sd_mm = 0.8F + 0.8F * (z / 1000.0F) * (z / 1000.0F);
      const float noisy = z + sd_mm * kNormal(random.next() >> 20U);
      seen(x, y) = static_cast<std::uint16_t>(std::clamp(noisy + 0.5F, 0.0F, 65535.0F));
    }
  }
  return seen;
}

}  // namespace

struct SimulatedBoardCamera::Impl {
  Impl(BoardPicture picture, const SimulatedBoardOptions& chosen)
      : options(chosen),
        built(as_built(chosen.seed)),
        size_mm(picture.mm_per_px * picture.brightness.width(),
                picture.mm_per_px * picture.brightness.height()),
        center_mm(picture.first_px_mm + 0.5 * size_mm),
        color_view(picture, built.color),
        depth_view(std::move(picture), built.depth),
        noise(built.depth.focal_x_px, chosen.seed),
        offset(smooth_shape(scramble(chosen.seed ^ 1U))),
        slope(smooth_shape(scramble(chosen.seed ^ 2U))) {
    stated = std::make_shared<const RgbdCalibration>(stated_calibration());
    Draws draw(scramble(chosen.seed ^ 0x57494747U));
    wiggle_phase = {draw(0.0, 2.0 * std::numbers::pi), draw(0.0, 2.0 * std::numbers::pi)};
  }

  [[nodiscard]] RgbdCalibration stated_calibration() const {
    RgbdCalibration calibration = design();
    if (options.shows_infrared) {
      calibration.color = calibration.depth;
      calibration.color_from_depth.setIdentity();
    }
    return calibration;
  }

  [[nodiscard]] bool is_on_wall(std::uint64_t pose) const {
    if (options.backing != BoardBacking::kTurns) return options.backing == BoardBacking::kWall;
    return pose % (kPosesInAir + kPosesOnWall) >= kPosesInAir;
  }

  /// Poses go through the picture's parts in turn, near and far, with all kinds of tilts.
  [[nodiscard]] Eigen::Isometry3d color_from_board(std::uint64_t pose) const {
    Draws draw(scramble(scramble(options.seed ^ 0x504F5345U) ^ pose));
    const double part = static_cast<double>((pose * 4) % 9);
    const double share_x = (std::fmod(part, 3.0) + draw(0.2, 0.8)) / 3.0;
    const double share_y = (std::floor(part / 3.0) + draw(0.2, 0.8)) / 3.0;
    const double step = std::fmod(0.618034 * static_cast<double>(pose) + draw(0.0, 0.1), 1.0);
    const bool is_turned_to_wall = options.backing == BoardBacking::kTurns && is_on_wall(pose);
    const double near_mm = is_turned_to_wall
                               ? std::clamp(kNearestOnWallMm, options.near_mm, options.far_mm)
                               : options.near_mm;
    const double tilt_deg =
        is_turned_to_wall ? std::min(kMostTiltOnWallDeg, options.tilt_deg) : options.tilt_deg;
    const double z_mm = near_mm + step * (options.far_mm - near_mm);
    // Near ones stay in the picture with their middle, far ones may go to its rim.
    const double reach = std::clamp(z_mm / 900.0, 0.45, 0.8);
    const Eigen::Vector2d pixel((0.5 + reach * (share_x - 0.5)) * kWidthPx,
                                (0.5 + reach * (share_y - 0.5)) * kHeightPx);
    const double towards_rad = draw(0.0, 2.0 * std::numbers::pi);
    const double tilt_rad = kRadPerDeg * tilt_deg * std::sqrt(draw(0.1, 1.0));
    const Eigen::Matrix3d turned =
        (Eigen::AngleAxisd(tilt_rad,
                           Eigen::Vector3d(std::cos(towards_rad), std::sin(towards_rad), 0.0)) *
         Eigen::AngleAxisd(kRadPerDeg * draw(-18.0, 18.0), Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = turned;
    const Eigen::Vector3d middle(center_mm.x(), center_mm.y(), 0.0);
    result.translation() = z_mm * built.color.ray(pixel).homogeneous() - turned * middle;
    return result;
  }

  [[nodiscard]] Eigen::Isometry3d depth_from_board(std::uint64_t pose) const {
    return built.color_from_depth.inverse() * color_from_board(pose);
  }

  [[nodiscard]] double bias_mm(int x, int y, double z_mm) const {
    const double along = z_mm / kReferenceMm;
    const auto base = static_cast<double>(offset(x, y));
    const auto other = static_cast<double>(slope(x, y));
    // Both parts together have about the root mean square asked for, at 800 mm.
    const double share = options.bias_mm * std::numbers::sqrt2 / 2.0;
    if (!options.is_time_of_flight) {
      // 1 / z_seen = (1 + a) / z + b, with a and b of the picture's place.
      const double a = -share * base / kReferenceMm;
      const double b = -share * other / (kReferenceMm * kReferenceMm);
      return z_mm / (1.0 + a + b * z_mm) - z_mm;
    }
    const double turn = 2.0 * std::numbers::pi * z_mm / kWigglePeriodMm;
    const double wiggle =
        std::sin(turn + wiggle_phase[0]) + 0.4 * std::sin(2.0 * turn + wiggle_phase[1]);
    return share * (base + wiggle * std::min(along, 1.5));
  }

  /// What all frames of a pose have in common.
  struct Drawn {
    std::uint64_t pose = 0;
    Image<float> color;
    internal::IdealDepth depth;
  };

  [[nodiscard]] Drawn draw(std::uint64_t pose) const {
    Drawn drawn{.pose = pose, .color = {}, .depth = biased_depth(pose)};
    if (!options.shows_infrared) {
      drawn.color = color_view.drawn(color_from_board(pose), is_on_wall(pose));
    }
    return drawn;
  }

  [[nodiscard]] internal::IdealDepth biased_depth(std::uint64_t pose) const {
    auto ideal = depth_view.depth(depth_from_board(pose), is_on_wall(pose));
    if (options.bias_mm > 0.0) {
      for (int y = 0; y < kHeightPx; ++y) {
        for (int x = 0; x < kWidthPx; ++x) {
          float& z_mm = ideal.z_mm(x, y);
          if (z_mm > 0.0F) {
            z_mm += static_cast<float>(bias_mm(x, y, static_cast<double>(z_mm)));
          }
        }
      }
    }
    return ideal;
  }

  [[nodiscard]] internal::BoardLook look(std::uint64_t frame_id, double grain) const {
    return {.blur_px = options.blur_px,
            .grain = grain,
            .seed = scramble(options.seed ^ scramble(frame_id))};
  }

  [[nodiscard]] Image<Rgb8> infrared_at(std::uint64_t pose) const {
    // Without the emitter a depth camera has little light: half the contrast, twice the grain.
    return depth_view.picture(depth_view.drawn(depth_from_board(pose), is_on_wall(pose)),
                              look(~pose, 2.0 * options.grain),
                              /*contrast=*/0.5);
  }

  [[nodiscard]] std::shared_ptr<RgbdFrame> frame_of(const Drawn& drawn,
                                                    std::uint64_t repeat) const {
    const std::uint64_t frame_id = scramble(drawn.pose) ^ repeat;
    auto frame = std::make_shared<RgbdFrame>();
    frame->calibration = stated;
    frame->color =
        options.shows_infrared
            ? infrared_at(drawn.pose)
            : color_view.picture(drawn.color, look(frame_id, options.grain), /*contrast=*/1.0);
    frame->depth_mm = options.is_time_of_flight
                          ? time_of_flight_noise(drawn.depth.z_mm, options.seed, frame_id)
                          : noise.apply(drawn.depth, frame_id);
    return frame;
  }

  SimulatedBoardOptions options;
  RgbdCalibration built;
  Eigen::Vector2d size_mm;
  Eigen::Vector2d center_mm;
  internal::BoardView color_view;
  internal::BoardView depth_view;
  internal::KinectNoise noise;
  Image<float> offset;
  Image<float> slope;
  std::array<double, 2> wiggle_phase{};
  std::shared_ptr<const RgbdCalibration> stated;
  std::uint64_t next_id = 0;
  std::uint64_t last_pose = 0;
  std::optional<Drawn> last_drawn;  ///< next_frame()'s alone.
  std::optional<Clock::time_point> started_at;
};

SimulatedBoardCamera::SimulatedBoardCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SimulatedBoardCamera::~SimulatedBoardCamera() = default;

Result<std::unique_ptr<SimulatedBoardCamera>> SimulatedBoardCamera::create(
    BoardPicture board, const SimulatedBoardOptions& options) {
  MOR_CHECK(options.check());
  if (board.brightness.empty() || !(board.mm_per_px > 0.0)) {
    return make_error(ErrorCode::kInvalidArgument, "the simulated board has no picture");
  }
  return std::unique_ptr<SimulatedBoardCamera>(
      new SimulatedBoardCamera(std::make_unique<Impl>(std::move(board), options)));
}

const RgbdCalibration& SimulatedBoardCamera::calibration() const {
  return *impl_->stated;
}

const RgbdCalibration& SimulatedBoardCamera::truth() const {
  return impl_->built;
}

Eigen::Isometry3d SimulatedBoardCamera::depth_from_board(std::uint64_t pose) const {
  return impl_->depth_from_board(pose);
}

double SimulatedBoardCamera::bias_mm(int x_px, int y_px, double z_mm) const {
  return impl_->bias_mm(x_px, y_px, z_mm);
}

Image<Rgb8> SimulatedBoardCamera::infrared_at(std::uint64_t pose) const {
  return impl_->infrared_at(pose);
}

std::shared_ptr<const RgbdFrame> SimulatedBoardCamera::frame_at(std::uint64_t pose,
                                                                std::uint64_t repeat) const {
  return impl_->frame_of(impl_->draw(pose), repeat);
}

Result<Image<Rgb8>> SimulatedBoardCamera::infrared_picture(std::stop_token /*stop*/) {
  return infrared_at(impl_->last_pose);
}

Result<std::shared_ptr<const RgbdFrame>> SimulatedBoardCamera::next_frame(std::stop_token stop) {
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / kFramesPerS));
  const auto per_pose =
      static_cast<std::uint64_t>(std::max(1.0, std::round(impl_->options.hold_s * kFramesPerS)));
  if (!impl_->started_at) impl_->started_at = Clock::now();
  if (impl_->options.is_real_time) {
    const auto current = static_cast<std::uint64_t>((Clock::now() - *impl_->started_at) / period);
    impl_->next_id = std::max(impl_->next_id, current);
  }
  if (stop.stop_requested()) return nullptr;
  const std::uint64_t id = impl_->next_id++;
  impl_->last_pose = id / per_pose;
  if (!impl_->last_drawn || impl_->last_drawn->pose != impl_->last_pose) {
    impl_->last_drawn = impl_->draw(impl_->last_pose);
  }
  auto frame = impl_->frame_of(*impl_->last_drawn, id % per_pose);
  frame->frame_id = id;
  frame->captured_at = *impl_->started_at + static_cast<std::int64_t>(id) * period;
  if (impl_->options.is_real_time && !internal::wait_until(frame->captured_at, stop)) {
    return nullptr;
  }
  return frame;
}

Result<SimulatedBoardOptions> SimulatedBoardOptions::parse(std::string_view text) {
  SimulatedBoardOptions options;
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    if (pair.key == "seed") {
      MOR_TRY(options.seed, internal::parse_count(pair, 0, UINT64_MAX));
    } else if (pair.key == "sensor") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"kinect", "tof"}));
      options.is_time_of_flight = choice == 1;
    } else if (pair.key == "bias") {
      MOR_TRY(options.bias_mm, internal::parse_number(pair, 0.0, 20.0));
    } else if (pair.key == "blur") {
      MOR_TRY(options.blur_px, internal::parse_number(pair, 0.0, 5.0));
    } else if (pair.key == "grain") {
      MOR_TRY(options.grain, internal::parse_number(pair, 0.0, 30.0));
    } else if (pair.key == "wall") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"0", "1", "turns"}));
      options.backing = static_cast<BoardBacking>(choice);
    } else if (pair.key == "near") {
      MOR_TRY(options.near_mm, internal::parse_number(pair, 250.0, 3000.0));
    } else if (pair.key == "far") {
      MOR_TRY(options.far_mm, internal::parse_number(pair, 250.0, 3000.0));
    } else if (pair.key == "tilt") {
      MOR_TRY(options.tilt_deg, internal::parse_number(pair, 0.0, 60.0));
    } else if (pair.key == "hold") {
      MOR_TRY(options.hold_s, internal::parse_number(pair, 0.2, 60.0));
    } else if (pair.key == "infrared") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"0", "1"}));
      options.shows_infrared = choice == 1;
    } else if (pair.key == "speed") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"real", "full"}));
      options.is_real_time = choice == 0;
    } else {
      return internal::unknown_key("simulated-board",
                                   pair,
                                   {"seed",
                                    "sensor",
                                    "bias",
                                    "blur",
                                    "grain",
                                    "wall",
                                    "near",
                                    "far",
                                    "tilt",
                                    "hold",
                                    "infrared",
                                    "speed"});
    }
  }
  MOR_CHECK(options.check());
  return options;
}

Result<void> SimulatedBoardOptions::check() const {
  const auto in = [](double value, double least, double most) {
    return value >= least && value <= most;
  };
  if (!in(near_mm, 250.0, 3000.0) || !in(far_mm, near_mm, 3000.0)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "near must be in [250, 3000] and far in [near, 3000], got {} and {}", near_mm, far_mm));
  }
  if (in(bias_mm, 0.0, 20.0) && in(blur_px, 0.0, 5.0) && in(grain, 0.0, 30.0) &&
      in(tilt_deg, 0.0, 60.0) && in(hold_s, 0.2, 60.0)) {
    return {};
  }
  return make_error(ErrorCode::kInvalidArgument,
                    "bias must be in [0, 20], blur in [0, 5], grain in [0, 30], tilt in [0, 60], "
                    "hold in [0.2, 60]");
}

}  // namespace mor
