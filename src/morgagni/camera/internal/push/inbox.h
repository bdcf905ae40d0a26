// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "morgagni/camera/internal/push/client_channels.h"
#include "morgagni/camera/range_camera.h"

namespace mor::internal::push {

/// A depth and a colour picture that belong together, still packed, and when the later one came.
struct Pair {
  std::shared_ptr<const RgbdCalibration> calibration;
  std::string device_id;  ///< Empty: the device has not said who it is.
  Picture depth;
  Picture color;
  std::chrono::steady_clock::time_point arrived_at;
};

struct InboxOptions {
  std::chrono::nanoseconds tolerance = std::chrono::milliseconds(20);  ///< Stamps of a pair, apart.
  /// Where it is known already: what the device says of itself is not used then.
  std::shared_ptr<const RgbdCalibration> calibration = nullptr;
  std::string device_id = {};   ///< In place of what the device calls itself.
  KnownCalibration known = {};  ///< Asked for a device with an id. May read a file.
};

/// Between the network's thread, which puts messages in, and the camera's, which takes pairs out:
/// the newest wins, and never more than a few pictures wait.
class Inbox {
 public:
  Inbox(std::string address, InboxOptions options);

  // The network's side.

  void device_came();
  void device_went();
  /// What it calls itself, an id: "904412060323" becomes "push-904412060323".
  void device_is(const std::string& name);
  /// @errors kInvalidArgument: stamps that go backward or jump; cameras that do not fit together.
  [[nodiscard]] Result<void> put(Arrival arrival, std::chrono::steady_clock::time_point now);
  /// A message that could not be read; said to whoever waits for a frame.
  void refuse(const std::string& sentence);

  // The camera's side.

  /// The next pair. None: `timeout` is over, or `stop` was requested.
  [[nodiscard]] std::optional<Pair> wait(std::chrono::milliseconds timeout, std::stop_token stop);
  /// Why there is none.
  [[nodiscard]] std::string reason() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Waiting {
    std::string topic;
    Picture picture;
    bool is_depth = false;
  };
  /// A stamp and when it came: the device's clock against ours.
  struct ClockPoint {
    std::uint64_t stamp_ns = 0;
    Clock::time_point at;
  };

  // All need the lock.
  Result<void> put_picture(std::string topic, Picture picture, Clock::time_point now);
  Result<void> check_clock(std::uint64_t stamp_ns, Clock::time_point now);
  Result<void> pair_up(const Waiting& depth, const Waiting& color, Clock::time_point now);
  Result<std::shared_ptr<const RgbdCalibration>> calibration_for(const Waiting& depth,
                                                                 const Waiting& color);
  Result<PinholeCamera> camera_for(const Waiting& picture) const;
  Result<Eigen::Isometry3d> between(const std::string& color, const std::string& depth) const;
  void forget();

  const std::string address_;
  const InboxOptions options_;

  mutable std::mutex mutex_;  ///< Guards all below.
  std::condition_variable_any changed_;
  bool has_device_ = false;
  std::optional<Pair> next_;
  std::deque<Waiting> waiting_;
  std::map<std::string, CameraInfo> infos_;      ///< By topic.
  std::map<std::string, Transform> transforms_;  ///< By child.
  std::string device_id_;
  RgbdCalibration last_said_;  ///< By the device, when `last_calibration_` was made.
  std::string last_device_id_;
  std::shared_ptr<const RgbdCalibration> last_calibration_;
  std::optional<ClockPoint> last_depth_;
  std::string fault_;
  std::optional<Clock::time_point> fault_at_;
};

}  // namespace mor::internal::push
