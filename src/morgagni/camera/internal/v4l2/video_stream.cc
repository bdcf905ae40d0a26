// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/v4l2/video_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <linux/videodev2.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>

namespace mor::internal {
namespace {

constexpr std::uint32_t kWantedWidthPx = 640, kWantedHeightPx = 480;
constexpr std::uint32_t kMaxSidePx = 8192;
constexpr std::uint32_t kPicturesPerSecond = 30;
constexpr std::uint32_t kNumBuffers = 4;
constexpr std::size_t kMaxBufferBytes = 256U << 20U;
constexpr std::uint32_t kMaxListed = 256;
constexpr int kMaxInterrupts = 100;
/// More do not wait: a driver that hands out buffers without end does not hold us up.
constexpr std::uint32_t kMaxTakenAtOnce = 2 * kNumBuffers;

std::string letters_of(std::uint32_t format) {
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const auto letter = static_cast<char>((format >> (8U * i)) & 0x7FU);
    text += letter >= ' ' ? letter : '?';
  }
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::string card_name(const v4l2_capability& capability) {
  const auto* card = reinterpret_cast<const char*>(capability.card);
  return {card, strnlen(card, sizeof(capability.card))};
}

std::string bus_name(const v4l2_capability& capability) {
  const auto* bus = reinterpret_cast<const char*>(capability.bus_info);
  return {bus, strnlen(bus, sizeof(capability.bus_info))};
}

std::uint32_t capabilities(const v4l2_capability& capability) {
  const bool has_own = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0U;
  return has_own ? capability.device_caps : capability.capabilities;
}

/// Bytes that a pixel takes at least; 0: packed.
std::size_t pixel_bytes(std::uint32_t format) {
  if (format == kMjpg) return 0;
  return format == kRgb3 ? 3 : 2;
}

}  // namespace

VideoStream::Handle::~Handle() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!buffers.empty()) (void)call(VIDIOC_STREAMOFF, &type);
  for (const auto& buffer : buffers) system->unmap(buffer.data(), buffer.size());
  system->close(file);
}

int VideoStream::Handle::call(unsigned long request, void* argument) const {
  for (int i = 0; i < kMaxInterrupts; ++i) {
    if (system->ioctl(file, request, argument) == 0) return 0;
    if (errno != EINTR) break;
  }
  return errno;
}

VideoStream::~VideoStream() = default;

tl::unexpected<Error> VideoStream::failed(const char* what, int error) const {
  if (error == ENODEV) {
    return make_error(ErrorCode::kDevice, fmt::format("{} is gone: is its plug out?", path_));
  }
  if (error == EBUSY) {
    return make_error(ErrorCode::kDevice, fmt::format("{}: another program has it", path_));
  }
  return make_error(ErrorCode::kDevice,
                    fmt::format("{}: {}: {}", path_, what, std::strerror(error)));
}

Result<VideoStream> VideoStream::open(std::shared_ptr<const VideoSystem> system,
                                      const std::string& path,
                                      std::span<const std::uint32_t> formats) {
  const int file = system->open(path.c_str());
  if (file < 0) {
    const int error = errno;
    if (error == ENOENT || error == ENXIO || error == ENODEV) {
      return make_error(ErrorCode::kNotFound,
                        fmt::format("there is no {}: is its plug out?", path));
    }
    const bool is_forbidden = error == EACCES || error == EPERM;
    return make_error(ErrorCode::kDevice,
                      fmt::format("{} cannot be opened: {}",
                                  path,
                                  is_forbidden ? "this user may not use it (see `morgagni doctor`)"
                                               : std::strerror(error)));
  }
  VideoStream stream(std::make_unique<Handle>(std::move(system), file), path);
  v4l2_capability capability{};
  if (const int error = stream.handle_->call(VIDIOC_QUERYCAP, &capability)) {
    return stream.failed("is no video device", error);
  }
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((capabilities(capability) & kNeeded) != kNeeded) {
    return make_error(ErrorCode::kDevice, fmt::format("{} gives no pictures by streaming", path));
  }
  stream.bus_ = bus_name(capability);
  MOR_CHECK(stream.choose_format(formats));
  MOR_CHECK(stream.map_buffers());
  return stream;
}

std::pair<std::uint32_t, std::uint32_t> VideoStream::nearest_size(std::uint32_t format) const {
  std::pair best(kWantedWidthPx, kWantedHeightPx);
  std::int64_t least = -1;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = format;
    if (handle_->call(VIDIOC_ENUM_FRAMESIZES, &size) != 0) break;
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) return {kWantedWidthPx, kWantedHeightPx};
    const auto& [width, height] = size.discrete;
    const auto off = std::abs(std::int64_t{width} - kWantedWidthPx) +
                     std::abs(std::int64_t{height} - kWantedHeightPx);
    if (least >= 0 && off >= least) continue;
    best = {width, height};
    least = off;
  }
  return best;
}

Result<void> VideoStream::choose_format(std::span<const std::uint32_t> formats) {
  std::string offered;
  std::vector<std::uint32_t> has;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_fmtdesc listed{};
    listed.index = i;
    listed.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (handle_->call(VIDIOC_ENUM_FMT, &listed) != 0) break;
    has.push_back(listed.pixelformat);
    offered += (offered.empty() ? "" : ", ") + letters_of(listed.pixelformat);
  }
  const auto wanted = std::ranges::find_if(
      formats, [&](std::uint32_t each) { return std::ranges::find(has, each) != has.end(); });
  if (wanted == formats.end()) {
    return make_error(ErrorCode::kDevice,
                      fmt::format("{} has pictures of {}, {} is needed",
                                  path_,
                                  offered.empty() ? "no format" : offered,
                                  letters_of(formats.front())));
  }
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  auto& picture = format.fmt.pix;
  std::tie(picture.width, picture.height) = nearest_size(*wanted);
  picture.pixelformat = *wanted;
  picture.field = V4L2_FIELD_NONE;
  if (const int error = handle_->call(VIDIOC_S_FMT, &format)) return failed("its format", error);
  // The driver has written what it made of it.
  const bool is_sound =
      picture.pixelformat == *wanted && picture.width > 0 && picture.height > 0 &&
      picture.width <= kMaxSidePx && picture.height <= kMaxSidePx &&
      (*wanted == kMjpg || picture.bytesperline >= picture.width * pixel_bytes(*wanted));
  if (!is_sound) {
    return make_error(ErrorCode::kDevice,
                      fmt::format("{} offers {}x{} px in {} with {} bytes a row",
                                  path_,
                                  picture.width,
                                  picture.height,
                                  letters_of(picture.pixelformat),
                                  picture.bytesperline));
  }
  format_ = *wanted;
  width_px_ = static_cast<int>(picture.width);
  height_px_ = static_cast<int>(picture.height);
  row_bytes_ = picture.bytesperline;
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  rate.parm.capture.timeperframe = {1, kPicturesPerSecond};
  (void)handle_->call(VIDIOC_S_PARM, &rate);  // Not all drivers can; theirs is taken then.
  return {};
}

Result<void> VideoStream::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = kNumBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = handle_->call(VIDIOC_REQBUFS, &request)) return failed("buffers", error);
  if (request.count == 0 || request.count > 8 * kNumBuffers) return failed("buffers", ENOMEM);
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (const int error = handle_->call(VIDIOC_QUERYBUF, &buffer)) return failed("a buffer", error);
    if (buffer.length == 0 || buffer.length > kMaxBufferBytes) return failed("a buffer", EINVAL);
    auto* at = handle_->system->map(buffer.length, handle_->file, buffer.m.offset);
    if (at == MAP_FAILED) return failed("a buffer is not mapped", errno);
    handle_->buffers.emplace_back(static_cast<std::byte*>(at), buffer.length);
  }
  return {};
}

Result<void> VideoStream::start() {
  for (std::uint32_t i = 0; i < handle_->buffers.size(); ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (const int error = handle_->call(VIDIOC_QBUF, &buffer)) return failed("a buffer", error);
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = handle_->call(VIDIOC_STREAMON, &type))
    return failed("does not start", error);
  return {};
}

bool VideoStream::is_whole(std::uint32_t index, std::uint32_t used, std::uint32_t flags) const {
  if (index >= handle_->buffers.size() || (flags & V4L2_BUF_FLAG_ERROR) != 0U) return false;
  if (used == 0 || used > handle_->buffers[index].size()) return false;
  return format_ == kMjpg || used >= row_bytes_ * static_cast<std::size_t>(height_px_);
}

Result<std::optional<VideoPicture>> VideoStream::take() {
  std::optional<VideoPicture> picture;
  for (std::uint32_t i = 0; i < kMaxTakenAtOnce; ++i) {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    const int error = handle_->call(VIDIOC_DQBUF, &buffer);
    if (error == EAGAIN) break;
    if (error == EIO) {  // Lost signal or the like: the driver goes on.
      ++num_damaged_;
      break;
    }
    if (error != 0) return failed("a picture", error);
    const bool is_good = is_whole(buffer.index, buffer.bytesused, buffer.flags);
    if (!is_good) ++num_damaged_;
    // What is not shown goes back: the damaged one, or the one before.
    const auto back = is_good ? std::exchange(lent_, buffer.index) : std::optional(buffer.index);
    if (back && *back < handle_->buffers.size()) {
      v4l2_buffer again{};
      again.index = *back;
      again.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
      again.memory = V4L2_MEMORY_MMAP;
      if (const int fault = handle_->call(VIDIOC_QBUF, &again)) return failed("a buffer", fault);
    }
    if (!is_good) continue;
    const auto stamp = std::chrono::seconds(buffer.timestamp.tv_sec) +
                       std::chrono::microseconds(buffer.timestamp.tv_usec);
    const bool is_ours =
        (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    using Clock = std::chrono::steady_clock;  // CLOCK_MONOTONIC, as the driver's.
    picture = VideoPicture{std::span(handle_->buffers[buffer.index]).first(buffer.bytesused),
                           is_ours ? Clock::time_point(stamp) : Clock::now(),
                           is_ours ? std::optional<std::chrono::nanoseconds>(stamp) : std::nullopt};
  }
  return picture;
}

Result<VideoDevice> look_at_video_device(const VideoSystem& system, const std::string& path) {
  // Not owned: the handle lives within this call.
  const std::shared_ptr<const VideoSystem> borrowed(std::shared_ptr<void>(), &system);
  const int file = system.open(path.c_str());
  if (file < 0) {
    const bool is_forbidden = errno == EACCES || errno == EPERM;
    return make_error(is_forbidden ? ErrorCode::kDevice : ErrorCode::kNotFound,
                      fmt::format("{}: {}", path, std::strerror(errno)));
  }
  const VideoStream::Handle handle(borrowed, file);
  v4l2_capability capability{};
  if (const int error = handle.call(VIDIOC_QUERYCAP, &capability)) {
    return make_error(ErrorCode::kNotFound, fmt::format("{}: {}", path, std::strerror(error)));
  }
  VideoDevice device{.card = card_name(capability), .bus = bus_name(capability), .formats = {}};
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_fmtdesc listed{};
    listed.index = i;
    listed.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (handle.call(VIDIOC_ENUM_FMT, &listed) != 0) break;
    device.formats.push_back(listed.pixelformat);
  }
  return device;
}

}  // namespace mor::internal
