// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/v4l2_camera.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>

#include <libyuv.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/device_id.h"
#include "morgagni/camera/internal/calibration_file.h"
#include "morgagni/camera/internal/key_values.h"
#include "morgagni/camera/internal/v4l2/video_stream.h"
#include "morgagni/core/image_jpeg.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

using internal::VideoPicture;
using internal::VideoStream;
using internal::VideoSystem;
using Clock = std::chrono::steady_clock;

constexpr int kPollMs = 100;
constexpr std::chrono::milliseconds kPatience{500};
/// Half a frame apart: the colour picture belongs to the depth picture.
constexpr std::chrono::milliseconds kMaxApart{17};
/// Two frames on, its colour will not come any more.
constexpr std::chrono::milliseconds kWaitsFor{70};
constexpr double kGreyNearMm = 300.0, kGreyFarMm = 2000.0;

tl::unexpected<Error> device_error(std::string message) {
  return make_error(ErrorCode::kDevice, std::move(message));
}

Image<std::uint16_t> depth_of(const VideoStream& stream, const VideoPicture& picture) {
  Image<std::uint16_t> depth_mm(stream.width_px(), stream.height_px());
  for (int y = 0; y < depth_mm.height(); ++y) {
    std::memcpy(depth_mm.view().row(y),
                picture.bytes.data() + static_cast<std::size_t>(y) * stream.row_bytes(),
                static_cast<std::size_t>(depth_mm.width()) * sizeof(std::uint16_t));
  }
  return depth_mm;
}

Result<Image<Rgb8>> color_of(const VideoStream& stream, const VideoPicture& picture) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.bytes.data());
  if (stream.format() == internal::kMjpg) {
    MOR_TRY(const auto size, read_jpeg_size(picture.bytes));
    if (size.width_px != stream.width_px() || size.height_px != stream.height_px()) {
      return device_error(
          fmt::format("a colour picture of {}x{} px", size.width_px, size.height_px));
    }
    return decode_jpeg(picture.bytes);
  }
  Image<Rgb8> color(stream.width_px(), stream.height_px());
  if (stream.format() == internal::kRgb3) {
    for (int y = 0; y < color.height(); ++y) {
      std::memcpy(static_cast<void*>(color.view().row(y)),
                  bytes + static_cast<std::size_t>(y) * stream.row_bytes(),
                  static_cast<std::size_t>(color.width()) * sizeof(Rgb8));
    }
    return color;
  }
  Image<Rgba8> wide(color.width(), color.height());
  auto* argb = reinterpret_cast<std::uint8_t*>(wide.data());
  const int wide_bytes = color.width() * 4;
  libyuv::YUY2ToARGB(
      bytes, static_cast<int>(stream.row_bytes()), argb, wide_bytes, color.width(), color.height());
  // libyuv's RAW is red, green, blue.
  libyuv::ARGBToRAW(argb,
                    wide_bytes,
                    reinterpret_cast<std::uint8_t*>(color.data()),
                    color.width() * 3,
                    color.width(),
                    color.height());
  return color;
}

/// Near is bright; no reading is black.
Image<Rgb8> grey_of(const Image<std::uint16_t>& depth_mm) {
  Image<Rgb8> grey(depth_mm.width(), depth_mm.height());
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const double share = (kGreyFarMm - depth_mm.data()[i]) / (kGreyFarMm - kGreyNearMm);
    const auto value = static_cast<std::uint8_t>(40.0 + 215.0 * std::clamp(share, 0.0, 1.0));
    if (depth_mm.data()[i] != 0) grey.data()[i] = {value, value, value};
  }
  return grey;
}

/// As a RealSense D435 is built, at any picture size.
RgbdCalibration design(const VideoStream& depth, const VideoStream* color) {
  const auto pinhole = [](const VideoStream& stream, double focal_per_height) {
    const double focal_px = focal_per_height * stream.height_px();
    return PinholeCamera{stream.width_px(),
                         stream.height_px(),
                         focal_px,
                         focal_px,
                         (stream.width_px() - 1) / 2.0,
                         (stream.height_px() - 1) / 2.0};
  };
  RgbdCalibration calibration;
  calibration.depth = pinhole(depth, 0.80);
  calibration.color = color != nullptr ? pinhole(*color, 1.28) : calibration.depth;
  if (color != nullptr) calibration.color_from_depth.translation().x() = 15.0;
  return calibration;
}

class V4l2Camera final : public RangeCamera {
 public:
  V4l2Camera(std::shared_ptr<const VideoSystem> system,
             VideoStream depth,
             std::optional<VideoStream> color,
             std::string device_id,
             RgbdCalibration calibration)
      : system_(std::move(system)),
        depth_(std::move(depth)),
        color_(std::move(color)),
        device_id_(std::move(device_id)),
        calibration_(std::make_shared<const RgbdCalibration>(std::move(calibration))) {}

  Result<void> start() {
    if (color_) MOR_CHECK(color_->start());
    return depth_.start();
  }

  Result<std::shared_ptr<const RgbdFrame>> next_frame(std::stop_token stop) override {
    const auto until = Clock::now() + kPatience;
    while (!stop.stop_requested()) {
      MOR_CHECK(take_depth());
      MOR_CHECK(take_color());
      if (is_complete()) return finished();
      if (Clock::now() > until) return device_error(why_silent());
      MOR_CHECK(wait());
    }
    return nullptr;
  }

  const RgbdCalibration& calibration() const override { return *calibration_; }

  std::string device_id() const override { return device_id_; }

 private:
  Result<void> wait() {
    pollfd files[] = {{depth_.file(), POLLIN, 0}, {color_ ? color_->file() : -1, POLLIN, 0}};
    // An error of poll itself is a signal or is said by the next picture that is taken.
    if (system_->poll(files, color_ ? 2 : 1, kPollMs) <= 0) return {};
    for (const auto& each : files) {
      if ((each.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
        return device_error("the camera is gone: is its plug out?");
      }
    }
    return {};
  }

  Result<void> take_depth() {
    MOR_TRY(const auto picture, depth_.take());
    if (!picture) return {};
    auto frame = std::make_shared<RgbdFrame>();
    frame->depth_mm = depth_of(depth_, *picture);
    frame->captured_at = picture->at;
    frame->device_time = picture->driver_time;
    frame->calibration = calibration_;
    waiting_ = std::move(frame);
    return {};
  }

  Result<void> take_color() {
    if (!color_) return {};
    MOR_TRY(const auto picture, color_->take());
    if (!picture) return {};
    auto color = color_of(*color_, *picture);
    if (!color) {
      ++num_bad_colors_;
      return {};
    }
    last_color_ = *std::move(color);
    last_color_at_ = picture->at;
    return {};
  }

  [[nodiscard]] bool is_complete() {
    if (!waiting_ || !color_) return waiting_ != nullptr;
    if (!last_color_.empty() &&
        std::chrono::abs(waiting_->captured_at - last_color_at_) <= kMaxApart) {
      return true;
    }
    if (Clock::now() - waiting_->captured_at > kWaitsFor) waiting_.reset();
    return false;
  }

  Result<std::shared_ptr<const RgbdFrame>> finished() {
    waiting_->color = color_ ? last_color_ : grey_of(waiting_->depth_mm);
    waiting_->frame_id = next_id_++;
    return std::exchange(waiting_, nullptr);
  }

  [[nodiscard]] std::string why_silent() const {
    if (depth_.num_damaged() > 0) return "the camera sends damaged depth pictures";
    if (color_ && (color_->num_damaged() > 0 || num_bad_colors_ > 0)) {
      return "the camera sends damaged colour pictures";
    }
    if (color_ && last_color_.empty()) return "the camera sends no colour pictures";
    if (color_ && waiting_) return "the camera's colour and depth are stamped too far apart";
    return "the camera sends no depth pictures";
  }

  std::shared_ptr<const VideoSystem> system_;
  VideoStream depth_;
  std::optional<VideoStream> color_;
  std::string device_id_;
  std::shared_ptr<const RgbdCalibration> calibration_;

  std::shared_ptr<RgbdFrame> waiting_;  ///< Depth whose colour has not come yet.
  Image<Rgb8> last_color_;
  Clock::time_point last_color_at_;
  std::uint64_t num_bad_colors_ = 0;
  std::uint64_t next_id_ = 0;
};

bool has_format(const internal::VideoDevice& device, std::uint32_t format) {
  return std::ranges::find(device.formats, format) != device.formats.end();
}

std::shared_ptr<const VideoSystem> or_real(std::shared_ptr<const VideoSystem> system) {
  return system ? std::move(system) : internal::real_video_system();
}

/// "v4l2-904412060323", or by where it is plugged in, "v4l2-usb-0000-00-14.0-2". The interface of a
/// USB device is the folder below that with its number.
std::string device_id_of(const std::filesystem::path& sysfs,
                         const std::string& device,
                         const std::string& bus) {
  std::error_code status;
  const auto name = std::filesystem::path(device).filename();
  const auto place = std::filesystem::canonical(sysfs / name / "device", status);
  std::ifstream file(place.parent_path() / "serial");
  std::string serial;
  if (!status) std::getline(file, serial);
  auto id = plain_device_id(serial);
  if (id.empty()) id = plain_device_id(bus);
  return id.empty() ? id : "v4l2-" + id;
}

/// The number in "video12". None: another name.
std::optional<int> video_number(const std::string& name) {
  constexpr std::string_view kVideo = "video";
  if (!name.starts_with(kVideo) || name.size() == kVideo.size() || name.size() > 8) return {};
  const auto digits = name.substr(kVideo.size());
  if (!std::ranges::all_of(digits, [](char each) { return each >= '0' && each <= '9'; })) return {};
  return std::stoi(digits);
}

}  // namespace

Result<V4l2Options> V4l2Options::parse(std::string_view text) {
  V4l2Options options;
  const auto comma = text.find(',');
  options.depth_device = text.substr(0, comma);
  if (options.depth_device.empty()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        "camera 'v4l2:' needs a device: v4l2:/dev/videoN (`morgagni doctor` lists them)");
  }
  const auto rest = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  MOR_TRY(const auto pairs, internal::split_key_values(rest));
  for (const auto& pair : pairs) {
    if (pair.key == "color") {
      options.color_device = pair.value;
    } else if (pair.key == "calibration") {
      options.calibration_file = pair.value;
    } else if (pair.key == "format") {
      MOR_TRY(const auto choice, internal::parse_choice(pair, {"z16", "y16"}));
      options.is_y16 = choice == 1;
    } else if (pair.key == "device") {
      MOR_TRY(options.device_id, internal::parse_device_id(pair));
    } else {
      return internal::unknown_key("v4l2", pair, {"color", "calibration", "device", "format"});
    }
  }
  return options;
}

Result<std::unique_ptr<RangeCamera>> open_v4l2(const V4l2Options& options,
                                               std::shared_ptr<const VideoSystem> given) {
  constexpr std::uint32_t kColorFormats[] = {internal::kYuyv, internal::kMjpg, internal::kRgb3};
  const auto system = or_real(std::move(given));
  const std::uint32_t depth_formats[] = {options.is_y16 ? internal::kY16 : internal::kZ16};
  MOR_TRY(auto depth, VideoStream::open(system, options.depth_device, depth_formats));
  std::optional<VideoStream> color;
  if (!options.color_device.empty()) {
    MOR_TRY(auto opened, VideoStream::open(system, options.color_device, kColorFormats));
    color.emplace(std::move(opened));
  }
  auto device_id = options.device_id.empty()
                       ? device_id_of(options.sysfs, options.depth_device, depth.bus())
                       : options.device_id;
  MOR_TRY(auto calibration,
          internal::choose_calibration(options.calibration_file,
                                       options.known,
                                       device_id,
                                       design(depth, color ? &*color : nullptr)));
  auto camera = std::make_unique<V4l2Camera>(
      system, std::move(depth), std::move(color), std::move(device_id), std::move(calibration));
  MOR_CHECK(camera->start());
  return camera;
}

std::vector<DepthVideoDevice> list_depth_video_devices(const std::filesystem::path& folder,
                                                       const std::filesystem::path& sysfs,
                                                       std::shared_ptr<const VideoSystem> given) {
  const auto system = or_real(std::move(given));
  std::vector<std::pair<int, std::string>> paths;
  std::error_code status;
  for (const auto& entry : std::filesystem::directory_iterator(folder, status)) {
    if (const auto number = video_number(entry.path().filename())) {
      paths.emplace_back(*number, entry.path());
    }
  }
  std::ranges::sort(paths);
  std::vector<DepthVideoDevice> found;
  struct Color {
    int number;
    std::string path;
    std::string card;
  };
  std::vector<Color> colors;
  for (const auto& [number, path] : paths) {
    const auto device = internal::look_at_video_device(*system, path);
    if (!device && device.error().code == ErrorCode::kDevice) {
      found.push_back(
          {path,
           "",
           "",
           "this user may not use it: sudo usermod -aG video $USER, then log in again"});
    } else if (device && has_format(*device, internal::kZ16)) {
      found.push_back(
          {path, device->card, "v4l2:" + path, "", device_id_of(sysfs, path, device->bus)});
    } else if (device &&
               (has_format(*device, internal::kYuyv) || has_format(*device, internal::kMjpg))) {
      colors.push_back({number, path, device->card});
    }
  }
  // The colour of a camera is another device of the same card, with a higher number.
  for (auto& depth : found) {
    const auto color = std::ranges::find_if(colors, [&](const auto& each) {
      return !depth.card.empty() && each.card == depth.card &&
             each.number > video_number(std::filesystem::path(depth.path).filename());
    });
    if (color != colors.end()) depth.camera += ",color=" + color->path;
  }
  return found;
}

}  // namespace mor
