// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/image_png.h"

#include <csetjmp>
#include <cstring>
#include <span>
#include <string>

#include <png.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

constexpr std::uintmax_t kMaxPngBytes = 1U << 30U;

struct Reader {
  std::span<const std::byte> rest;
  std::string error;
};

void read_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (reader->rest.size() < count) png_error(png, "the file ends too early");
  std::memcpy(out, reader->rest.data(), count);
  reader->rest = reader->rest.subspan(count);
}

void write_bytes(png_structp png, png_bytep data, png_size_t count) {
  auto* out = static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  out->insert(out->end(), bytes, bytes + count);
}

void on_error(png_structp png, png_const_charp message) {
  static_cast<Reader*>(png_get_error_ptr(png))->error = message;
  longjmp(png_jmpbuf(png), 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}

enum class Layout : std::uint8_t { kRgb8, kGray16 };

/// Decodes into `image`. libpng reports errors by longjmp back into this function: what owns memory
/// belongs to the caller, for a local that changed after setjmp may be lost.
template <class T>
Result<void> decode_into(Reader& reader,
                         Layout layout,
                         Image<T>& image,
                         std::vector<png_bytep>& rows) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_error, on_warning);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return make_error(ErrorCode::kIo, "not a readable PNG: " + reader.error);
  }
  png_set_user_limits(png, kMaxPngSidePx, kMaxPngSidePx);
  png_set_read_fn(png, &reader, read_bytes);
  png_read_info(png, info);
  const int depth = png_get_bit_depth(png, info);
  const int color = png_get_color_type(png, info);
  if (layout == Layout::kGray16) {
    if (depth != 16 || color != PNG_COLOR_TYPE_GRAY) {
      png_error(png, "expected 16-bit grey (depth in millimetres)");
    }
    png_set_swap(png);
  } else {
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_strip_alpha(png);
    png_set_gray_to_rgb(png);
  }
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  image = Image<T>(static_cast<int>(png_get_image_width(png, info)),
                   static_cast<int>(png_get_image_height(png, info)));
  for (int y = 0; y < image.height(); ++y) {
    rows.push_back(reinterpret_cast<png_bytep>(image.view().row(y)));
  }
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return {};
}

template <class T>
Result<Image<T>> decode_png(std::span<const std::byte> bytes, Layout layout) {
  Reader reader{bytes, {}};
  Image<T> image;
  std::vector<png_bytep> rows;
  MOR_CHECK(decode_into(reader, layout, image, rows));
  return image;
}

template <class T>
Result<Image<T>> read_png(const std::filesystem::path& path, Layout layout) {
  MOR_TRY(const auto bytes, read_file(path, kMaxPngBytes));
  auto image = decode_png<T>(bytes, layout);
  if (!image) {
    return make_error(image.error().code,
                      fmt::format("{}: {}", path.string(), image.error().message));
  }
  return image;
}

template <class T>
std::vector<std::byte> write_png(ImageView<const T> image, int bit_depth, int color_type) {
  std::vector<std::byte> out;
  Reader errors;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &errors, on_error, on_warning);
  png_infop info = png_create_info_struct(png);
  if (setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return {};
  }
  png_set_write_fn(png, &out, write_bytes, nullptr);
  png_set_compression_level(png, 1);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(image.width()),
               static_cast<png_uint_32>(image.height()),
               bit_depth,
               color_type,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (bit_depth == 16) png_set_swap(png);
  for (int y = 0; y < image.height(); ++y) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(image.row(y)));
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

}  // namespace

Result<Image<Rgb8>> read_png_rgb(const std::filesystem::path& path) {
  return read_png<Rgb8>(path, Layout::kRgb8);
}

Result<Image<std::uint16_t>> read_png_gray16(const std::filesystem::path& path) {
  return read_png<std::uint16_t>(path, Layout::kGray16);
}

Result<Image<Rgb8>> decode_png_rgb(std::span<const std::byte> bytes) {
  return decode_png<Rgb8>(bytes, Layout::kRgb8);
}

Result<Image<std::uint16_t>> decode_png_gray16(std::span<const std::byte> bytes) {
  return decode_png<std::uint16_t>(bytes, Layout::kGray16);
}

Result<PngHead> read_png_head(std::span<const std::byte> bytes) {
  // The signature, then the chunk IHDR: length, name, width, height, bit depth, colour type.
  constexpr std::size_t kName = 12, kWidth = 16, kHeight = 20, kDepth = 24, kColor = 25, kEnd = 26;
  const auto* data = reinterpret_cast<png_const_bytep>(bytes.data());
  if (bytes.size() < kEnd || png_sig_cmp(data, 0, 8) != 0 ||
      std::memcmp(data + kName, "IHDR", 4) != 0) {
    return make_error(ErrorCode::kIo, "not a PNG");
  }
  return PngHead{png_get_uint_32(data + kWidth),
                 png_get_uint_32(data + kHeight),
                 data[kDepth] == 16 && data[kColor] == PNG_COLOR_TYPE_GRAY};
}

std::vector<std::byte> encode_png(ImageView<const Rgb8> image) {
  return write_png(image, 8, PNG_COLOR_TYPE_RGB);
}

std::vector<std::byte> encode_png(ImageView<const Rgba8> image) {
  return write_png(image, 8, PNG_COLOR_TYPE_RGB_ALPHA);
}

std::vector<std::byte> encode_png(ImageView<const std::uint16_t> image) {
  return write_png(image, 16, PNG_COLOR_TYPE_GRAY);
}

}  // namespace mor
