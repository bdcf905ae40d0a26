// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/push_camera.h"

#include <charconv>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/push/picture_decoder.h"
#include "morgagni/camera/internal/push/push_server.h"
#include "morgagni/camera/watched_camera.h"
#include "morgagni/core/files.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

using internal::push::Inbox;
using internal::push::Pair;
using internal::push::PushServer;

constexpr std::chrono::milliseconds kPatience{500};
constexpr std::chrono::seconds kRemindEach{10};
constexpr std::size_t kMinTokenBytes = 8;
constexpr std::uintmax_t kMaxCalibrationBytes = 1U << 20U;

tl::unexpected<Error> invalid(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

Result<std::shared_ptr<const RgbdFrame>> unpack(Pair pair, std::uint64_t frame_id) {
  auto frame = std::make_shared<RgbdFrame>();
  const auto& [depth, color] = std::tie(pair.calibration->depth, pair.calibration->color);
  MOR_TRY(frame->depth_mm,
          internal::push::decode_depth_picture(pair.depth, {depth.width_px, depth.height_px}));
  MOR_TRY(frame->color,
          internal::push::decode_color_picture(pair.color, {color.width_px, color.height_px}));
  frame->frame_id = frame_id;
  frame->captured_at = pair.arrived_at;
  frame->device_time = std::chrono::nanoseconds(pair.depth.stamp_ns);
  frame->calibration = std::move(pair.calibration);
  return frame;
}

/// One life of the device; the server outlives it.
class PushCamera final : public RangeCamera {
 public:
  PushCamera(std::shared_ptr<PushServer> server,
             std::shared_ptr<const RgbdCalibration> calibration,
             std::string device_id)
      : server_(std::move(server)),
        calibration_(std::move(calibration)),
        device_id_(std::move(device_id)) {}

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    auto pair = server_->inbox().wait(kPatience, stop);
    if (stop.stop_requested()) return nullptr;
    if (!pair) return make_error(ErrorCode::kDevice, server_->inbox().reason());
    auto frame = unpack(*std::move(pair), next_id_);
    if (!frame) {
      server_->complain(frame.error().message);
      return make_error(ErrorCode::kDevice, server_->inbox().reason());
    }
    ++next_id_;
    return frame;
  }

  const RgbdCalibration& calibration() const override { return *calibration_; }
  std::string device_id() const override { return device_id_; }

 private:
  std::shared_ptr<PushServer> server_;
  std::shared_ptr<const RgbdCalibration> calibration_;
  std::string device_id_;
  std::uint64_t next_id_ = 0;
};

/// Who a device is, and how it sees.
struct Device {
  std::shared_ptr<const RgbdCalibration> calibration;
  std::string id;
};

/// The first one that sends a frame that can be unpacked.
Result<Device> first_device(PushServer& server, std::stop_token stop, const SayWaiting& say) {
  std::string said;
  auto said_at = std::chrono::steady_clock::now();
  while (!stop.stop_requested()) {
    auto pair = server.inbox().wait(kPatience, stop);
    if (pair) {
      Device device{pair->calibration, pair->device_id};
      const auto frame = unpack(*std::move(pair), 0);
      if (frame) return device;
      server.complain(frame.error().message);
    }
    const auto now = std::chrono::steady_clock::now();
    auto reason = server.inbox().reason();
    if (stop.stop_requested() || (reason == said && now - said_at < kRemindEach)) continue;
    if (!say) {
      log::info("push: {}", reason);
    } else if (reason != said) {
      say(reason);
    }
    said = std::move(reason);
    said_at = now;
  }
  return make_error(ErrorCode::kCancelled, "stopped before a device pushed a frame");
}

Result<std::shared_ptr<const RgbdCalibration>> calibration_from_file(const std::string& path) {
  if (path.empty()) return nullptr;
  MOR_TRY(const auto text, read_text_file(path, kMaxCalibrationBytes));
  auto calibration = calibration_from_json(text);
  if (calibration) {
    if (calibration->origin.empty()) calibration->origin = path;
    return std::make_shared<const RgbdCalibration>(*std::move(calibration));
  }
  return make_error(calibration.error().code,
                    fmt::format("{}: {}", path, calibration.error().message));
}

Result<void> parse_place(std::string_view place, PushOptions& options) {
  const auto colon = place.rfind(':');
  auto host = place.substr(0, colon == std::string_view::npos ? 0 : colon);
  const auto port = colon == std::string_view::npos ? place : place.substr(colon + 1);
  const auto [end, status] = std::from_chars(port.data(), port.data() + port.size(), options.port);
  if (status != std::errc() || end != port.data() + port.size()) {
    return invalid(fmt::format(
        "camera 'push:' needs a port, push:[HOST:]PORT with PORT in [0, 65535], got '{}'", place));
  }
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  if (!host.empty()) options.host = host;
  return {};
}

}  // namespace

Result<PushOptions> PushOptions::parse(std::string_view text) {
  PushOptions options;
  const auto comma = text.find(',');
  MOR_CHECK(parse_place(text.substr(0, comma), options));
  const auto rest = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  MOR_TRY(const auto pairs, internal::split_key_values(rest));
  for (const auto& pair : pairs) {
    if (pair.key == "token") {
      options.token = pair.value;
      if (options.token.size() < kMinTokenBytes) {
        return invalid(fmt::format("token must have at least {} characters", kMinTokenBytes));
      }
    } else if (pair.key == "calibration") {
      options.calibration_file = pair.value;
    } else if (pair.key == "device") {
      MOR_TRY(options.device_id, internal::parse_device_id(pair));
    } else if (pair.key == "tolerance_ms") {
      MOR_TRY(const auto tolerance, internal::parse_count(pair, 1, 1000));
      options.tolerance = std::chrono::milliseconds(tolerance);
    } else {
      return internal::unknown_key(
          "push", pair, {"token", "calibration", "device", "tolerance_ms"});
    }
  }
  return options;
}

Result<std::unique_ptr<RangeCamera>> open_push(const PushOptions& options,
                                               std::stop_token stop,
                                               const SayWaiting& say) {
  Device device{nullptr, options.device_id};
  MOR_TRY(device.calibration, calibration_from_file(options.calibration_file));
  MOR_TRY(std::shared_ptr<PushServer> server,
          PushServer::start(
              {options.host, options.port, options.token}, [&](const std::string& address) {
                return std::make_shared<Inbox>(
                    address,
                    internal::push::InboxOptions{
                        options.tolerance, device.calibration, options.device_id, options.known});
              }));
  log::info("push: listening at {}", server->address());
  if (!device.calibration) {
    MOR_TRY(device, first_device(*server, std::move(stop), say));
  }
  return watch_camera([server, device]() -> Result<std::unique_ptr<RangeCamera>> {
    return std::make_unique<PushCamera>(server, device.calibration, device.id);
  });
}

}  // namespace mor
