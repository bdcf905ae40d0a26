// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/image_jpeg.h"

#include <memory>

#include <spdlog/fmt/fmt.h>
#include <turbojpeg.h>

namespace mor {
namespace {

struct Destroy {
  void operator()(tjhandle codec) const { tjDestroy(codec); }
};
using Codec = std::unique_ptr<void, Destroy>;

static_assert(sizeof(Rgb8) == 3, "TJPF_RGB reads three bytes a pixel");

tl::unexpected<Error> unreadable(const Codec& codec) {
  return make_error(ErrorCode::kIo,
                    fmt::format("not a readable JPEG: {}", tjGetErrorStr2(codec.get())));
}

Result<JpegSize> read_size(const Codec& codec, std::span<const std::byte> bytes) {
  JpegSize size;
  int sampling = 0, color_space = 0;
  if (tjDecompressHeader3(codec.get(),
                          reinterpret_cast<const unsigned char*>(bytes.data()),
                          bytes.size(),
                          &size.width_px,
                          &size.height_px,
                          &sampling,
                          &color_space) != 0) {
    return unreadable(codec);
  }
  return size;
}

}  // namespace

Result<std::vector<std::byte>> encode_jpeg(ImageView<const Rgb8> image, int quality) {
  if (image.empty()) return make_error(ErrorCode::kInvalidArgument, "the picture is empty");
  if (quality < 1 || quality > 100) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("JPEG quality must be in [1, 100], got {}", quality));
  }
  const Codec codec(tjInitCompress());
  auto size = tjBufSize(image.width(), image.height(), TJSAMP_420);
  std::vector<std::byte> bytes(size);
  auto* out = reinterpret_cast<unsigned char*>(bytes.data());
  const int status = tjCompress2(codec.get(),
                                 reinterpret_cast<const unsigned char*>(image.row(0)),
                                 image.width(),
                                 static_cast<int>(image.stride()) * 3,
                                 image.height(),
                                 TJPF_RGB,
                                 &out,
                                 &size,
                                 TJSAMP_420,
                                 quality,
                                 TJFLAG_NOREALLOC);
  if (status != 0) {
    return make_error(ErrorCode::kInternal,
                      fmt::format("the picture cannot be packed: {}", tjGetErrorStr2(codec.get())));
  }
  bytes.resize(size);
  return bytes;
}

Result<JpegSize> read_jpeg_size(std::span<const std::byte> bytes) {
  return read_size(Codec(tjInitDecompress()), bytes);
}

Result<Image<Rgb8>> decode_jpeg(std::span<const std::byte> bytes) {
  const Codec codec(tjInitDecompress());
  MOR_TRY(const auto size, read_size(codec, bytes));
  const auto [width, height] = size;
  if (width > kMaxJpegSidePx || height > kMaxJpegSidePx) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("a JPEG of {}x{} is larger than {} px a side", width, height, kMaxJpegSidePx));
  }
  Image<Rgb8> image(width, height);
  if (tjDecompress2(codec.get(),
                    reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(),
                    reinterpret_cast<unsigned char*>(image.data()),
                    width,
                    0,
                    height,
                    TJPF_RGB,
                    TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0) {
    return unreadable(codec);
  }
  return image;
}

}  // namespace mor
