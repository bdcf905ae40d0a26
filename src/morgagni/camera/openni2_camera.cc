// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/openni2_camera.h"

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include <openni2/OniCProperties.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/calibration_file.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/openni2/openni2_library.h"

namespace mor {
namespace {

using internal::Openni2Library;

constexpr int kPollMs = 100;
/// A device that is silent for so long is gone: OpenNI2 says nothing of it to whoever waits.
constexpr int kMaxSilentPolls = 7;
/// Without a whole frame for so long it fails, and can be opened anew: a device that starts has the
/// time, and the watch (watched_camera.h) has not yet left the driver behind with the device in
/// use.
constexpr std::chrono::milliseconds kPatience{1500};
constexpr std::uint64_t kMaxPairingUs = 25'000;  // Half a frame and some.
constexpr double kColorDistanceMm = 25.0;
constexpr int kMaxSidePx = 4096;

tl::unexpected<Error> device_error(std::string message) {
  return make_error(ErrorCode::kDevice, std::move(message));
}

struct FrameRelease {
  const Openni2Library* library;
  void operator()(OniFrame* frame) const { library->frame_release(frame); }
};
using FramePtr = std::unique_ptr<OniFrame, FrameRelease>;

/// One stream of the device. Stopped and given back with it.
class Stream {
 public:
  static Result<std::unique_ptr<Stream>> create(const Openni2Library& library,
                                                OniDeviceHandle device,
                                                OniSensorType sensor) {
    const char* what = sensor == ONI_SENSOR_DEPTH ? "depth" : "colour";
    auto stream = std::unique_ptr<Stream>(new Stream(library));
    if (library.device_create_stream(device, sensor, &stream->handle_) != ONI_STATUS_OK) {
      stream->handle_ = nullptr;
      return device_error(fmt::format("the camera or recording has no {} pictures", what));
    }
    stream->choose_mode(library.device_get_sensor_info(device, sensor));
    const auto is_mode = [&](OniPixelFormat format) { return stream->mode_.pixelFormat == format; };
    const bool is_readable = sensor == ONI_SENSOR_DEPTH ? is_mode(ONI_PIXEL_FORMAT_DEPTH_1_MM) ||
                                                              is_mode(ONI_PIXEL_FORMAT_DEPTH_100_UM)
                                                        : is_mode(ONI_PIXEL_FORMAT_RGB888);
    const auto is_size = [](int px) { return px >= 1 && px <= kMaxSidePx; };
    if (!is_readable || !is_size(stream->mode_.resolutionX) ||
        !is_size(stream->mode_.resolutionY)) {
      return device_error(fmt::format("the {} pictures ({}x{}, OpenNI format {}) cannot be read",
                                      what,
                                      stream->mode_.resolutionX,
                                      stream->mode_.resolutionY,
                                      static_cast<int>(stream->mode_.pixelFormat)));
    }
    stream->stop_mirroring();
    return stream;
  }
  ~Stream() {
    if (is_started_) library_.stream_stop(handle_);
    if (handle_ != nullptr) library_.stream_destroy(handle_);
  }

  bool start() {
    is_started_ = library_.stream_start(handle_) == ONI_STATUS_OK;
    return is_started_;
  }

  /// By the driver's fields of view.
  [[nodiscard]] Result<PinholeCamera> pinhole() const {
    const int width = mode_.resolutionX, height = mode_.resolutionY;
    const auto focal_px = [&](int property, int size_px) {
      const auto angle_rad = get<float>(property).value_or(0.0F);
      return size_px / 2.0 / std::tan(static_cast<double>(angle_rad) / 2.0);
    };
    PinholeCamera camera{.width_px = width,
                         .height_px = height,
                         .focal_x_px = focal_px(ONI_STREAM_PROPERTY_HORIZONTAL_FOV, width),
                         .focal_y_px = focal_px(ONI_STREAM_PROPERTY_VERTICAL_FOV, height),
                         .center_x_px = (width - 1) / 2.0,
                         .center_y_px = (height - 1) / 2.0};
    if (camera.focal_x_px < 1.0 || camera.focal_y_px < 1.0 || !camera.check()) {
      return device_error(
          "the driver does not say the camera's fields of view: a calibration file "
          "is needed (calibration=FILE)");
    }
    return camera;
  }

  template <class T>
  [[nodiscard]] std::optional<T> get(int property) const {
    T value{};
    int size = sizeof(value);
    if (library_.stream_get_property(handle_, property, &value, &size) != ONI_STATUS_OK ||
        size != sizeof(value)) {
      return std::nullopt;
    }
    return value;
  }

  [[nodiscard]] FramePtr read() const {
    OniFrame* frame = nullptr;
    if (library_.stream_read_frame(handle_, &frame) != ONI_STATUS_OK) frame = nullptr;
    return {frame, FrameRelease{&library_}};
  }

  /// Whether the frame is what the mode says.
  [[nodiscard]] bool is_whole(const OniFrame& frame, std::size_t pixel_bytes) const {
    const auto row_bytes = pixel_bytes * static_cast<std::size_t>(mode_.resolutionX);
    return frame.width == mode_.resolutionX && frame.height == mode_.resolutionY &&
           frame.stride >= 0 && static_cast<std::size_t>(frame.stride) >= row_bytes &&
           frame.data != nullptr && frame.dataSize >= 0 &&
           static_cast<std::size_t>(frame.dataSize) >=
               static_cast<std::size_t>(frame.stride) * static_cast<std::size_t>(frame.height);
  }

  template <class T>
  [[nodiscard]] Image<T> picture(const OniFrame& frame) const {
    Image<T> image(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y) {
      auto* row = image.view().row(y);
      std::memcpy(static_cast<void*>(row),
                  static_cast<const std::byte*>(frame.data) +
                      static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.stride),
                  sizeof(T) * static_cast<std::size_t>(frame.width));
      if (is_mirrored_) std::reverse(row, row + frame.width);
    }
    return image;
  }

  [[nodiscard]] OniStreamHandle handle() const { return handle_; }
  [[nodiscard]] bool is_in_tenths() const {
    return mode_.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM;
  }

 private:
  explicit Stream(const Openni2Library& library) : library_(library) {}

  /// 640x480 in millimetres or RGB where it is offered; otherwise as it is.
  void choose_mode(const OniSensorInfo* info) {
    for (int i = 0; info != nullptr && i < info->numSupportedVideoModes; ++i) {
      const auto& mode = info->pSupportedVideoModes[i];
      if (mode.resolutionX != 640 || mode.resolutionY != 480 || mode.fps != 30) continue;
      if (mode.pixelFormat != ONI_PIXEL_FORMAT_DEPTH_1_MM &&
          mode.pixelFormat != ONI_PIXEL_FORMAT_RGB888) {
        continue;
      }
      (void)library_.stream_set_property(
          handle_, ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, sizeof(mode));
    }
    mode_ = get<OniVideoMode>(ONI_STREAM_PROPERTY_VIDEO_MODE).value_or(OniVideoMode{});
  }

  /// PrimeSense's drivers show a mirror by default; a recording may hold one.
  void stop_mirroring() {
    const OniBool no = 0;
    (void)library_.stream_set_property(handle_, ONI_STREAM_PROPERTY_MIRRORING, &no, sizeof(no));
    is_mirrored_ = get<OniBool>(ONI_STREAM_PROPERTY_MIRRORING).value_or(0) != 0;
  }

  const Openni2Library& library_;
  OniStreamHandle handle_ = nullptr;
  OniVideoMode mode_{};
  bool is_mirrored_ = false;
  bool is_started_ = false;
};

class Openni2Camera final : public RangeCamera {
 public:
  explicit Openni2Camera(std::shared_ptr<const Openni2Library> library)
      : library_(std::move(library)) {}
  ~Openni2Camera() override {
    color_.reset();
    depth_.reset();
    if (device_ != nullptr) library_->device_close(device_);
  }

  Result<void> open(const Openni2Options& options) {
    std::error_code status;
    is_recording_ = options.uri.ends_with(".oni");
    if (is_recording_ && !std::filesystem::is_regular_file(options.uri, status)) {
      return make_error(ErrorCode::kNotFound, fmt::format("{}: no such file", options.uri));
    }
    const char* uri = options.uri.empty() ? nullptr : options.uri.c_str();
    if (library_->device_open(uri, &device_) != ONI_STATUS_OK) {
      device_ = nullptr;
      if (is_recording_) return device_error(options.uri + ": OpenNI2 cannot play it");
      return make_error(ErrorCode::kNotFound,
                        "there is no OpenNI2 camera, or this user may not use it: see `morgagni "
                        "doctor`");
    }
    if (is_recording_) {
      const OniBool no = 0;
      (void)library_->device_set_property(
          device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &no, sizeof(no));
    }
    MOR_TRY(depth_, Stream::create(*library_, device_, ONI_SENSOR_DEPTH));
    MOR_TRY(color_, Stream::create(*library_, device_, ONI_SENSOR_COLOR));
    MOR_TRY(calibration_, calibration_for(options));
    last_frame_ = depth_->get<int>(ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES).value_or(0);
    if (!depth_->start() || !color_->start()) {
      return device_error(
          fmt::format("the camera does not start: {}", library_->get_extended_error()));
    }
    return {};
  }

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    sent_ = {};
    int silent = 0;
    while (!stop.stop_requested()) {
      OniStreamHandle streams[] = {depth_->handle(), color_->handle()};  // NOLINT: C interface
      int ready = -1;
      const auto status = library_->wait_for_any_stream(streams, 2, &ready, kPollMs);
      if (status != ONI_STATUS_OK) {
        if (++silent < kMaxSilentPolls) continue;
        if (is_recording_) return nullptr;
        return device_error("the camera is gone or silent: is its plug out?");
      }
      silent = 0;
      if (ready == 0) take_depth();
      if (ready == 1) take_color();
      if (auto frame = paired()) return frame;
      if (has_ended_) return nullptr;
      // A recording may have a gap, and ends by itself.
      if (!is_recording_ && std::chrono::steady_clock::now() > until) {
        return device_error(why_silent());
      }
    }
    return nullptr;
  }

  const RgbdCalibration& calibration() const override { return *calibration_; }
  std::string device_id() const override { return device_id_; }

 private:
  /// Since a frame is waited for.
  struct Sent {
    bool depth = false, color = false, damaged_depth = false, damaged_color = false;
  };

  [[nodiscard]] std::string why_silent() const {
    if (sent_.damaged_depth) return "the camera sends damaged depth pictures";
    if (sent_.damaged_color) return "the camera sends damaged colour pictures";
    if (!sent_.depth) return "the camera sends no depth pictures";
    if (!sent_.color) return "the camera sends no colour pictures";
    return "the camera's colour and depth are stamped too far apart";
  }

  std::string serial_number() const {
    std::array<char, 64> serial{};
    int size = static_cast<int>(serial.size()) - 1;
    if (library_->device_get_property == nullptr ||
        library_->device_get_property(
            device_, ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial.data(), &size) != ONI_STATUS_OK) {
      return {};
    }
    const std::string text(serial.data());
    return text.empty() ? text : "openni2-" + text;
  }

  Result<std::shared_ptr<const RgbdCalibration>> calibration_for(const Openni2Options& options) {
    auto calibration = std::make_shared<RgbdCalibration>();
    MOR_TRY(calibration->depth, depth_->pinhole());
    MOR_TRY(calibration->color, color_->pinhole());
    calibration->color_from_depth.translation().x() = -kColorDistanceMm;
    device_id_ = !options.device_id.empty() ? options.device_id
                 : is_recording_            ? std::string()
                                            : serial_number();
    MOR_TRY(*calibration,
            internal::choose_calibration(
                options.calibration_file, options.known, device_id_, *calibration));
    return calibration;
  }

  void take_depth() {
    const auto frame = depth_->read();
    sent_.damaged_depth = !frame || !depth_->is_whole(*frame, sizeof(std::uint16_t));
    if (sent_.damaged_depth) return;
    sent_.depth = true;
    waiting_depth_ = depth_->picture<std::uint16_t>(*frame);
    if (depth_->is_in_tenths()) {
      for (std::size_t i = 0; i < waiting_depth_.size(); ++i) {
        auto& value = waiting_depth_.data()[i];
        value = static_cast<std::uint16_t>((value + 5) / 10);
      }
    }
    depth_us_ = frame->timestamp;
    depth_at_ = std::chrono::steady_clock::now();
    // A recording of N frames: the one with index N is the last.
    has_ended_ = is_recording_ && last_frame_ > 0 && frame->frameIndex >= last_frame_;
  }

  void take_color() {
    const auto frame = color_->read();
    sent_.damaged_color = !frame || !color_->is_whole(*frame, sizeof(Rgb8));
    if (sent_.damaged_color) return;
    sent_.color = true;
    newest_color_ = color_->picture<Rgb8>(*frame);
    color_us_ = frame->timestamp;
  }

  std::shared_ptr<const RgbdFrame> paired() {
    if (waiting_depth_.empty() || newest_color_.empty()) return nullptr;
    const auto apart = depth_us_ > color_us_ ? depth_us_ - color_us_ : color_us_ - depth_us_;
    if (apart > kMaxPairingUs) return nullptr;
    auto frame = std::make_shared<RgbdFrame>();
    frame->frame_id = next_id_++;
    frame->captured_at = depth_at_;
    frame->device_time = std::chrono::microseconds(depth_us_);
    frame->depth_mm = std::exchange(waiting_depth_, {});
    frame->color = newest_color_;
    frame->calibration = calibration_;
    return frame;
  }

  std::shared_ptr<const Openni2Library> library_;
  OniDeviceHandle device_ = nullptr;
  std::unique_ptr<Stream> depth_, color_;
  std::shared_ptr<const RgbdCalibration> calibration_;
  std::string device_id_;
  bool is_recording_ = false;
  bool has_ended_ = false;
  int last_frame_ = 0;
  Sent sent_;
  std::uint64_t next_id_ = 0;
  Image<std::uint16_t> waiting_depth_;
  Image<Rgb8> newest_color_;
  std::uint64_t depth_us_ = 0, color_us_ = 0;
  std::chrono::steady_clock::time_point depth_at_;
};

}  // namespace

Result<Openni2Options> Openni2Options::parse(std::string_view text) {
  Openni2Options options;
  const auto end = text.find(',');
  const auto first = text.substr(0, end);
  if (first.find('=') == std::string_view::npos) {
    options.uri = first;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  MOR_TRY(const auto pairs, internal::split_key_values(text));
  for (const auto& pair : pairs) {
    if (pair.key == "calibration") {
      options.calibration_file = pair.value;
    } else if (pair.key == "device") {
      MOR_TRY(options.device_id, internal::parse_device_id(pair));
    } else {
      return internal::unknown_key("openni2", pair, {"calibration", "device"});
    }
  }
  return options;
}

Result<std::unique_ptr<RangeCamera>> open_openni2(const Openni2Options& options) {
  MOR_TRY(auto library, Openni2Library::load(options.library));
  auto camera = std::make_unique<Openni2Camera>(std::move(library));
  MOR_CHECK(camera->open(options));
  return camera;
}

}  // namespace mor
