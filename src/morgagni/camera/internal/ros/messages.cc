// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/ros/messages.h"

#include <array>
#include <cstring>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/ros/cdr.h"
#include "morgagni/core/image_jpeg.h"
#include "morgagni/core/image_png.h"

namespace mor::internal::ros {
namespace {

constexpr std::uint64_t kNsPerS = 1'000'000'000;
constexpr double kMmPerM = 1000.0;
constexpr std::uint32_t kMaxSidePx = 16384;
constexpr std::uint32_t kMaxValues = 1000;

void put_time(CdrWriter& out, std::uint64_t time_ns) {
  out.put(static_cast<std::int32_t>(time_ns / kNsPerS));
  out.put(static_cast<std::uint32_t>(time_ns % kNsPerS));
}

void put_header(CdrWriter& out, const Header& header) {
  put_time(out, header.stamp_ns);
  out.put_string(header.frame);
}

template <class Range>
void put_all(CdrWriter& out, const Range& numbers) {
  for (const double number : numbers) out.put(number);
}

std::uint64_t take_time(CdrReader& in) {
  const auto seconds = in.take<std::int32_t>();
  const auto nanoseconds = in.take<std::uint32_t>();
  return static_cast<std::uint64_t>(seconds) * kNsPerS + nanoseconds;
}

void skip_header(CdrReader& in) {
  (void)take_time(in);
  (void)in.take_string();
}

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

}  // namespace

Bytes encode_depth(const Header& header, ImageView<const std::uint16_t> depth_mm) {
  CdrWriter out;
  put_header(out, header);
  out.put(static_cast<std::uint32_t>(depth_mm.height()));
  out.put(static_cast<std::uint32_t>(depth_mm.width()));
  out.put_string("16UC1");
  out.put(std::uint8_t{0});
  const auto step = static_cast<std::uint32_t>(depth_mm.width()) * 2;
  out.put(step);
  out.put_size(std::size_t{step} * static_cast<std::size_t>(depth_mm.height()));
  for (int y = 0; y < depth_mm.height(); ++y) {
    out.put_bytes(
        std::as_bytes(std::span(depth_mm.row(y), static_cast<std::size_t>(depth_mm.width()))));
  }
  return out.take();
}

Bytes encode_compressed(const Header& header,
                        std::string_view format,
                        std::span<const std::byte> picture) {
  CdrWriter out;
  put_header(out, header);
  out.put_string(format);
  out.put_size(picture.size());
  out.put_bytes(picture);
  return out.take();
}

Bytes encode_camera_info(const Header& header, const PinholeCamera& camera) {
  const double fx = camera.focal_x_px, fy = camera.focal_y_px;
  const double cx = camera.center_x_px, cy = camera.center_y_px;
  CdrWriter out;
  put_header(out, header);
  out.put(static_cast<std::uint32_t>(camera.height_px));
  out.put(static_cast<std::uint32_t>(camera.width_px));
  out.put_string("plumb_bob");  // Brown and Conrady: k1, k2, p1, p2, k3.
  out.put_size(camera.distortion.size());
  put_all(out, camera.distortion);
  put_all(out, std::array{fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0});
  put_all(out, std::array{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
  put_all(out, std::array{fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0});
  for (int i = 0; i < 6; ++i) out.put(std::uint32_t{0});  // No binning, the whole picture.
  out.put(std::uint8_t{0});
  return out.take();
}

Bytes encode_time_reference(const Header& header, std::uint64_t other_ns, std::string_view source) {
  CdrWriter out;
  put_header(out, header);
  put_time(out, other_ns);
  out.put_string(source);
  return out.take();
}

Bytes encode_transform(const Header& header,
                       std::string_view child,
                       const Eigen::Isometry3d& parent_from_child) {
  const Eigen::Vector3d position_m = parent_from_child.translation() / kMmPerM;
  const Eigen::Quaterniond q(parent_from_child.linear());
  CdrWriter out;
  out.put_size(1);
  put_header(out, header);
  out.put_string(child);
  put_all(out, position_m);
  put_all(out, std::array{q.x(), q.y(), q.z(), q.w()});
  return out.take();
}

Bytes encode_diagnostic(const Header& header, const Diagnostic& diagnostic) {
  CdrWriter out;
  put_header(out, header);
  out.put_size(1);
  out.put(static_cast<std::uint8_t>(diagnostic.level));
  out.put_string(diagnostic.name);
  out.put_string(diagnostic.message);
  out.put_string("morgagni");
  out.put_size(diagnostic.values.size());
  for (const auto& [key, value] : diagnostic.values) {
    out.put_string(key);
    out.put_string(value);
  }
  return out.take();
}

Result<Image<std::uint16_t>> decode_depth(std::span<const std::byte> message) {
  CdrReader in(message);
  skip_header(in);
  const auto height = in.take<std::uint32_t>();
  const auto width = in.take<std::uint32_t>();
  const auto encoding = in.take_string();
  const auto is_big_endian = in.take<std::uint8_t>();
  const auto step = in.take<std::uint32_t>();
  const auto data = in.take_bytes(in.take<std::uint32_t>());
  if (!in.ok()) return bad("a depth picture is cut short");
  if (encoding != "16UC1" || is_big_endian != 0) {
    return bad(fmt::format("a depth picture of encoding '{}', only 16UC1 is read", encoding));
  }
  if (width == 0 || height == 0 || width > kMaxSidePx || height > kMaxSidePx || step < 2 * width ||
      data.size() != std::uint64_t{step} * height) {
    return bad(fmt::format("a depth picture of {}x{} px, {} bytes a row and {} in all",
                           width,
                           height,
                           step,
                           data.size()));
  }
  Image<std::uint16_t> image(static_cast<int>(width), static_cast<int>(height));
  for (std::uint32_t y = 0; y < height; ++y) {
    std::memcpy(image.view().row(static_cast<int>(y)),
                data.data() + std::size_t{y} * step,
                std::size_t{width} * 2);
  }
  return image;
}

Result<Image<Rgb8>> decode_color(std::span<const std::byte> message) {
  CdrReader in(message);
  skip_header(in);
  const auto format = in.take_string();
  const auto data = in.take_bytes(in.take<std::uint32_t>());
  if (!in.ok()) return bad("a colour picture is cut short");
  if (format == "png") return decode_png_rgb(data);
  if (format == "jpeg") return decode_jpeg(data);
  return bad(fmt::format("a colour picture of format '{}', only jpeg and png are read", format));
}

Result<Diagnostic> decode_diagnostic(std::span<const std::byte> message) {
  CdrReader in(message);
  skip_header(in);
  const auto count = in.take<std::uint32_t>();
  Diagnostic diagnostic;
  diagnostic.level = static_cast<Level>(in.take<std::uint8_t>());
  diagnostic.name = in.take_string();
  diagnostic.message = in.take_string();
  (void)in.take_string();
  const auto num_values = in.take<std::uint32_t>();
  if (!in.ok() || count != 1 || num_values > kMaxValues) return bad("a diagnostic is cut short");
  for (std::uint32_t i = 0; i < num_values; ++i) {
    const auto key = in.take_string();
    diagnostic.values.emplace_back(key, in.take_string());
  }
  if (!in.ok()) return bad("a diagnostic is cut short");
  return diagnostic;
}

Result<std::uint64_t> decode_time_reference(std::span<const std::byte> message) {
  CdrReader in(message);
  skip_header(in);
  const auto time_ns = take_time(in);
  if (!in.ok()) return bad("a time reference is cut short");
  return time_ns;
}

}  // namespace mor::internal::ros
