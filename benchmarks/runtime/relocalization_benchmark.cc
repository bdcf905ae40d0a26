// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// How long the live path needs to find the body again by itself: the camera is covered for a
// while and comes back at another place of its path, again and again.
//   relocalization_benchmark CASE [simulated:OPTIONS] [TIMES]

#include <chrono>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/statistics.h"
#include "morgagni/session/live_loop.h"

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kInView = 75;      ///< Frames, at 30 a second.
constexpr std::uint64_t kCovered = 30;     ///< Longer than what only holds the last pose.
constexpr std::uint64_t kElsewhere = 331;  ///< So many frames on along the path.
constexpr std::uint16_t kCoverMm = 120;
constexpr double kRightMm = 5.0;

/// Frame `n` of the run: which one of the path's, and whether a hand covers the camera.
struct Moment {
  std::uint64_t path_frame;
  bool is_covered;
  std::uint64_t round;
};
Moment moment(std::uint64_t n) {
  const std::uint64_t round = n / (kInView + kCovered);
  const std::uint64_t within = n % (kInView + kCovered);
  return {round * kElsewhere + within, within < kCovered, round};
}

/// A simulated camera that somebody covers now and then.
class CoveredCamera : public mor::RangeCamera {
 public:
  explicit CoveredCamera(const mor::SimulatedCamera& camera) : camera_(camera) {}

  [[nodiscard]] mor::Result<std::shared_ptr<const mor::RgbdFrame>> next_frame(
      std::stop_token stop) override {
    const auto n = static_cast<std::uint64_t>((Clock::now() - began_) / kPeriod) + 1;
    std::this_thread::sleep_until(began_ + n * kPeriod);
    if (stop.stop_requested()) return nullptr;
    const Moment now = moment(n);
    auto frame = std::make_shared<mor::RgbdFrame>(*camera_.frame_at(now.path_frame));
    frame->frame_id = n;
    frame->captured_at = Clock::now();
    if (now.is_covered) {
      frame->depth_mm =
          mor::Image<std::uint16_t>(frame->depth_mm.width(), frame->depth_mm.height(), kCoverMm);
    }
    return frame;
  }
  [[nodiscard]] const mor::RgbdCalibration& calibration() const override {
    return camera_.calibration();
  }

 private:
  static constexpr std::chrono::microseconds kPeriod{33333};
  const mor::SimulatedCamera& camera_;
  const Clock::time_point began_ = Clock::now();
};

/// From the first frame in view to the first good one, of each time.
class Watch {
 public:
  Watch(const mor::SimulatedCamera& camera, const Eigen::Vector3d& center_ct)
      : camera_(camera), center_ct_(center_ct) {}

  void look(const mor::TrackedFrame& tracked) {
    const Moment now = moment(tracked.frame->frame_id);
    const std::scoped_lock lock(mutex_);
    if (now.is_covered) return;
    if (!came_back_ || round_ != now.round) {
      came_back_ = tracked.frame->captured_at;
      round_ = now.round;
      is_found_ = false;
      ++num_times_;
    }
    if (is_found_ || tracked.state != mor::TrackingState::kTracking) return;
    is_found_ = true;
    const Eigen::Isometry3d off =
        *tracked.ct_from_depth * camera_.ct_from_camera(now.path_frame).inverse();
    const double error_mm = (off * center_ct_ - center_ct_).norm();
    if (error_mm > kRightMm) ++num_wrong_;
    times_ms_.push_back(
        std::chrono::duration<double, std::milli>(Clock::now() - *came_back_).count());
  }

  [[nodiscard]] std::string table() const {
    const std::scoped_lock lock(mutex_);
    return fmt::format(
        "| figure | value |\n|---|---|\n| times the camera came back | {} |\n| found again | {} |\n"
        "| of these wrong (more than {} mm) | {} |\n| until found, median / p95 / max | {:.0f} / "
        "{:.0f} / {:.0f} ms |\n",
        num_times_,
        times_ms_.size(),
        kRightMm,
        num_wrong_,
        mor::quantile(times_ms_, 0.5),
        mor::quantile(times_ms_, 0.95),
        mor::quantile(times_ms_, 1.0));
  }

 private:
  const mor::SimulatedCamera& camera_;
  const Eigen::Vector3d center_ct_;
  mutable std::mutex mutex_;
  std::optional<Clock::time_point> came_back_;
  std::uint64_t round_ = 0;
  bool is_found_ = false;
  int num_times_ = 0;
  int num_wrong_ = 0;
  std::vector<double> times_ms_;
};

int fail(const std::string& message) {
  fmt::print(stderr, "{}\n", message);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return fail("usage: relocalization_benchmark CASE [simulated:OPTIONS] [TIMES]");
  const std::string name = argc > 2 ? argv[2] : "simulated:";
  const int times = argc > 3 ? std::atoi(argv[3]) : 20;

  auto body = mor::load_case(argv[1]);
  if (!body) return fail(body.error().message);
  const auto skin = std::shared_ptr<const mor::TriangleMesh>(body->skin, &body->skin->mesh);
  const auto options = mor::SimulatedCameraOptions::parse(name.substr(name.find(':') + 1));
  if (!options) return fail(options.error().message);
  const auto camera = mor::SimulatedCamera::create(skin, *options);
  if (!camera) return fail(camera.error().message);

  Watch watch(**camera, skin->bounds().center().cast<double>());
  const auto loop = mor::LiveLoop::create(std::make_shared<const mor::Case>(*std::move(body)),
                                          std::make_unique<CoveredCamera>(**camera),
                                          mor::LiveLoopOptions{});
  if (!loop) return fail(loop.error().message);
  (*loop)->observe([&watch](const mor::TrackedFrame& tracked) { watch.look(tracked); });
  if (const auto runs = (*loop)->run([](auto, const auto&) {}); !runs) {
    return fail(runs.error().message);
  }
  std::this_thread::sleep_for(
      std::chrono::milliseconds(static_cast<std::int64_t>(times) *
                                static_cast<std::int64_t>((kInView + kCovered) * 1000 / 30)));
  (*loop)->stop();
  fmt::print("{}", watch.table());
  return 0;
}
