// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/watched_camera.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/wait_until.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using FramePtr = std::shared_ptr<const RgbdFrame>;

constexpr std::chrono::milliseconds kMaxAhead{1000};

/// What the threads of one watched camera share. It outlives the camera where a driver hangs.
struct Shared {
  CameraOpener open;
  WatchOptions options;
  std::shared_ptr<const RgbdCalibration> calibration;
  std::string device_id;
  std::atomic<int> num_running = 0;  ///< Threads that are in, or behind, a driver.

  std::mutex mutex;  ///< Guards all below.
  std::condition_variable_any changed;
  std::uint64_t run = 0;  ///< Only the thread of this number is listened to.
  FramePtr next;
  bool has_ended = false;
  std::string reason;  ///< Why there is no frame.
  std::optional<Clock::time_point> last_captured_at;
  Clock::time_point last_sign_of_life = Clock::now();
};

/// Why the frame is none. Empty: it is good.
std::string fault_of(const RgbdFrame& frame,
                     const RgbdCalibration& calibration,
                     const std::optional<Clock::time_point>& last_captured_at) {
  const auto has_size = [](const auto& image, const PinholeCamera& camera) {
    return image.width() == camera.width_px && image.height() == camera.height_px;
  };
  if (!frame.calibration || *frame.calibration != calibration) {
    return "another camera, or with another calibration, has come in its place: start again";
  }
  if (!has_size(frame.depth_mm, calibration.depth) || !has_size(frame.color, calibration.color)) {
    return "it sends pictures of a wrong size";
  }
  if (frame.captured_at > Clock::now() + kMaxAhead) return "its clock is ahead of ours";
  if (last_captured_at && frame.captured_at <= *last_captured_at) return "its clock goes backward";
  return {};
}

/// One life of the device after another, until it is to stop or is left behind.
class Keeper {
 public:
  Keeper(std::shared_ptr<Shared> shared, std::uint64_t run, std::stop_token stop)
      : shared_(std::move(shared)), run_(run), stop_(std::move(stop)) {}

  void keep(std::unique_ptr<RangeCamera> camera) {
    while (is_wanted()) {
      if (!camera) camera = opened();
      if (camera) follow(*camera);
      camera.reset();
      internal::wait_until(Clock::now() + shared_->options.retry, stop_);
    }
  }

 private:
  [[nodiscard]] bool is_wanted() const {
    const std::lock_guard lock(shared_->mutex);
    return !stop_.stop_requested() && shared_->run == run_ && !shared_->has_ended;
  }

  std::unique_ptr<RangeCamera> opened() {
    auto camera = shared_->open();
    if (camera) return *std::move(camera);
    complain(camera.error().message);
    return nullptr;
  }

  /// Until it fails.
  void follow(RangeCamera& camera) {
    auto good_at = Clock::now();
    while (is_wanted()) {
      auto frame = camera.next_frame(stop_);
      if (stop_.stop_requested()) return;
      if (!frame) return complain(frame.error().message);
      if (!*frame) return end();
      if (pass_on(*std::move(frame))) {
        good_at = Clock::now();
      } else if (Clock::now() - good_at > shared_->options.silence) {
        return;  // Nothing but garbage: perhaps opening it anew helps.
      }
    }
  }

  bool pass_on(FramePtr frame) {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->run != run_) return false;
    shared_->last_sign_of_life = Clock::now();
    auto fault = fault_of(*frame, *shared_->calibration, shared_->last_captured_at);
    if (!fault.empty()) {
      shared_->reason = std::move(fault);
      return false;
    }
    shared_->last_captured_at = frame->captured_at;
    shared_->next = std::move(frame);
    shared_->changed.notify_all();
    return true;
  }

  void end() {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->run != run_) return;
    shared_->has_ended = true;
    shared_->changed.notify_all();
  }

  void complain(std::string reason) {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->run != run_) return;
    shared_->last_sign_of_life = Clock::now();
    shared_->reason = std::move(reason);
  }

  std::shared_ptr<Shared> shared_;
  std::uint64_t run_;
  std::stop_token stop_;
};

class WatchedCamera final : public RangeCamera {
 public:
  WatchedCamera(std::shared_ptr<Shared> shared, std::unique_ptr<RangeCamera> camera)
      : shared_(std::move(shared)) {
    begin(std::move(camera));
  }

  ~WatchedCamera() override {
    stop_.request_stop();
    // A driver that does not come back is not waited for longer than it has hung already.
    std::unique_lock lock(shared_->mutex);
    ++shared_->run;
    shared_->changed.wait_for(
        lock, shared_->options.give_up, [this] { return shared_->num_running == 0; });
  }

  Result<FramePtr> next_frame(std::stop_token stop) override {
    const auto until = Clock::now() + shared_->options.silence;
    std::unique_lock lock(shared_->mutex);
    shared_->changed.wait_until(
        lock, stop, until, [this] { return shared_->next != nullptr || shared_->has_ended; });
    if (shared_->next) {
      shared_->reason.clear();
      return std::exchange(shared_->next, nullptr);
    }
    if (stop.stop_requested() || shared_->has_ended) return nullptr;
    return make_error(ErrorCode::kDevice, why_silent());
  }

  const RgbdCalibration& calibration() const override { return *shared_->calibration; }
  std::string device_id() const override { return shared_->device_id; }

 private:
  /// Needs the lock. Leaves a driver behind that hangs.
  std::string why_silent() {
    const auto silent = Clock::now() - shared_->last_sign_of_life;
    if (silent > shared_->options.give_up) {
      if (shared_->num_running <= shared_->options.max_left_behind) {
        log::warn("the camera's driver hangs and is left behind");
        begin(nullptr);
      }
      return "the camera's driver hangs: unplug the camera and plug it in again";
    }
    if (!shared_->reason.empty()) return shared_->reason;
    return "the camera sends nothing";
  }

  /// Needs the lock, or that nobody else is there yet.
  void begin(std::unique_ptr<RangeCamera> camera) {
    const auto run = ++shared_->run;
    shared_->last_sign_of_life = Clock::now();
    ++shared_->num_running;
    // Detached: a thread that hangs in a driver cannot be joined. Its count says that it is there.
    std::thread([shared = shared_,
                 run,
                 stop = stop_.get_token(),
                 held = std::move(camera)]() mutable {
      Keeper(shared, run, stop).keep(std::move(held));
      const std::lock_guard lock(shared->mutex);
      --shared->num_running;
      shared->changed.notify_all();
    }).detach();
  }

  std::shared_ptr<Shared> shared_;
  std::stop_source stop_;
};

}  // namespace

Result<void> WatchOptions::check() const {
  if (silence.count() > 0 && retry.count() > 0 && give_up.count() > 0 && max_left_behind >= 1) {
    return {};
  }
  return make_error(ErrorCode::kInvalidArgument,
                    "silence, retry and give_up must be > 0 and max_left_behind >= 1");
}

Result<std::unique_ptr<RangeCamera>> watch_camera(CameraOpener open, const WatchOptions& options) {
  MOR_CHECK(options.check());
  MOR_TRY(auto camera, open());
  auto shared = std::make_shared<Shared>();
  shared->open = std::move(open);
  shared->options = options;
  shared->calibration = std::make_shared<const RgbdCalibration>(camera->calibration());
  shared->device_id = camera->device_id();
  return std::make_unique<WatchedCamera>(std::move(shared), std::move(camera));
}

}  // namespace mor
