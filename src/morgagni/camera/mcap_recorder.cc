// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/mcap_recorder.h"

#include <algorithm>
#include <chrono>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/mcap/topics.h"
#include "morgagni/camera/internal/mcap/writer.h"
#include "morgagni/camera/internal/recordable_frame.h"
#include "morgagni/camera/internal/ros/messages.h"
#include "morgagni/camera/internal/ros/schemas.h"
#include "morgagni/core/image_jpeg.h"
#include "morgagni/core/image_png.h"

namespace mor {
namespace {

namespace mcap = internal::mcap;
namespace ros = internal::ros;
using Clock = std::chrono::steady_clock;
using std::chrono::nanoseconds;

constexpr std::chrono::milliseconds kChunkTime{500};
constexpr std::size_t kChunkBytes = 8U << 20U;
/// An older first frame has no age that means anything: it was made, not captured.
constexpr nanoseconds kMaxAge = std::chrono::seconds(1);

tl::unexpected<Error> invalid(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

std::uint64_t wall_ns() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<nanoseconds>(now).count());
}

ros::Diagnostic diagnostic_of(const FoundPose& pose) {
  ros::Diagnostic diagnostic;
  diagnostic.level = pose.state == "tracking" ? ros::Level::kOk
                     : pose.ct_from_depth     ? ros::Level::kWarn
                                              : ros::Level::kError;
  diagnostic.name = "tracking";
  diagnostic.message = pose.state;
  const auto add = [&](std::string_view key, std::string value) {
    diagnostic.values.emplace_back(key, std::move(value));
  };
  if (pose.ct_from_depth) {
    // As text, because /tf has a quaternion in metres and would lose the last bits.
    const auto& m = pose.ct_from_depth->matrix();
    std::string numbers;
    for (int i = 0; i < 12; ++i) {
      numbers += fmt::format("{}{}", i == 0 ? "" : " ", m(i / 4, i % 4));
    }
    add(mcap::kPoseValue, std::move(numbers));
  }
  add(mcap::kHeldValue, pose.is_held ? "1" : "0");
  if (pose.bound_mm) add(mcap::kBoundValue, fmt::format("{}", *pose.bound_mm));
  if (!pose.doubts.empty()) add(mcap::kDoubtsValue, pose.doubts);
  return diagnostic;
}

struct Channels {
  std::uint16_t depth = 0, depth_info = 0, color = 0, color_info = 0;
  std::uint16_t clock = 0, transform = 0, static_transform = 0, diagnostics = 0;
};

Result<Channels> add_channels(mcap::Writer& writer) {
  const auto add = [&](std::string_view topic, const ros::Schema& schema) {
    return writer.add_channel(topic, schema.name, schema.text);
  };
  Channels channels;
  MOR_TRY(channels.depth, add(mcap::kDepthTopic, ros::image_schema()));
  MOR_TRY(channels.depth_info, add(mcap::kDepthInfoTopic, ros::camera_info_schema()));
  MOR_TRY(channels.color, add(mcap::kColorTopic, ros::compressed_image_schema()));
  MOR_TRY(channels.color_info, add(mcap::kColorInfoTopic, ros::camera_info_schema()));
  MOR_TRY(channels.clock, add(mcap::kClockTopic, ros::time_reference_schema()));
  MOR_TRY(channels.transform, add(mcap::kTransformTopic, ros::transforms_schema()));
  MOR_TRY(channels.static_transform, add(mcap::kStaticTransformTopic, ros::transforms_schema()));
  MOR_TRY(channels.diagnostics, add(mcap::kDiagnosticsTopic, ros::diagnostics_schema()));
  return channels;
}

}  // namespace

Result<void> McapRecorderOptions::check() const {
  if (jpeg_quality >= 1 && jpeg_quality <= 100) return {};
  return invalid(fmt::format("jpeg_quality must be in [1, 100], got {}", jpeg_quality));
}

struct McapRecorder::Impl {
  Impl(std::filesystem::path target, McapRecorderOptions given, mcap::Writer file)
      : path(std::move(target)), options(std::move(given)), writer(std::move(file)) {}

  [[nodiscard]] Result<void> begin(const RgbdFrame& frame);
  [[nodiscard]] Result<void> check_free_space() const;
  [[nodiscard]] Result<void> end_chunk();
  void add_calibration(std::uint64_t stamp_ns);
  void add_pose(std::uint64_t stamp_ns, const FoundPose& pose);

  std::filesystem::path path;
  McapRecorderOptions options;
  mcap::Writer writer;
  Channels channels;
  std::shared_ptr<const RgbdCalibration> calibration;
  std::uint64_t first_stamp_ns = 0;
  Clock::time_point first_captured_at, last_captured_at, chunk_started_at;
  std::uint64_t num_frames = 0;
  std::uint64_t num_frames_on_disk = 0;
};

McapRecorder::McapRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapRecorder::McapRecorder(McapRecorder&&) noexcept = default;
McapRecorder& McapRecorder::operator=(McapRecorder&&) noexcept = default;
McapRecorder::~McapRecorder() = default;

Result<McapRecorder> McapRecorder::create(const std::filesystem::path& path,
                                          const McapRecorderOptions& options) {
  MOR_CHECK(options.check());
  MOR_TRY(auto writer, mcap::Writer::create(path, "ros2"));
  auto impl = std::make_unique<Impl>(path, options, std::move(writer));
  MOR_CHECK(impl->writer.add_metadata("morgagni", options.about));
  MOR_TRY(impl->channels, add_channels(impl->writer));
  return McapRecorder(std::move(impl));
}

Result<void> McapRecorder::Impl::begin(const RgbdFrame& frame) {
  const auto age = std::clamp<nanoseconds>(
      Clock::now() - frame.captured_at, nanoseconds(0), nanoseconds(kMaxAge));
  first_stamp_ns = wall_ns() - static_cast<std::uint64_t>(age == kMaxAge ? 0 : age.count());
  first_captured_at = frame.captured_at;
  calibration = frame.calibration;
  const auto json = calibration_to_json(*calibration);
  return writer.add_attachment({std::string(mcap::kCalibrationAttachment),
                                "application/json",
                                std::as_bytes(std::span(json))},
                               first_stamp_ns);
}

/// Once a chunk, so that each one is whole by itself.
void McapRecorder::Impl::add_calibration(std::uint64_t stamp_ns) {
  writer.add_message(channels.depth_info,
                     stamp_ns,
                     ros::encode_camera_info({stamp_ns, mcap::kDepthFrame}, calibration->depth));
  writer.add_message(channels.color_info,
                     stamp_ns,
                     ros::encode_camera_info({stamp_ns, mcap::kColorFrame}, calibration->color));
  writer.add_message(channels.static_transform,
                     stamp_ns,
                     ros::encode_transform({stamp_ns, mcap::kDepthFrame},
                                           mcap::kColorFrame,
                                           calibration->color_from_depth.inverse()));
}

void McapRecorder::Impl::add_pose(std::uint64_t stamp_ns, const FoundPose& pose) {
  if (pose.ct_from_depth) {
    writer.add_message(
        channels.transform,
        stamp_ns,
        ros::encode_transform({stamp_ns, mcap::kCtFrame}, mcap::kDepthFrame, *pose.ct_from_depth));
  }
  writer.add_message(channels.diagnostics,
                     stamp_ns,
                     ros::encode_diagnostic({stamp_ns, mcap::kCtFrame}, diagnostic_of(pose)));
}

Result<void> McapRecorder::Impl::check_free_space() const {
  std::error_code status;
  const auto space = std::filesystem::space(path, status);
  if (status || space.available >= options.min_free_bytes + writer.open_bytes()) return {};
  return make_error(ErrorCode::kIo,
                    fmt::format("{}: the disk is full ({} MiB left, {} are kept free)",
                                path.string(),
                                space.available >> 20U,
                                options.min_free_bytes >> 20U));
}

/// A chunk that cannot be written is lost, what was written before stays and can be finished.
Result<void> McapRecorder::Impl::end_chunk() {
  if (writer.open_bytes() == 0) return {};
  auto ended = check_free_space();
  if (ended) ended = writer.end_chunk();
  if (ended) {
    num_frames_on_disk = num_frames;
  } else {
    writer.drop_chunk();
    num_frames = num_frames_on_disk;
  }
  return ended;
}

Result<void> McapRecorder::add(const RgbdFrame& given, const std::optional<FoundPose>& pose) {
  auto& impl = *impl_;
  const RgbdFrame& frame = as_sensed(given);
  MOR_CHECK(internal::check_recordable(frame, impl.calibration.get(), impl.last_captured_at));
  if (!impl.calibration) MOR_CHECK(impl.begin(frame));
  const bool is_lossless = impl.options.color == ColorCoding::kLossless;
  std::vector<std::byte> color;
  if (is_lossless) {
    color = encode_png(frame.color.view());
  } else {
    MOR_TRY(color, encode_jpeg(frame.color.view(), impl.options.jpeg_quality));
  }
  const auto since_first = nanoseconds(frame.captured_at - impl.first_captured_at);
  const auto stamp_ns = impl.first_stamp_ns + static_cast<std::uint64_t>(since_first.count());
  auto& writer = impl.writer;
  if (writer.open_bytes() == 0) {
    impl.chunk_started_at = frame.captured_at;
    impl.add_calibration(stamp_ns);
  }
  if (frame.device_time) {
    writer.add_message(
        impl.channels.clock,
        stamp_ns,
        ros::encode_time_reference({stamp_ns, mcap::kDepthFrame},
                                   static_cast<std::uint64_t>(frame.device_time->count()),
                                   "device"));
  }
  writer.add_message(
      impl.channels.color,
      stamp_ns,
      ros::encode_compressed({stamp_ns, mcap::kColorFrame}, is_lossless ? "png" : "jpeg", color));
  writer.add_message(impl.channels.depth,
                     stamp_ns,
                     ros::encode_depth({stamp_ns, mcap::kDepthFrame}, frame.depth_mm.view()));
  if (pose) impl.add_pose(stamp_ns, *pose);
  impl.last_captured_at = frame.captured_at;
  ++impl.num_frames;
  if (frame.captured_at - impl.chunk_started_at < kChunkTime && writer.open_bytes() < kChunkBytes) {
    return {};
  }
  return impl.end_chunk();
}

Result<void> McapRecorder::flush() {
  return impl_->end_chunk();
}

Result<void> McapRecorder::finish() {
  MOR_CHECK(impl_->end_chunk());
  return impl_->writer.finish();
}

std::uint64_t McapRecorder::num_frames() const {
  return impl_->num_frames;
}
std::uint64_t McapRecorder::num_bytes() const {
  return impl_->writer.file_bytes();
}

}  // namespace mor
