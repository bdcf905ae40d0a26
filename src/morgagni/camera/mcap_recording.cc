// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/mcap_recording.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/mcap/reader.h"
#include "morgagni/camera/internal/mcap/topics.h"
#include "morgagni/camera/internal/ros/messages.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

namespace mcap = internal::mcap;
namespace ros = internal::ros;
using mcap::MessageRef;

/// One frame's messages. All have its time.
struct Place {
  MessageRef depth;
  MessageRef color;
  std::optional<MessageRef> clock;
  std::optional<MessageRef> pose;
};

using ByTime = std::map<std::uint64_t, MessageRef>;

/// Those in ROS 2's own encoding.
ByTime messages_of(const mcap::Reader& file, std::string_view topic) {
  ByTime found;
  for (const auto& message : file.messages()) {
    const auto channel = file.channels().find(message.channel);
    if (channel == file.channels().end() || channel->second.topic != topic ||
        channel->second.encoding != "cdr")
      continue;
    found.emplace(message.time_ns, message);
  }
  return found;
}

std::optional<MessageRef> at_time(const ByTime& messages, std::uint64_t time_ns) {
  const auto found = messages.find(time_ns);
  return found == messages.end() ? std::nullopt : std::optional(found->second);
}

/// `count` finite numbers with a space between.
bool parse_numbers(std::string_view text, std::span<double> numbers) {
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (auto& number : numbers) {
    if (at != end && *at == ' ') ++at;
    const auto [next, status] = std::from_chars(at, end, number);
    if (status != std::errc() || !std::isfinite(number)) return false;
    at = next;
  }
  return at == end;
}

Result<FoundPose> pose_of(const ros::Diagnostic& diagnostic) {
  FoundPose pose;
  pose.state = diagnostic.message;
  for (const auto& [key, value] : diagnostic.values) {
    bool is_good = true;
    if (key == mcap::kHeldValue) {
      pose.is_held = value == "1";
    } else if (key == mcap::kDoubtsValue) {
      pose.doubts = value;
    } else if (key == mcap::kBoundValue) {
      is_good = parse_numbers(value, std::span(&pose.bound_mm.emplace(), 1));
    } else if (key == mcap::kPoseValue) {
      std::array<double, 12> numbers{};
      is_good = parse_numbers(value, numbers);
      pose.ct_from_depth.emplace(Eigen::Isometry3d::Identity());
      for (int i = 0; i < 12; ++i) {
        pose.ct_from_depth->matrix()(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
      }
    }
    if (!is_good) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("a pose's {} is not in numbers: '{}'", key, value));
    }
  }
  return pose;
}

template <class T>
Result<void> check_size(const Image<T>& image, const PinholeCamera& camera, const char* what) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("a {} picture is {}x{}, its calibration says {}x{}",
                                what,
                                image.width(),
                                image.height(),
                                camera.width_px,
                                camera.height_px));
}

}  // namespace

struct McapRecording::Impl {
  Impl(std::filesystem::path source, mcap::Reader reader)
      : path(std::move(source)), file(std::move(reader)) {}

  template <class T>
  Result<T> named(std::size_t i, Result<T> result) const {
    if (result) return result;
    auto message = std::move(result.error().message);
    // The file's own sentences name it already.
    if (!message.starts_with(path.string())) {
      message = fmt::format("{}: frame {}: {}", path.string(), i, message);
    }
    return make_error(result.error().code, std::move(message));
  }
  Result<std::shared_ptr<const RgbdFrame>> read(std::size_t i);
  Result<std::optional<FoundPose>> pose(std::size_t i);

  std::filesystem::path path;
  mcap::Reader file;
  std::shared_ptr<const RgbdCalibration> calibration;
  std::vector<Place> places;
};

McapRecording::McapRecording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapRecording::McapRecording(McapRecording&&) noexcept = default;
McapRecording& McapRecording::operator=(McapRecording&&) noexcept = default;
McapRecording::~McapRecording() = default;

Result<McapRecording> McapRecording::open(const std::filesystem::path& path) {
  MOR_TRY(auto file, mcap::Reader::open(path));
  auto impl = std::make_unique<Impl>(path, std::move(file));
  const auto invalid = [&](const std::string& what) {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", path.string(), what));
  };
  const auto depths = messages_of(impl->file, mcap::kDepthTopic);
  const auto colors = messages_of(impl->file, mcap::kColorTopic);
  const auto clocks = messages_of(impl->file, mcap::kClockTopic);
  const auto poses = messages_of(impl->file, mcap::kDiagnosticsTopic);
  for (const auto& [time_ns, depth] : depths) {
    const auto color = at_time(colors, time_ns);
    if (!color) continue;
    impl->places.push_back({depth, *color, at_time(clocks, time_ns), at_time(poses, time_ns)});
  }
  if (impl->places.empty()) {
    return invalid(fmt::format("has no frames of a range camera (topics {} and {})",
                               mcap::kDepthTopic,
                               mcap::kColorTopic));
  }
  MOR_TRY(const auto json, impl->file.attachment(std::string(mcap::kCalibrationAttachment)));
  auto calibration =
      calibration_from_json({reinterpret_cast<const char*>(json.data()), json.size()});
  if (!calibration) return invalid(calibration.error().message);
  impl->calibration = std::make_shared<const RgbdCalibration>(*std::move(calibration));
  if (!impl->file.is_complete()) {
    log::warn("{}: the recording was interrupted; {} frames could be read",
              path.string(),
              impl->places.size());
  }
  return McapRecording(std::move(impl));
}

Result<std::shared_ptr<const RgbdFrame>> McapRecording::Impl::read(std::size_t i) {
  const auto& place = places[i];
  auto frame = std::make_shared<RgbdFrame>();
  frame->frame_id = i;
  frame->calibration = calibration;
  frame->captured_at = std::chrono::steady_clock::time_point(
      std::chrono::nanoseconds(place.depth.time_ns - places.front().depth.time_ns));
  MOR_TRY(const auto depth, file.read(place.depth));
  MOR_TRY(frame->depth_mm, ros::decode_depth(depth));
  MOR_CHECK(check_size(frame->depth_mm, calibration->depth, "depth"));
  MOR_TRY(const auto color, file.read(place.color));
  MOR_TRY(frame->color, ros::decode_color(color));
  MOR_CHECK(check_size(frame->color, calibration->color, "colour"));
  if (place.clock) {
    MOR_TRY(const auto clock, file.read(*place.clock));
    MOR_TRY(const auto device_ns, ros::decode_time_reference(clock));
    frame->device_time = std::chrono::nanoseconds(device_ns);
  }
  return frame;
}

Result<std::optional<FoundPose>> McapRecording::Impl::pose(std::size_t i) {
  if (!places[i].pose) return std::nullopt;
  MOR_TRY(const auto message, file.read(*places[i].pose));
  MOR_TRY(const auto diagnostic, ros::decode_diagnostic(message));
  MOR_TRY(auto pose, pose_of(diagnostic));
  return pose;
}

std::size_t McapRecording::size() const {
  return impl_->places.size();
}
std::chrono::nanoseconds McapRecording::since_start(std::size_t i) const {
  return wall_time(i) - wall_time(0);
}
std::chrono::nanoseconds McapRecording::wall_time(std::size_t i) const {
  return std::chrono::nanoseconds(impl_->places[i].depth.time_ns);
}
const std::shared_ptr<const RgbdCalibration>& McapRecording::calibration() const {
  return impl_->calibration;
}
bool McapRecording::is_complete() const {
  return impl_->file.is_complete();
}
Result<std::shared_ptr<const RgbdFrame>> McapRecording::read(std::size_t i) const {
  return impl_->named(i, impl_->read(i));
}
Result<std::optional<FoundPose>> McapRecording::pose(std::size_t i) const {
  return impl_->named(i, impl_->pose(i));
}

}  // namespace mor
