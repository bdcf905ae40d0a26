// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/freenect_camera.h"

#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/calibration_file.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/kinect/freenect_library.h"
#include "morgagni/camera/internal/kinect/kinect_depth.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;
using internal::FreenectLibrary;
using internal::kKinectHeightPx;
using internal::kKinectPixels;
using internal::kKinectWidthPx;

constexpr std::uint64_t kTicksPerSecond = 60'000'000;  // Of the device's clock, of 32 bits.
/// Half a frame apart: the colour picture belongs to the depth picture.
constexpr std::uint32_t kMaxPairingTicks = kTicksPerSecond / 40;
constexpr timeval kPoll{0, 100'000};
/// Without a whole frame for so long it fails, and can be opened anew: a device that starts has the
/// time, and the watch (watched_camera.h) has not yet left the driver behind with the device in
/// use.
constexpr std::chrono::milliseconds kPatience{1500};

tl::unexpected<Error> device_error(std::string message) {
  return make_error(ErrorCode::kDevice, std::move(message));
}

/// Counts on where 32 bits of ticks wrap, each 71.6 s.
class TickCounter {
 public:
  std::chrono::nanoseconds time(std::uint32_t ticks) {
    if (last_) total_ += static_cast<std::int32_t>(ticks - *last_);
    last_ = ticks;
    // 60 MHz: 50/3 ns a tick.
    return std::chrono::nanoseconds(total_ * 50 / 3);
  }

 private:
  std::optional<std::uint32_t> last_;
  std::int64_t total_ = 0;
};

/// libfreenect's handles, closed in order.
class Device {
 public:
  static Result<std::unique_ptr<Device>> open(std::shared_ptr<const FreenectLibrary> library,
                                              int index) {
    auto device = std::unique_ptr<Device>(new Device(std::move(library)));
    const auto& f = *device->library;
    if (f.init(&device->context, nullptr) < 0) {
      return device_error("libfreenect cannot use the USB bus: see `morgagni doctor`");
    }
    f.set_log_level(device->context, FREENECT_LOG_FATAL);
    f.select_subdevices(device->context, FREENECT_DEVICE_CAMERA);
    const int count = f.num_devices(device->context);
    if (index >= count) {
      return make_error(ErrorCode::kNotFound,
                        count <= 0 ? "there is no Kinect: plug in its USB and its power supply"
                                   : fmt::format("there is no Kinect {}, only {}", index, count));
    }
    if (f.open_device(device->context, &device->handle, index) < 0) {
      device->handle = nullptr;
      return device_error(
          "the Kinect cannot be opened: another program has it, or this user may not use it (see "
          "`morgagni doctor`)");
    }
    return device;
  }

  ~Device() {
    if (handle != nullptr) {
      library->stop_depth(handle);
      library->stop_video(handle);
      library->close_device(handle);
    }
    if (context != nullptr) library->shutdown(context);
  }

  std::shared_ptr<const FreenectLibrary> library;
  freenect_context* context = nullptr;
  freenect_device* handle = nullptr;

 private:
  explicit Device(std::shared_ptr<const FreenectLibrary> loaded) : library(std::move(loaded)) {}
};

/// What the device's memory says; the design where it cannot be asked.
Result<internal::KinectGeometry> geometry_of(const Device& device) {
  internal::KinectGeometry geometry;
  if (device.library->copy_registration == nullptr) return geometry;
  auto registration = device.library->copy_registration(device.handle);
  const auto& plane = registration.zero_plane_info;
  // libfreenect: the reference in mm as seen on the sensor, distances in cm.
  geometry.reference_distance_mm = static_cast<double>(plane.reference_distance) * 10.0;
  geometry.reference_pixel_mm = static_cast<double>(plane.reference_pixel_size);
  geometry.emitter_distance_mm = static_cast<double>(plane.dcmos_emitter_dist) * 10.0;
  geometry.color_distance_mm = static_cast<double>(plane.dcmos_rcmos_dist) * 10.0;
  geometry.raw_at_reference = registration.const_shift * 4.0;
  if (device.library->destroy_registration != nullptr) {
    device.library->destroy_registration(&registration);
  }
  MOR_CHECK(geometry.check());
  return geometry;
}

/// The camera's serial number; of a Kinect for Windows and later models it is zeros, which say
/// nothing.
std::string device_id_of(const Device& device, int index) {
  const auto& f = *device.library;
  if (f.list_device_attributes == nullptr || f.free_device_attributes == nullptr) return {};
  freenect_device_attributes* list = nullptr;
  f.list_device_attributes(device.context, &list);
  const auto* found = list;
  for (int i = 0; i < index && found != nullptr; ++i) found = found->next;
  std::string serial =
      found != nullptr && found->camera_serial != nullptr ? found->camera_serial : "";
  f.free_device_attributes(list);
  if (serial.find_first_not_of('0') == std::string::npos) return {};
  return "freenect-" + serial;
}

class FreenectCamera final : public RangeCamera {
 public:
  FreenectCamera(std::unique_ptr<Device> device,
                 std::string device_id,
                 const internal::KinectGeometry& geometry,
                 RgbdCalibration calibration)
      : device_(std::move(device)),
        device_id_(std::move(device_id)),
        mm_from_raw_(internal::kinect_mm_from_raw(geometry)),
        calibration_(std::make_shared<const RgbdCalibration>(std::move(calibration))) {}

  ~FreenectCamera() override { events_ = {}; }

  Result<void> start() {
    const auto& f = *device_->library;
    auto* handle = device_->handle;
    f.set_depth_callback(handle, [](freenect_device*, void* depth, std::uint32_t ticks) {
      of_this_thread()->take_depth(static_cast<const std::uint16_t*>(depth), ticks);
    });
    f.set_video_callback(handle, [](freenect_device*, void* rgb, std::uint32_t ticks) {
      of_this_thread()->take_color(rgb, ticks);
    });
    const auto depth_mode = f.find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_11BIT);
    const auto color_mode = f.find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB);
    if (f.set_depth_mode(handle, depth_mode) < 0 || f.set_video_mode(handle, color_mode) < 0 ||
        f.start_depth(handle) < 0 || f.start_video(handle) < 0) {
      return device_error("the Kinect does not start: unplug it and plug it in again");
    }
    events_ = std::jthread([this](std::stop_token stop) { handle_events(stop); });
    return {};
  }

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    std::unique_lock lock(mutex_);
    sends_depth_ = sends_color_ = false;
    changed_.wait_until(
        lock, stop, Clock::now() + kPatience, [this] { return next_ != nullptr || is_gone_; });
    if (next_) return std::exchange(next_, nullptr);
    if (is_gone_) return device_error("the Kinect is gone: is its plug out, or its power?");
    if (stop.stop_requested()) return nullptr;
    return device_error(why_silent());
  }

  const RgbdCalibration& calibration() const override { return *calibration_; }
  std::string device_id() const override { return device_id_; }

 private:
  /// Whose events the thread handles: the callbacks come on it and get only the device.
  static FreenectCamera*& of_this_thread() {
    static thread_local FreenectCamera* camera = nullptr;
    return camera;
  }

  void handle_events(std::stop_token stop) {
    of_this_thread() = this;
    while (!stop.stop_requested()) {
      timeval timeout = kPoll;
      if (device_->library->process_events_timeout(device_->context, &timeout) < 0) break;
    }
    {
      const std::lock_guard lock(mutex_);
      is_gone_ = true;
    }
    changed_.notify_all();
  }

  /// Needs the lock.
  [[nodiscard]] std::string why_silent() const {
    if (sends_depth_ && sends_color_) {
      return "the Kinect's colour and depth are stamped too far apart";
    }
    if (sends_color_) return "the Kinect sends no depth pictures";
    if (sends_depth_) return "the Kinect sends no colour pictures";
    return "the Kinect sends no pictures: is its plug out, or its power?";
  }

  void note(bool& is_sent) {
    const std::lock_guard lock(mutex_);
    is_sent = true;
  }

  void take_color(const void* rgb, std::uint32_t ticks) {
    note(sends_color_);
    color_ = Image<Rgb8>(kKinectWidthPx, kKinectHeightPx);
    std::memcpy(static_cast<void*>(color_.data()), rgb, kKinectPixels * sizeof(Rgb8));
    color_ticks_ = ticks;
    if (waiting_ && is_pair(waiting_ticks_, ticks)) pass_on(std::exchange(waiting_, nullptr));
  }

  void take_depth(const std::uint16_t* raw, std::uint32_t ticks) {
    note(sends_depth_);
    auto frame = std::make_shared<RgbdFrame>();
    frame->captured_at = Clock::now();
    frame->device_time = counter_.time(ticks);
    frame->calibration = calibration_;
    frame->depth_mm = Image<std::uint16_t>(kKinectWidthPx, kKinectHeightPx);
    for (std::size_t i = 0; i < kKinectPixels; ++i) {
      frame->depth_mm.data()[i] = mm_from_raw_[raw[i] & 0x7FFU];
    }
    if (!color_.empty() && is_pair(ticks, color_ticks_)) {
      pass_on(std::move(frame));
    } else {
      waiting_ = std::move(frame);
      waiting_ticks_ = ticks;
    }
  }

  static bool is_pair(std::uint32_t a, std::uint32_t b) {
    const auto apart = static_cast<std::int32_t>(a - b);
    return static_cast<std::uint32_t>(std::abs(apart)) <= kMaxPairingTicks;
  }

  void pass_on(std::shared_ptr<RgbdFrame> frame) {
    frame->color = color_;
    frame->frame_id = next_id_++;
    {
      const std::lock_guard lock(mutex_);
      next_ = std::move(frame);
    }
    changed_.notify_all();
  }

  std::unique_ptr<Device> device_;
  std::string device_id_;
  std::array<std::uint16_t, 2048> mm_from_raw_;
  std::shared_ptr<const RgbdCalibration> calibration_;

  // The events thread's alone.
  Image<Rgb8> color_;
  std::uint32_t color_ticks_ = 0;
  std::shared_ptr<RgbdFrame> waiting_;  ///< Depth whose colour has not come yet.
  std::uint32_t waiting_ticks_ = 0;
  TickCounter counter_;
  std::uint64_t next_id_ = 0;

  std::mutex mutex_;  ///< Guards those below, down to the next blank line.
  std::condition_variable_any changed_;
  std::shared_ptr<const RgbdFrame> next_;
  bool is_gone_ = false;
  bool sends_depth_ = false, sends_color_ = false;  ///< Since a frame is waited for.

  std::jthread events_;
};

Result<RgbdCalibration> calibration_for(const FreenectOptions& options,
                                        const std::string& device_id,
                                        const internal::KinectGeometry& geometry) {
  return internal::choose_calibration(
      options.calibration_file, options.known, device_id, internal::kinect_calibration(geometry));
}

}  // namespace

Result<FreenectOptions> FreenectOptions::parse(std::string_view text) {
  FreenectOptions options;
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    if (pair.key == "index") {
      MOR_TRY(const auto index, internal::parse_count(pair, 0, 15));
      options.index = static_cast<int>(index);
    } else if (pair.key == "calibration") {
      options.calibration_file = pair.value;
    } else if (pair.key == "device") {
      MOR_TRY(options.device_id, internal::parse_device_id(pair));
    } else {
      return internal::unknown_key("freenect", pair, {"index", "calibration", "device"});
    }
  }
  return options;
}

Result<std::unique_ptr<RangeCamera>> open_freenect(const FreenectOptions& options) {
  MOR_TRY(auto library, FreenectLibrary::load(options.library));
  MOR_TRY(auto device, Device::open(std::move(library), options.index));
  MOR_TRY(const auto geometry, geometry_of(*device));
  auto device_id =
      options.device_id.empty() ? device_id_of(*device, options.index) : options.device_id;
  MOR_TRY(auto calibration, calibration_for(options, device_id, geometry));
  auto camera = std::make_unique<FreenectCamera>(
      std::move(device), std::move(device_id), geometry, std::move(calibration));
  MOR_CHECK(camera->start());
  return camera;
}

Result<int> count_freenect_devices(const std::string& library_name) {
  MOR_TRY(const auto library, FreenectLibrary::load(library_name));
  freenect_context* context = nullptr;
  if (library->init(&context, nullptr) < 0) {
    return device_error("libfreenect cannot use the USB bus");
  }
  library->set_log_level(context, FREENECT_LOG_FATAL);
  const int count = library->num_devices(context);
  library->shutdown(context);
  return count;
}

}  // namespace mor
