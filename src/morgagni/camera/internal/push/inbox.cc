// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/inbox.h"

#include <algorithm>

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/calibration_file.h"
#include "morgagni/camera/internal/push/picture_decoder.h"

namespace mor::internal::push {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMaxWaiting = 4;  ///< Of depth and of colour each.
constexpr std::size_t kMaxKept = 64;    ///< CameraInfos, and transforms.
constexpr nanoseconds kMaxJump = std::chrono::seconds(1);
constexpr std::chrono::seconds kFaultIsFresh{2};

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

double seconds(nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

nanoseconds apart(std::uint64_t a, std::uint64_t b) {
  return nanoseconds(a > b ? a - b : b - a);
}

/// "/camera/depth" of "/camera/depth/camera_info".
std::string_view folder(std::string_view topic) {
  const auto slash = topic.rfind('/');
  return topic.substr(0, slash == std::string_view::npos ? 0 : slash);
}

bool is_within(std::string_view topic, std::string_view of) {
  return topic.starts_with(of) && (topic.size() == of.size() || topic[of.size()] == '/');
}

}  // namespace

Inbox::Inbox(std::string address, InboxOptions options)
    : address_(std::move(address)), options_(std::move(options)), device_id_(options_.device_id) {}

void Inbox::device_came() {
  const std::lock_guard lock(mutex_);
  forget();
  has_device_ = true;
}

void Inbox::device_went() {
  const std::lock_guard lock(mutex_);
  forget();
  has_device_ = false;
}

void Inbox::device_is(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (options_.device_id.empty()) device_id_ = "push-" + name;
}

void Inbox::forget() {
  device_id_ = options_.device_id;
  waiting_.clear();
  infos_.clear();
  transforms_.clear();
  last_depth_.reset();
  next_.reset();
  fault_at_.reset();
}

void Inbox::refuse(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  fault_ = sentence;
  fault_at_ = Clock::now();
}

Result<void> Inbox::put(Arrival arrival, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (auto* picture = std::get_if<Picture>(&arrival.message)) {
    return put_picture(std::move(arrival.topic), std::move(*picture), now);
  }
  if (auto* info = std::get_if<CameraInfo>(&arrival.message)) {
    if (infos_.size() >= kMaxKept && !infos_.contains(arrival.topic)) {
      return bad(fmt::format("more than {} CameraInfos", kMaxKept));
    }
    infos_[arrival.topic] = std::move(*info);
    return {};
  }
  for (auto& transform : std::get<std::vector<Transform>>(arrival.message)) {
    if (transforms_.size() >= kMaxKept && !transforms_.contains(transform.child)) {
      return bad(fmt::format("more than {} transforms", kMaxKept));
    }
    transforms_[transform.child] = std::move(transform);
  }
  return {};
}

Result<void> Inbox::put_picture(std::string topic, Picture picture, Clock::time_point now) {
  const bool is_depth_picture = is_depth(picture);
  if (is_depth_picture) MOR_CHECK(check_clock(picture.stamp_ns, now));
  Waiting come{std::move(topic), std::move(picture), is_depth_picture};
  const auto distance = [&](const Waiting& other) {
    return other.is_depth == come.is_depth ? nanoseconds::max()
                                           : apart(other.picture.stamp_ns, come.picture.stamp_ns);
  };
  const auto nearest = std::ranges::min_element(waiting_, {}, distance);
  if (nearest != waiting_.end() && distance(*nearest) <= options_.tolerance) {
    const auto paired =
        pair_up(come.is_depth ? come : *nearest, come.is_depth ? *nearest : come, now);
    // Depth is used once; what is older than it will find no partner any more.
    const auto depth_stamp = (come.is_depth ? come : *nearest).picture.stamp_ns;
    std::erase_if(waiting_, [&](const Waiting& other) {
      return other.is_depth && other.picture.stamp_ns <= depth_stamp;
    });
    if (!come.is_depth) waiting_.push_back(std::move(come));
    if (!paired) return paired;
  } else {
    waiting_.push_back(std::move(come));
  }
  for (const bool kind : {true, false}) {
    const auto is_kind = [&](const Waiting& other) { return other.is_depth == kind; };
    if (std::ranges::count_if(waiting_, is_kind) > static_cast<std::ptrdiff_t>(kMaxWaiting)) {
      waiting_.erase(std::ranges::find_if(waiting_, is_kind));
    }
  }
  return {};
}

Result<void> Inbox::check_clock(std::uint64_t stamp_ns, Clock::time_point now) {
  const auto last = std::exchange(last_depth_, ClockPoint{stamp_ns, now});
  if (!last) return {};
  if (stamp_ns <= last->stamp_ns) {
    return bad(stamp_ns == last->stamp_ns ? "the stamps of the depth pictures stand still"
                                          : "the stamps of the depth pictures go backward");
  }
  const auto jump = apart(stamp_ns, last->stamp_ns) - nanoseconds(now - last->at);
  if (std::chrono::abs(jump) <= kMaxJump) return {};
  return bad(fmt::format("the device's clock jumps by {:.1f} s", seconds(jump)));
}

Result<void> Inbox::pair_up(const Waiting& depth, const Waiting& color, Clock::time_point now) {
  MOR_TRY(auto calibration, calibration_for(depth, color));
  next_ = Pair{std::move(calibration), device_id_, depth.picture, color.picture, now};
  changed_.notify_all();
  return {};
}

Result<std::shared_ptr<const RgbdCalibration>> Inbox::calibration_for(const Waiting& depth,
                                                                      const Waiting& color) {
  if (options_.calibration) return options_.calibration;
  RgbdCalibration calibration;
  MOR_TRY(calibration.depth, camera_for(depth));
  MOR_TRY(calibration.color, camera_for(color));
  MOR_TRY(calibration.color_from_depth, between(color.picture.frame, depth.picture.frame));
  // Asked once for each device: a reconnection brings back what it had.
  if (!last_calibration_ || last_said_ != calibration || last_device_id_ != device_id_) {
    MOR_TRY(auto chosen, choose_calibration({}, options_.known, device_id_, calibration));
    last_calibration_ = std::make_shared<const RgbdCalibration>(std::move(chosen));
    last_said_ = std::move(calibration);
    last_device_id_ = device_id_;
  }
  return last_calibration_;
}

/// ROS keeps a camera's info in the folder of its pictures, which transports may put one deeper.
Result<PinholeCamera> Inbox::camera_for(const Waiting& picture) const {
  const CameraInfo* best = nullptr;
  std::size_t best_size = 0;
  for (const auto& [topic, info] : infos_) {
    const auto place = folder(topic);
    if (!is_within(picture.topic, place) || (best != nullptr && place.size() <= best_size))
      continue;
    best = &info;
    best_size = place.size();
  }
  if (best == nullptr) {
    return bad(fmt::format(
        "{} has no CameraInfo beside it: send one, or start with calibration=FILE", picture.topic));
  }
  if (picture.topic.find("image_rect") == std::string::npos) return best->as_seen;
  if (best->rectified) return *best->rectified;
  return bad(fmt::format("{} is rectified, but its CameraInfo has no P", picture.topic));
}

Result<Eigen::Isometry3d> Inbox::between(const std::string& color, const std::string& depth) const {
  if (color == depth) return Eigen::Isometry3d::Identity();
  // Up from each to where there is no parent.
  const auto climb = [this](std::string frame) {
    Eigen::Isometry3d root_from_frame = Eigen::Isometry3d::Identity();
    for (std::size_t i = 0; i < kMaxKept; ++i) {
      const auto found = transforms_.find(frame);
      if (found == transforms_.end()) break;
      root_from_frame = found->second.parent_from_child * root_from_frame;
      frame = found->second.parent;
    }
    return std::pair(frame, root_from_frame);
  };
  const auto [color_root, root_from_color] = climb(color);
  const auto [depth_root, root_from_depth] = climb(depth);
  if (color_root == depth_root) return root_from_color.inverse() * root_from_depth;
  return bad(fmt::format(
      "how '{}' and '{}' lie to each other is not known: send a tf2_msgs/TFMessage, or start with "
      "calibration=FILE",
      color,
      depth));
}

std::optional<Pair> Inbox::wait(std::chrono::milliseconds timeout, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, timeout, [this] { return next_.has_value(); });
  return std::exchange(next_, std::nullopt);
}

std::string Inbox::reason() const {
  const std::lock_guard lock(mutex_);
  if (!has_device_) return fmt::format("no device is connected: it must push to {}", address_);
  if (fault_at_ && Clock::now() - *fault_at_ < kFaultIsFresh) {
    return "the device sends what cannot be used: " + fault_;
  }
  const auto waits = [this](bool kind) {
    return std::ranges::any_of(waiting_,
                               [&](const Waiting& each) { return each.is_depth == kind; });
  };
  if (waits(true) && waits(false)) {
    return fmt::format("the device's depth and colour are stamped more than {:.0f} ms apart",
                       seconds(options_.tolerance) * 1e3);
  }
  if (waits(true)) return "the device sends no colour pictures";
  if (waits(false)) return "the device sends no depth pictures";
  return "the device is connected and sends no pictures";
}

}  // namespace mor::internal::push
