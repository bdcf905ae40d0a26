// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "morgagni/camera/internal/v4l2/video_system.h"
#include "morgagni/core/result.h"

namespace mor::internal {

/// The four letters of a pixel format, as the kernel keeps them.
constexpr std::uint32_t four_letters(const char (&text)[5]) {
  std::uint32_t code = 0;
  for (unsigned i = 0; i < 4; ++i) {
    code |= static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])) << (8U * i);
  }
  return code;
}

inline constexpr std::uint32_t kZ16 = four_letters("Z16 ");  ///< Depth.
inline constexpr std::uint32_t kY16 = four_letters("Y16 ");  ///< 16-bit grey: depth of some.
inline constexpr std::uint32_t kYuyv = four_letters("YUYV");
inline constexpr std::uint32_t kRgb3 = four_letters("RGB3");
inline constexpr std::uint32_t kMjpg = four_letters("MJPG");

/// What a /dev/video* is.
struct VideoDevice {
  std::string card;  ///< "Intel(R) RealSense(TM) Depth Ca".
  std::string bus;   ///< Where it is plugged in: "usb-0000:00:14.0-2".
  std::vector<std::uint32_t> formats;
};

/// A picture as the driver left it; the bytes are there until the next is taken.
struct VideoPicture {
  std::span<const std::byte> bytes;
  std::chrono::steady_clock::time_point at;  ///< By the driver's stamp where it has one.
  std::optional<std::chrono::nanoseconds> driver_time;
};

/// Pictures of one video device, by mapped buffers.
class VideoStream {
 public:
  /// Opens it, and asks for `formats`, the first that it has, at 640x480 or what is nearest, and 30
  /// pictures a second. @errors kNotFound, kDevice (no permission, in use, no such format).
  [[nodiscard]] static Result<VideoStream> open(std::shared_ptr<const VideoSystem> system,
                                                const std::string& path,
                                                std::span<const std::uint32_t> formats);
  VideoStream(VideoStream&&) noexcept = default;
  VideoStream& operator=(VideoStream&&) = delete;
  ~VideoStream();

  [[nodiscard]] Result<void> start();

  /// The newest picture that is there; older ones go back. None: none is there yet, or it was
  /// damaged. @errors kDevice: the device is gone.
  [[nodiscard]] Result<std::optional<VideoPicture>> take();

  [[nodiscard]] int file() const { return handle_->file; }
  [[nodiscard]] const std::string& bus() const { return bus_; }  ///< As VideoDevice::bus.
  [[nodiscard]] std::uint32_t format() const { return format_; }
  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  [[nodiscard]] std::size_t row_bytes() const { return row_bytes_; }
  [[nodiscard]] std::uint64_t num_damaged() const { return num_damaged_; }

 private:
  struct Handle {
    Handle(std::shared_ptr<const VideoSystem> kernel, int opened)
        : system(std::move(kernel)), file(opened) {}
    ~Handle();
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;

    /// Again where a signal came between. @return 0, or errno.
    [[nodiscard]] int call(unsigned long request, void* argument) const;

    std::shared_ptr<const VideoSystem> system;
    int file;
    std::vector<std::span<std::byte>> buffers;
  };

  VideoStream(std::unique_ptr<Handle> handle, std::string path)
      : handle_(std::move(handle)), path_(std::move(path)) {}
  [[nodiscard]] Result<void> choose_format(std::span<const std::uint32_t> formats);
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> nearest_size(std::uint32_t format) const;
  [[nodiscard]] Result<void> map_buffers();
  [[nodiscard]] bool is_whole(std::uint32_t index, std::uint32_t used, std::uint32_t flags) const;
  [[nodiscard]] tl::unexpected<Error> failed(const char* what, int error) const;

  friend Result<VideoDevice> look_at_video_device(const VideoSystem& system,
                                                  const std::string& path);

  std::unique_ptr<Handle> handle_;
  std::string path_;
  std::string bus_;
  std::uint32_t format_ = 0;
  int width_px_ = 0, height_px_ = 0;
  std::size_t row_bytes_ = 0;
  std::optional<std::uint32_t> lent_;  ///< The buffer that the caller looks at.
  std::uint64_t num_damaged_ = 0;
};

/// Asks a device what it is, without starting it. @errors kNotFound, kDevice.
[[nodiscard]] Result<VideoDevice> look_at_video_device(const VideoSystem& system,
                                                       const std::string& path);

}  // namespace mor::internal
