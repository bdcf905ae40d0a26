// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/messages.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/ros/cdr.h"

namespace mor::internal::push {
namespace {

using ros::CdrReader;

constexpr double kMmPerM = 1000.0;
constexpr std::uint64_t kNsPerS = 1'000'000'000;
constexpr std::uint32_t kMaxCoefficients = 14;
constexpr std::uint32_t kMaxTransforms = 64;
constexpr std::size_t kMaxNameBytes = 256;
constexpr std::int64_t kMaxPixels = 16'000'000;  // An Azure Kinect's colour has 12.6 million.
constexpr double kMaxQuaternionError = 1e-3;

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

bool all_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

std::uint64_t take_stamp(CdrReader& in) {
  const auto seconds = in.take<std::int32_t>();
  const auto nanoseconds = in.take<std::uint32_t>();
  return static_cast<std::uint64_t>(std::max(seconds, 0)) * kNsPerS + nanoseconds;
}

std::string take_name(CdrReader& in) {
  return std::string(in.take_string().substr(0, kMaxNameBytes));
}

void take_all(CdrReader& in, std::span<double> numbers) {
  for (double& number : numbers) number = in.take<double>();
}

std::vector<std::byte> take_data(CdrReader& in) {
  const auto data = in.take_bytes(in.take<std::uint32_t>());
  return {data.begin(), data.end()};
}

Result<Message> parse_picture(CdrReader& in, bool is_compressed) {
  Picture picture{.is_compressed = is_compressed};
  picture.stamp_ns = take_stamp(in);
  picture.frame = take_name(in);
  if (!is_compressed) {
    picture.height_px = in.take<std::uint32_t>();
    picture.width_px = in.take<std::uint32_t>();
  }
  picture.encoding = take_name(in);
  if (!is_compressed) {
    picture.is_big_endian = in.take<std::uint8_t>() != 0;
    picture.row_bytes = in.take<std::uint32_t>();
  }
  picture.data = take_data(in);
  if (!in.ok()) return bad("a picture is cut short");
  return picture;
}

Result<Message> parse_camera_info(CdrReader& in) {
  RawCameraInfo raw;
  (void)take_stamp(in);
  raw.frame = take_name(in);
  raw.height_px = in.take<std::uint32_t>();
  raw.width_px = in.take<std::uint32_t>();
  raw.lens_model = take_name(in);
  const auto num_coefficients = in.take<std::uint32_t>();
  if (!in.ok() || num_coefficients > kMaxCoefficients) {
    return bad(fmt::format("a CameraInfo with {} lens coefficients", num_coefficients));
  }
  raw.d.resize(num_coefficients);
  take_all(in, raw.d);
  take_all(in, raw.k);
  std::array<double, 9> rotation{};
  take_all(in, rotation);
  take_all(in, raw.p);
  const auto binning_x = in.take<std::uint32_t>(), binning_y = in.take<std::uint32_t>();
  const auto left = in.take<std::uint32_t>(), top = in.take<std::uint32_t>();
  raw.is_part = binning_x > 1 || binning_y > 1 || left > 0 || top > 0;
  if (!in.ok()) return bad("a CameraInfo is cut short");
  return checked(raw);
}

Result<Message> parse_transforms(CdrReader& in) {
  const auto count = in.take<std::uint32_t>();
  if (!in.ok() || count > kMaxTransforms) {
    return bad(fmt::format("a TFMessage of {} transforms, {} are read", count, kMaxTransforms));
  }
  std::vector<Transform> transforms;
  for (std::uint32_t i = 0; i < count; ++i) {
    (void)take_stamp(in);
    auto parent = take_name(in);
    auto child = take_name(in);
    Eigen::Vector3d position_m;
    Eigen::Vector4d xyzw;
    take_all(in, {position_m.data(), 3});
    take_all(in, {xyzw.data(), 4});
    if (!in.ok()) return bad("a TFMessage is cut short");
    MOR_TRY(auto transform, checked(std::move(parent), std::move(child), position_m, xyzw));
    transforms.push_back(std::move(transform));
  }
  return transforms;
}

/// The five coefficients of Brown and Conrady. Models with more pass where the others are zero.
Result<std::array<double, 5>> distortion_of(const RawCameraInfo& raw) {
  std::array<double, 5> distortion{};
  const bool is_known = raw.lens_model.empty() || raw.lens_model == "plumb_bob" ||
                        raw.lens_model == "rational_polynomial";
  const bool is_none = std::ranges::all_of(raw.d, [](double number) { return number == 0.0; });
  if (is_none) return distortion;
  const auto past_five = std::span(raw.d).subspan(std::min<std::size_t>(raw.d.size(), 5));
  if (!is_known || !std::ranges::all_of(past_five, [](double number) { return number == 0.0; })) {
    return bad(fmt::format(
        "the lens model '{}' of {} coefficients is not known, only plumb_bob of five: send "
        "rectified pictures (image_rect)",
        raw.lens_model,
        raw.d.size()));
  }
  std::ranges::copy_n(raw.d.begin(),
                      static_cast<std::ptrdiff_t>(std::min<std::size_t>(raw.d.size(), 5)),
                      distortion.begin());
  return distortion;
}

}  // namespace

std::optional<MessageKind> message_kind(std::string_view schema_name) {
  const auto slash = schema_name.rfind('/');
  const auto type = slash == std::string_view::npos ? schema_name : schema_name.substr(slash + 1);
  auto package = schema_name.substr(0, slash == std::string_view::npos ? 0 : slash);
  if (package.ends_with("/msg")) package.remove_suffix(4);
  if (package == "tf2_msgs" && type == "TFMessage") return MessageKind::kTransforms;
  if (package != "sensor_msgs") return std::nullopt;
  if (type == "Image") return MessageKind::kImage;
  if (type == "CompressedImage") return MessageKind::kCompressedImage;
  if (type == "CameraInfo") return MessageKind::kCameraInfo;
  return std::nullopt;
}

Result<CameraInfo> checked(const RawCameraInfo& raw) {
  if (!all_finite(raw.d) || !all_finite(raw.k) || !all_finite(raw.p)) {
    return bad("a CameraInfo holds a number that is not finite");
  }
  if (raw.is_part) return bad("a CameraInfo of a binned or cut picture: send the whole one");
  constexpr std::uint32_t kMaxSidePx = 16384;
  CameraInfo info{.frame = raw.frame};
  auto& camera = info.as_seen;
  camera.width_px = static_cast<int>(std::min(raw.width_px, kMaxSidePx + 1));
  camera.height_px = static_cast<int>(std::min(raw.height_px, kMaxSidePx + 1));
  camera.focal_x_px = raw.k[0];
  camera.focal_y_px = raw.k[4];
  camera.center_x_px = raw.k[2];
  camera.center_y_px = raw.k[5];
  MOR_TRY(camera.distortion, distortion_of(raw));
  if (const auto good = camera.check(); !good) {
    return bad(fmt::format("a CameraInfo: {}", good.error().message));
  }
  if (std::int64_t{camera.width_px} * camera.height_px > kMaxPixels) {
    return bad(fmt::format("a CameraInfo of {}x{} px, at most {} in all are taken",
                           camera.width_px,
                           camera.height_px,
                           kMaxPixels));
  }
  PinholeCamera rectified{
      camera.width_px, camera.height_px, raw.p[0], raw.p[5], raw.p[2], raw.p[6]};
  if (rectified.check()) info.rectified = rectified;
  return info;
}

Result<Transform> checked(std::string parent,
                          std::string child,
                          const Eigen::Vector3d& position_m,
                          const Eigen::Vector4d& xyzw) {
  const Eigen::Quaterniond q(xyzw);  // Eigen keeps x, y, z, w.
  if (!position_m.allFinite() || !xyzw.allFinite() ||
      std::abs(q.norm() - 1.0) > kMaxQuaternionError) {
    return bad(
        fmt::format("the transform from '{}' to '{}' is no rotation and shift", child, parent));
  }
  Transform transform{.parent = std::move(parent), .child = std::move(child)};
  transform.parent_from_child.linear() = q.normalized().toRotationMatrix();
  transform.parent_from_child.translation() = position_m * kMmPerM;
  return transform;
}

Result<Message> parse_cdr(MessageKind kind, std::span<const std::byte> bytes) {
  CdrReader in(bytes);
  switch (kind) {
    case MessageKind::kImage:
    case MessageKind::kCompressedImage:
      return parse_picture(in, kind == MessageKind::kCompressedImage);
    case MessageKind::kCameraInfo:
      return parse_camera_info(in);
    case MessageKind::kTransforms:
      break;
  }
  return parse_transforms(in);
}

Result<Message> parse_message(MessageKind kind,
                              Encoding encoding,
                              std::span<const std::byte> bytes) {
  return encoding == Encoding::kCdr ? parse_cdr(kind, bytes) : parse_json(kind, bytes);
}

}  // namespace mor::internal::push
