// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/picture_decoder.h"

#include <cmath>
#include <cstring>

#include <spdlog/fmt/fmt.h>
#include <zstd.h>

#include "morgagni/camera/internal/byte_io.h"
#include "morgagni/camera/internal/push/rvl.h"
#include "morgagni/core/image_jpeg.h"
#include "morgagni/core/image_png.h"

namespace mor::internal::push {
namespace {

using Bytes = std::span<const std::byte>;

constexpr double kMmPerM = 1000.0;
/// Of compressedDepth: an enumerator that says nothing, and the two numbers of inverse depth.
constexpr std::size_t kDepthHeadBytes = 12;
constexpr std::size_t kMaxEncodingBytes = 64;

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

bool is_depth_encoding(std::string_view encoding) {
  return encoding == "16UC1" || encoding == "mono16" || encoding == "32FC1";
}

/// ROS writes "16UC1; compressedDepth rvl": the encoding, then how it is packed.
std::string_view encoding_in(const Picture& picture) {
  const std::string_view format = picture.encoding;
  return format.substr(0, format.find(';'));
}

bool is_compressed_depth(const Picture& picture) {
  return picture.is_compressed && picture.encoding.find("compressedDepth") != std::string::npos;
}

Result<void> check_size(std::uint64_t width, std::uint64_t height, PictureSize size) {
  if (width == static_cast<std::uint64_t>(size.width_px) &&
      height == static_cast<std::uint64_t>(size.height_px)) {
    return {};
  }
  return bad(fmt::format("a picture of {}x{} px, the camera's have {}x{}",
                         width,
                         height,
                         size.width_px,
                         size.height_px));
}

/// Rows of pixels that are not packed.
struct Rows {
  std::string encoding;
  std::uint64_t width_px = 0, height_px = 0, row_bytes = 0;
  bool is_big_endian = false;
  Bytes data = {};
  std::vector<std::byte> unpacked = {};  ///< What `data` looks at, where it was packed.
};

Result<void> check_rows(const Rows& rows, std::size_t pixel_bytes, PictureSize size) {
  MOR_CHECK(check_size(rows.width_px, rows.height_px, size));
  if (rows.is_big_endian && pixel_bytes > 1 && is_depth_encoding(rows.encoding)) {
    return bad("a depth picture is big-endian, only little-endian is read");
  }
  if (rows.row_bytes >= rows.width_px * pixel_bytes &&
      rows.data.size() == rows.row_bytes * rows.height_px) {
    return {};
  }
  return bad(fmt::format("a picture of {}x{} px in {} has {} bytes a row and {} in all",
                         rows.width_px,
                         rows.height_px,
                         rows.encoding,
                         rows.row_bytes,
                         rows.data.size()));
}

Rows plain_rows(const Picture& picture) {
  return {.encoding = picture.encoding,
          .width_px = picture.width_px,
          .height_px = picture.height_px,
          .row_bytes = picture.row_bytes,
          .is_big_endian = picture.is_big_endian,
          .data = picture.data};
}

/// zstd_image_transport: height, width, big-endian, bytes a row, the encoding's name, the rows.
Result<Rows> zstd_head(Bytes packed) {
  ByteReader in(packed);
  Rows rows;
  rows.height_px = in.take<std::uint32_t>();
  rows.width_px = in.take<std::uint32_t>();
  rows.is_big_endian = in.take<std::uint8_t>() != 0;
  rows.row_bytes = in.take<std::uint32_t>();
  const auto name_bytes = in.take<std::uint32_t>();
  if (name_bytes > kMaxEncodingBytes) return bad("a zstd picture has no head");
  rows.encoding = in.take_text(name_bytes);
  if (!in.ok()) return bad("a zstd picture is cut short");
  rows.data = packed.subspan(in.position());
  return rows;
}

Result<Rows> unpack_zstd(const Picture& picture, PictureSize size) {
  MOR_TRY(auto rows, zstd_head(picture.data));
  MOR_CHECK(check_size(rows.width_px, rows.height_px, size));
  constexpr std::uint64_t kMaxPixelBytes = 16;
  if (rows.row_bytes > kMaxPixelBytes * rows.width_px)
    return bad("a zstd picture's rows are too long");
  rows.unpacked.resize(rows.row_bytes * rows.height_px);
  const auto num_bytes = ZSTD_decompress(
      rows.unpacked.data(), rows.unpacked.size(), rows.data.data(), rows.data.size());
  if (ZSTD_isError(num_bytes) != 0U || num_bytes != rows.unpacked.size()) {
    return bad(
        "a zstd picture does not unpack to what its head says (gzip, which old versions of "
        "zstd_image_transport send, is not read)");
  }
  rows.data = rows.unpacked;
  return rows;
}

std::uint16_t mm_of(double depth_m) {
  const double depth_mm = std::round(depth_m * kMmPerM);
  return depth_mm > 0.0 && depth_mm <= 65535.0 ? static_cast<std::uint16_t>(depth_mm) : 0;
}

Result<Image<std::uint16_t>> depth_of(const Rows& rows, PictureSize size) {
  if (!is_depth_encoding(rows.encoding)) {
    return bad(
        fmt::format("a depth picture in '{}', only 16UC1 and 32FC1 are read", rows.encoding));
  }
  const bool is_float = rows.encoding == "32FC1";
  MOR_CHECK(check_rows(rows, is_float ? sizeof(float) : sizeof(std::uint16_t), size));
  Image<std::uint16_t> depth_mm(size.width_px, size.height_px);
  std::vector<float> row_m(is_float ? rows.width_px : 0);
  for (int y = 0; y < size.height_px; ++y) {
    const auto* from = rows.data.data() + static_cast<std::size_t>(y) * rows.row_bytes;
    auto* to = depth_mm.view().row(y);
    if (!is_float) {
      std::memcpy(to, from, rows.width_px * sizeof(std::uint16_t));
      continue;
    }
    std::memcpy(row_m.data(), from, rows.width_px * sizeof(float));
    for (std::size_t x = 0; x < row_m.size(); ++x) to[x] = mm_of(static_cast<double>(row_m[x]));
  }
  return depth_mm;
}

Result<Image<std::uint16_t>> unpack_depth_png(Bytes packed, PictureSize size) {
  MOR_TRY(const auto head, read_png_head(packed));
  MOR_CHECK(check_size(head.width_px, head.height_px, size));
  return decode_png_gray16(packed);
}

Result<Image<std::uint16_t>> unpack_rvl(Bytes packed, PictureSize size) {
  ByteReader in(packed);
  const auto width = in.take<std::uint32_t>(), height = in.take<std::uint32_t>();
  if (!in.ok()) return bad("an RVL picture is cut short");
  MOR_CHECK(check_size(width, height, size));
  Image<std::uint16_t> image(size.width_px, size.height_px);
  MOR_CHECK(decode_rvl(packed.subspan(in.position()), {image.data(), image.size()}));
  return image;
}

/// compressedDepth keeps 32FC1 as a/z + b in 16 bits; z in metres.
void invert(Image<std::uint16_t>& image, float a, float b) {
  for (std::size_t i = 0; i < image.size(); ++i) {
    auto& value = image.data()[i];
    if (value != 0) value = mm_of(static_cast<double>(a) / (value - static_cast<double>(b)));
  }
}

Result<Image<std::uint16_t>> unpack_compressed_depth(const Picture& picture, PictureSize size) {
  ByteReader in(picture.data);
  (void)in.take<std::int32_t>();
  const auto a = in.take<float>(), b = in.take<float>();
  if (!in.ok()) return bad("a compressedDepth picture is cut short");
  static_assert(kDepthHeadBytes == sizeof(std::int32_t) + 2 * sizeof(float));
  const Bytes packed = Bytes(picture.data).subspan(kDepthHeadBytes);
  const bool is_rvl = picture.encoding.find("compressedDepth rvl") != std::string::npos;
  MOR_TRY(auto image, is_rvl ? unpack_rvl(packed, size) : unpack_depth_png(packed, size));
  if (encoding_in(picture) == "32FC1") invert(image, a, b);
  return image;
}

/// Where red, green and blue stand in a pixel.
struct PixelLayout {
  std::string_view encoding;
  std::size_t num_bytes, red, green, blue;
};
constexpr PixelLayout kLayouts[] = {{"rgb8", 3, 0, 1, 2},
                                    {"bgr8", 3, 2, 1, 0},
                                    {"rgba8", 4, 0, 1, 2},
                                    {"bgra8", 4, 2, 1, 0},
                                    {"mono8", 1, 0, 0, 0}};

Result<Image<Rgb8>> color_of(const Rows& rows, PictureSize size) {
  const auto* layout = std::ranges::find(kLayouts, rows.encoding, &PixelLayout::encoding);
  if (layout == std::end(kLayouts)) {
    return bad(
        fmt::format("a colour picture in '{}', only rgb8, bgr8, rgba8, bgra8 and mono8 are read",
                    rows.encoding));
  }
  MOR_CHECK(check_rows(rows, layout->num_bytes, size));
  Image<Rgb8> color(size.width_px, size.height_px);
  for (int y = 0; y < size.height_px; ++y) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(rows.data.data()) +
                       static_cast<std::size_t>(y) * rows.row_bytes;
    auto* to = color.view().row(y);
    for (int x = 0; x < size.width_px; ++x, from += layout->num_bytes) {
      to[x] = {from[layout->red], from[layout->green], from[layout->blue]};
    }
  }
  return color;
}

}  // namespace

bool is_depth(const Picture& picture) {
  if (!picture.is_compressed) return is_depth_encoding(picture.encoding);
  if (is_compressed_depth(picture)) return true;
  if (picture.encoding == "zstd") {
    const auto head = zstd_head(picture.data);
    return head && is_depth_encoding(head->encoding);
  }
  const auto png = read_png_head(picture.data);
  return png && png->is_gray16;
}

Result<Image<std::uint16_t>> decode_depth_picture(const Picture& picture, PictureSize size) {
  if (!picture.is_compressed) return depth_of(plain_rows(picture), size);
  if (is_compressed_depth(picture)) return unpack_compressed_depth(picture, size);
  if (picture.encoding == "zstd") {
    MOR_TRY(const auto rows, unpack_zstd(picture, size));
    return depth_of(rows, size);
  }
  return unpack_depth_png(picture.data, size);
}

Result<Image<Rgb8>> decode_color_picture(const Picture& picture, PictureSize size) {
  if (!picture.is_compressed) return color_of(plain_rows(picture), size);
  if (picture.encoding == "zstd") {
    MOR_TRY(const auto rows, unpack_zstd(picture, size));
    return color_of(rows, size);
  }
  if (const auto png = read_png_head(picture.data)) {
    MOR_CHECK(check_size(png->width_px, png->height_px, size));
    return decode_png_rgb(picture.data);
  }
  MOR_TRY(const auto jpeg, read_jpeg_size(picture.data));
  MOR_CHECK(check_size(
      static_cast<std::uint64_t>(jpeg.width_px), static_cast<std::uint64_t>(jpeg.height_px), size));
  return decode_jpeg(picture.data);
}

}  // namespace mor::internal::push
