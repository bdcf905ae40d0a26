// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/matroska_recorder.h"

#include <algorithm>
#include <cstring>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/recordable_frame.h"
#include "morgagni/core/image_jpeg.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

namespace mor {
namespace {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;

constexpr AVRational kMilliseconds{1, 1000};
constexpr int kSlices = 4;
constexpr std::int64_t kLastFrameMs = 33;

tl::unexpected<Error> invalid(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, std::move(message));
}

struct CloseFormat {
  void operator()(AVFormatContext* format) const {
    if (format->pb != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }
};
using FormatHandle = std::unique_ptr<AVFormatContext, CloseFormat>;

struct FreeCodec {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
};
using CodecHandle = std::unique_ptr<AVCodecContext, FreeCodec>;

struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
using FrameHandle = std::unique_ptr<AVFrame, FreeFrame>;

struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
using PacketHandle = std::unique_ptr<AVPacket, FreePacket>;

Result<void> checked(int status, const fs::path& path, const char* what) {
  if (status >= 0) return {};
  char reason[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(status, reason, sizeof(reason));
  return make_error(ErrorCode::kIo, fmt::format("{}: {}: {}", path.string(), what, reason));
}

/// Encodes pictures without loss, each by itself.
Result<CodecHandle> make_ffv1(const PinholeCamera& camera,
                              AVPixelFormat pixels,
                              const fs::path& path) {
  const auto* coder = avcodec_find_encoder(AV_CODEC_ID_FFV1);
  if (coder == nullptr) {
    return make_error(ErrorCode::kUnsupported, "this libavcodec has no FFV1 encoder");
  }
  CodecHandle codec(avcodec_alloc_context3(coder));
  codec->width = camera.width_px;
  codec->height = camera.height_px;
  codec->pix_fmt = pixels;
  codec->time_base = kMilliseconds;
  codec->level = 3;
  codec->slices = kSlices;
  codec->gop_size = 1;
  codec->thread_count = 1;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  (void)av_opt_set_int(codec->priv_data, "slicecrc", 1, 0);
  (void)av_opt_set_int(codec->priv_data, "coder", 1, 0);  // The range coder: 16 bits need it.
  MOR_CHECK(checked(avcodec_open2(codec.get(), coder, nullptr), path, "FFV1"));
  return codec;
}

void copy_rows(const Image<std::uint16_t>& depth_mm, AVFrame& frame) {
  for (int y = 0; y < depth_mm.height(); ++y) {
    std::memcpy(frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0],
                depth_mm.view().row(y),
                static_cast<std::size_t>(depth_mm.width()) * sizeof(std::uint16_t));
  }
}

/// 0RGB as the machine's 32-bit words: blue first in memory.
void copy_rows(const Image<Rgb8>& color, AVFrame& frame) {
  for (int y = 0; y < color.height(); ++y) {
    auto* to = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    for (int x = 0; x < color.width(); ++x, to += 4) {
      const auto& pixel = color(x, y);
      to[0] = pixel.b;
      to[1] = pixel.g;
      to[2] = pixel.r;
      to[3] = 0;
    }
  }
}

}  // namespace

struct MatroskaRecorder::Impl {
  Impl(fs::path target, ColorCoding coding, int quality)
      : path(std::move(target)),
        aside(path.string() + fmt::format(".part-{}", getpid())),
        color_coding(coding),
        jpeg_quality(quality) {}
  ~Impl() {
    format.reset();
    std::error_code status;
    if (!is_finished) fs::remove(aside, status);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] Result<void> begin(const RgbdFrame& frame);
  [[nodiscard]] Result<void> add_stream(AVStream*& stream, const char* title);
  [[nodiscard]] Result<void> attach_calibration();
  template <class T>
  [[nodiscard]] Result<void> encode(AVCodecContext& codec,
                                    const AVStream& to,
                                    const Image<T>& image);
  [[nodiscard]] Result<void> write_bytes(const AVStream& to, std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(AVPacket& packet, const AVStream& to);

  fs::path path, aside;
  ColorCoding color_coding;
  int jpeg_quality;
  bool is_finished = false;
  FormatHandle format;
  CodecHandle depth_codec, color_codec;
  AVStream* depth_stream = nullptr;
  AVStream* color_stream = nullptr;
  AVStream* times_stream = nullptr;
  std::shared_ptr<const RgbdCalibration> calibration;
  std::chrono::steady_clock::time_point first_captured_at, last_captured_at;
  std::int64_t now_ms = 0;
  std::uint64_t num_frames = 0;
};

MatroskaRecorder::MatroskaRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MatroskaRecorder::MatroskaRecorder(MatroskaRecorder&&) noexcept = default;
MatroskaRecorder& MatroskaRecorder::operator=(MatroskaRecorder&&) noexcept = default;
MatroskaRecorder::~MatroskaRecorder() = default;

Result<MatroskaRecorder> MatroskaRecorder::create(const fs::path& path,
                                                  ColorCoding color,
                                                  int jpeg_quality) {
  if (jpeg_quality < 1 || jpeg_quality > 100) {
    return invalid(fmt::format("jpeg_quality must be in [1, 100], got {}", jpeg_quality));
  }
  if (fs::exists(path)) return invalid(fmt::format("{}: exists already", path.string()));
  auto impl = std::make_unique<Impl>(path, color, jpeg_quality);
  AVFormatContext* format = nullptr;
  MOR_CHECK(checked(
      avformat_alloc_output_context2(&format, nullptr, "matroska", nullptr), path, "Matroska"));
  impl->format.reset(format);
  MOR_CHECK(checked(
      avio_open(&format->pb, impl->aside.c_str(), AVIO_FLAG_WRITE), path, "cannot be written"));
  return MatroskaRecorder(std::move(impl));
}

Result<void> MatroskaRecorder::Impl::add_stream(AVStream*& stream, const char* title) {
  stream = avformat_new_stream(format.get(), nullptr);
  if (stream == nullptr) return checked(AVERROR(ENOMEM), path, "a track");
  stream->time_base = kMilliseconds;
  av_dict_set(&stream->metadata, "title", title, 0);
  return {};
}

Result<void> MatroskaRecorder::Impl::attach_calibration() {
  const auto json = calibration_to_json(*calibration);
  AVStream* stream = nullptr;
  MOR_CHECK(add_stream(stream, "Calibration"));
  auto& parameters = *stream->codecpar;
  parameters.codec_type = AVMEDIA_TYPE_ATTACHMENT;
  parameters.codec_id = AV_CODEC_ID_BIN_DATA;
  parameters.extradata =
      static_cast<std::uint8_t*>(av_mallocz(json.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  std::memcpy(parameters.extradata, json.data(), json.size());
  parameters.extradata_size = static_cast<int>(json.size());
  av_dict_set(&stream->metadata, "filename", "calibration.json", 0);
  av_dict_set(&stream->metadata, "mimetype", "application/json", 0);
  return {};
}

Result<void> MatroskaRecorder::Impl::begin(const RgbdFrame& frame) {
  calibration = frame.calibration;
  first_captured_at = frame.captured_at;
  MOR_CHECK(add_stream(depth_stream, "Depth in millimetres, 0 = no reading"));
  MOR_TRY(depth_codec, make_ffv1(calibration->depth, AV_PIX_FMT_GRAY16LE, path));
  avcodec_parameters_from_context(depth_stream->codecpar, depth_codec.get());
  MOR_CHECK(add_stream(color_stream, "Colour"));
  if (color_coding == ColorCoding::kLossless) {
    MOR_TRY(color_codec, make_ffv1(calibration->color, AV_PIX_FMT_0RGB32, path));
    avcodec_parameters_from_context(color_stream->codecpar, color_codec.get());
  } else {
    color_stream->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
    color_stream->codecpar->codec_id = AV_CODEC_ID_MJPEG;
    color_stream->codecpar->width = calibration->color.width_px;
    color_stream->codecpar->height = calibration->color.height_px;
  }
  MOR_CHECK(add_stream(times_stream, "Times in nanoseconds"));
  times_stream->codecpar->codec_type = AVMEDIA_TYPE_SUBTITLE;
  times_stream->codecpar->codec_id = AV_CODEC_ID_TEXT;
  MOR_CHECK(attach_calibration());
  return checked(avformat_write_header(format.get(), nullptr), path, "the head");
}

Result<void> MatroskaRecorder::Impl::write(AVPacket& packet, const AVStream& to) {
  packet.stream_index = to.index;
  packet.pts = packet.dts = now_ms;
  packet.flags |= AV_PKT_FLAG_KEY;
  av_packet_rescale_ts(&packet, kMilliseconds, to.time_base);
  return checked(av_interleaved_write_frame(format.get(), &packet), path, "a frame");
}

Result<void> MatroskaRecorder::Impl::write_bytes(const AVStream& to,
                                                 std::span<const std::byte> bytes) {
  const PacketHandle packet(av_packet_alloc());
  MOR_CHECK(checked(av_new_packet(packet.get(), static_cast<int>(bytes.size())), path, "a frame"));
  std::memcpy(packet->data, bytes.data(), bytes.size());
  packet->duration = kLastFrameMs;
  return write(*packet, to);
}

template <class T>
Result<void> MatroskaRecorder::Impl::encode(AVCodecContext& codec,
                                            const AVStream& to,
                                            const Image<T>& image) {
  const FrameHandle frame(av_frame_alloc());
  frame->format = codec.pix_fmt;
  frame->width = codec.width;
  frame->height = codec.height;
  frame->pts = now_ms;
  MOR_CHECK(checked(av_frame_get_buffer(frame.get(), 0), path, "a frame"));
  copy_rows(image, *frame);
  MOR_CHECK(checked(avcodec_send_frame(&codec, frame.get()), path, "FFV1"));
  const PacketHandle packet(av_packet_alloc());
  MOR_CHECK(checked(avcodec_receive_packet(&codec, packet.get()), path, "FFV1"));
  return write(*packet, to);
}

Result<void> MatroskaRecorder::add(const RgbdFrame& frame) {
  auto& impl = *impl_;
  if (impl.is_finished) return invalid("the recording is finished");
  MOR_CHECK(internal::check_recordable(frame, impl.calibration.get(), impl.last_captured_at));
  if (!impl.calibration) MOR_CHECK(impl.begin(frame));
  const nanoseconds since_first = frame.captured_at - impl.first_captured_at;
  const auto rounded_ms = std::chrono::round<std::chrono::milliseconds>(since_first).count();
  impl.now_ms = impl.num_frames == 0 ? 0 : std::max(impl.now_ms + 1, rounded_ms);
  MOR_CHECK(impl.encode(*impl.depth_codec, *impl.depth_stream, frame.depth_mm));
  if (impl.color_codec) {
    MOR_CHECK(impl.encode(*impl.color_codec, *impl.color_stream, frame.color));
  } else {
    MOR_TRY(const auto jpeg, encode_jpeg(frame.color.view(), impl.jpeg_quality));
    MOR_CHECK(impl.write_bytes(*impl.color_stream, jpeg));
  }
  nlohmann::ordered_json times = {{"frame", impl.num_frames}, {"time_ns", since_first.count()}};
  if (frame.device_time) times["device_ns"] = frame.device_time->count();
  const auto text = times.dump();
  MOR_CHECK(impl.write_bytes(*impl.times_stream, std::as_bytes(std::span(text))));
  impl.last_captured_at = frame.captured_at;
  ++impl.num_frames;
  return {};
}

Result<void> MatroskaRecorder::finish() {
  auto& impl = *impl_;
  if (impl.is_finished || impl.num_frames == 0) {
    return invalid(fmt::format("{}: no frames to finish", impl.path.string()));
  }
  MOR_CHECK(checked(av_write_trailer(impl.format.get()), impl.path, "the end"));
  MOR_CHECK(checked(avio_closep(&impl.format->pb), impl.path, "the end"));
  std::error_code status;
  fs::rename(impl.aside, impl.path, status);
  if (status) {
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", impl.path.string(), status.message()));
  }
  impl.is_finished = true;
  return {};
}

}  // namespace mor
