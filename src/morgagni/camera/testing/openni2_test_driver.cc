// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// A driver for OpenNI2 with one device, which sends small pictures whose numbers a test knows:
// depth 700 + frame in all pixels but the first (0) and the second (1000), colour {frame, 20, 30}
// but the first {200, 0, 0}. The device is called "morgagni-test"; with "/mirrored" after it, it
// mirrors and cannot be told not to. With "/silent" it sends ten frames and then nothing, with
// "/colour-only" no depth after the tenth, with "/damaged" depth of half a picture, and with
// "/apart" colour stamped half a second late.

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>

#include <openni2/Driver/OniDriverAPI.h>
#include <openni2/OniCProperties.h>

namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr const char* kUri = "morgagni-test";

OniVideoMode mode_of(OniSensorType sensor) {
  return {sensor == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888,
          kWidth,
          kHeight,
          100};
}

class TestStream : public oni::driver::StreamBase {
 public:
  TestStream(OniSensorType sensor, const std::string& uri)
      : sensor_(sensor),
        is_mirrored_(uri.ends_with("/mirrored")),
        is_damaged_(sensor == ONI_SENSOR_DEPTH && uri.ends_with("/damaged")),
        late_us_(sensor == ONI_SENSOR_COLOR && uri.ends_with("/apart") ? 500'000 : 0) {
    const bool stops = sensor == ONI_SENSOR_DEPTH && uri.ends_with("/colour-only");
    if (stops || uri.ends_with("/silent")) num_frames_ = 10;
  }
  ~TestStream() override { stop(); }

  OniStatus start() override {
    is_running_ = true;
    thread_ = std::thread([this] { send(); });
    return ONI_STATUS_OK;
  }
  void stop() override {
    is_running_ = false;
    if (thread_.joinable()) thread_.join();
  }

  OniBool isPropertySupported(int id) override {
    // The recorder asks for the cropping, and records nothing where there is none.
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_MIRRORING ||
           id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV || id == ONI_STREAM_PROPERTY_VERTICAL_FOV ||
           id == ONI_STREAM_PROPERTY_CROPPING || id == ONI_STREAM_PROPERTY_MAX_VALUE ||
           id == ONI_STREAM_PROPERTY_MIN_VALUE;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return give(mode_of(sensor_), data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return give(static_cast<OniBool>(is_mirrored_ ? 1 : 0), data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return give(2.0F * std::atan(0.5F), data, size);  // Focal length: the picture's width.
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return give(2.0F * std::atan(0.5F), data, size);
      case ONI_STREAM_PROPERTY_CROPPING:
        return give(OniCropping{0, 0, 0, kWidth, kHeight}, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return give(10000, data, size);
      case ONI_STREAM_PROPERTY_MIN_VALUE:
        return give(0, data, size);
      default:
        return ONI_STATUS_NOT_SUPPORTED;
    }
  }
  OniStatus setProperty(int id, const void*, int) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }

 private:
  template <class T>
  static OniStatus give(const T& value, void* data, int* size) {
    if (*size < static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof(T));
    *size = sizeof(T);
    return ONI_STATUS_OK;
  }

  void send() {
    for (int i = 1; is_running_ && (num_frames_ == 0 || i <= num_frames_); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      OniFrame* frame = getServices().acquireFrame();
      if (frame == nullptr) continue;
      frame->frameIndex = i;
      frame->timestamp = static_cast<std::uint64_t>(i) * 10'000 + late_us_;
      frame->sensorType = sensor_;
      frame->videoMode = mode_of(sensor_);
      frame->width = kWidth;
      frame->height = kHeight;
      frame->croppingEnabled = 0;
      frame->cropOriginX = frame->cropOriginY = 0;
      if (sensor_ == ONI_SENSOR_DEPTH) {
        fill_depth(*frame, i);
      } else {
        fill_color(*frame, i);
      }
      if (is_damaged_) frame->height /= 2;
      raiseNewFrame(frame);
      getServices().releaseFrame(frame);
    }
  }

  static void fill_depth(OniFrame& frame, int i) {
    auto* pixels = static_cast<std::uint16_t*>(frame.data);
    std::fill_n(pixels, kWidth * kHeight, static_cast<std::uint16_t>(700 + i % 100));
    pixels[0] = 0;
    pixels[1] = 1000;
    frame.stride = kWidth * 2;
    frame.dataSize = frame.stride * kHeight;
  }
  static void fill_color(OniFrame& frame, int i) {
    auto* pixels = static_cast<OniRGB888Pixel*>(frame.data);
    std::fill_n(
        pixels, kWidth * kHeight, OniRGB888Pixel{static_cast<std::uint8_t>(i % 100), 20, 30});
    pixels[0] = {200, 0, 0};
    frame.stride = kWidth * 3;
    frame.dataSize = frame.stride * kHeight;
  }

  OniSensorType sensor_;
  bool is_mirrored_;
  bool is_damaged_;
  std::uint64_t late_us_;
  int num_frames_ = 0;  ///< 0: no end.
  std::atomic<bool> is_running_ = false;
  std::thread thread_;
};

class TestDevice : public oni::driver::DeviceBase {
 public:
  explicit TestDevice(std::string uri) : uri_(std::move(uri)) {}

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    return new TestStream(sensor, uri_);  // NOLINT: OpenNI2 owns it
  }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }  // NOLINT

 private:
  std::string uri_;
  OniVideoMode modes_[2] = {mode_of(ONI_SENSOR_DEPTH), mode_of(ONI_SENSOR_COLOR)};
  OniSensorInfo sensors_[2] = {{ONI_SENSOR_DEPTH, 1, &modes_[0]},
                               {ONI_SENSOR_COLOR, 1, &modes_[1]}};
};

class TestDriver : public oni::driver::DriverBase {
 public:
  explicit TestDriver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed,
                       void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    for (const char* kind : {"", "/mirrored", "/silent", "/colour-only", "/damaged", "/apart"}) {
      OniDeviceInfo info{};
      std::strncpy(info.uri, (std::string(kUri) + kind).c_str(), ONI_MAX_STR - 1);
      std::strncpy(info.vendor, "Morgagni", ONI_MAX_STR - 1);
      std::strncpy(info.name, "Test", ONI_MAX_STR - 1);
      deviceConnected(&info);
    }
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    return new TestDevice(uri);  // NOLINT: OpenNI2 owns it
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }  // NOLINT
  void shutdown() override {}
};

}  // namespace

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(p) delete (p)
ONI_EXPORT_DRIVER(TestDriver)
