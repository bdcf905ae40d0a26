// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/video_encoder.h"

#include <gst/app/gstappsrc.h>
#include <gst/video/video.h>
#include <libyuv/convert.h>

#include "morgagni/core/log.h"
#include "morgagni/stream/internal/gst_parts.h"

namespace mor::internal {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// VP8 codes 14-bit sides; below 16 the encoder has no whole block.
constexpr int kMinSidePx = 16;
constexpr int kMaxSidePx = 4096;
// A viewer who keeps asking must not turn the stream into key pictures for everybody.
constexpr milliseconds kMinKeyPeriod{250};
/// A browser that missed the key picture asks for another one only while it receives something: a
/// standing picture is sent some times more.
constexpr int kMoreRepeats = 4;
constexpr milliseconds kRepeatPeriod{1000};
// One tick of the 90 kHz clock, rounded up: two pictures never share a stamp.
constexpr GstClockTime kTick = 11112;

double elapsed_ms(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

GstCapsHandle caps_of(int width, int height) {
  // The frame rate is unknown by nature: pictures come when they come.
  return GstCapsHandle(gst_caps_new_simple("video/x-raw",
                                           "format",
                                           G_TYPE_STRING,
                                           "I420",
                                           "width",
                                           G_TYPE_INT,
                                           width,
                                           "height",
                                           G_TYPE_INT,
                                           height,
                                           "framerate",
                                           GST_TYPE_FRACTION,
                                           0,
                                           1,
                                           "colorimetry",
                                           G_TYPE_STRING,
                                           "bt601",
                                           nullptr));
}

/// The picture in I420, laid out as GStreamer expects it. Odd sizes included.
std::shared_ptr<GstBuffer> to_i420(ImageView<const Rgba8> picture) {
  GstVideoInfo layout;
  gst_video_info_set_format(&layout,
                            GST_VIDEO_FORMAT_I420,
                            static_cast<guint>(picture.width()),
                            static_cast<guint>(picture.height()));
  std::shared_ptr<GstBuffer> buffer(gst_buffer_new_allocate(nullptr, layout.size, nullptr),
                                    gst_buffer_unref);
  GstMapInfo map;
  gst_buffer_map(buffer.get(), &map, GST_MAP_WRITE);
  const auto plane = [&](int idx) { return map.data + GST_VIDEO_INFO_PLANE_OFFSET(&layout, idx); };
  // libyuv names a format by its 32-bit word: R, G, B, A in memory is its ABGR.
  libyuv::ABGRToI420(reinterpret_cast<const std::uint8_t*>(picture.row(0)),
                     static_cast<int>(picture.stride() * 4),
                     plane(0),
                     GST_VIDEO_INFO_PLANE_STRIDE(&layout, 0),
                     plane(1),
                     GST_VIDEO_INFO_PLANE_STRIDE(&layout, 1),
                     plane(2),
                     GST_VIDEO_INFO_PLANE_STRIDE(&layout, 2),
                     picture.width(),
                     picture.height());
  gst_buffer_unmap(buffer.get(), &map);
  return buffer;
}

}  // namespace

std::uint32_t rtp_stamp_of(GstClockTime running_time) {
  return static_cast<std::uint32_t>(gst_util_uint64_scale_int(running_time, 90000, GST_SECOND));
}

Result<std::unique_ptr<VideoEncoder>> VideoEncoder::create(int bitrate_kbps, Sink sink) {
  std::unique_ptr<VideoEncoder> encoder(new VideoEncoder);
  encoder->sink_ = std::move(sink);
  MOR_CHECK(encoder->build(bitrate_kbps));
  return encoder;
}

Result<void> VideoEncoder::build(int bitrate_kbps) {
  pipeline_.reset(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new("encoder"))));
  MOR_TRY(GstElement* const source, add_part(GST_BIN(pipeline_.get()), "appsrc"));
  MOR_TRY(GstElement* const encoder, add_part(GST_BIN(pipeline_.get()), "vp8enc"));
  MOR_TRY(GstElement* const sink, add_part(GST_BIN(pipeline_.get()), "fakesink"));
  source_.reset(GST_ELEMENT(gst_object_ref(source)));
  encoder_.reset(GST_ELEMENT(gst_object_ref(encoder)));
  g_object_set(source, "is-live", TRUE, "format", GST_FORMAT_TIME, nullptr);
  // One thread: with two, the workers of libvpx spin against everything else on a small machine.
  // Key pictures are asked for by those who need one, so the regular ones may be rare.
  g_object_set(encoder,
               "threads",
               1,
               "deadline",
               G_GINT64_CONSTANT(1),
               "cpu-used",
               -8,
               "lag-in-frames",
               0,
               "keyframe-max-dist",
               300,
               "target-bitrate",
               bitrate_kbps * 1000,
               nullptr);
  gst_util_set_object_arg(G_OBJECT(encoder), "end-usage", "cbr");
  gst_util_set_object_arg(G_OBJECT(encoder), "error-resilient", "default");
  g_object_set(sink, "sync", FALSE, "async", FALSE, nullptr);
  gst_element_link_many(source, encoder, sink, nullptr);

  GstAppSrcCallbacks callbacks{};
  callbacks.need_data = [](GstAppSrc*, guint, gpointer self) {
    static_cast<VideoEncoder*>(self)->feed();
  };
  gst_app_src_set_callbacks(GST_APP_SRC(source), &callbacks, this, nullptr);
  const GstHandle<GstPad> output(gst_element_get_static_pad(encoder, "src"));
  gst_pad_add_probe(
      output.get(),
      GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer self) {
        static_cast<VideoEncoder*>(self)->on_encoded(GST_PAD_PROBE_INFO_BUFFER(info));
        return GST_PAD_PROBE_OK;
      },
      this,
      nullptr);
  if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE) {
    return make_error(ErrorCode::kDevice, "the video encoder vp8enc does not start");
  }
  return {};
}

VideoEncoder::~VideoEncoder() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (pipeline_) gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
}

void VideoEncoder::show(ImageView<const Rgba8> picture, const PictureInfo& info) {
  if (picture.width() < kMinSidePx || picture.height() < kMinSidePx ||
      picture.width() > kMaxSidePx || picture.height() > kMaxSidePx) {
    log::warn("a picture of {}x{} is not shown: its sides must be {} to {} pixels",
              picture.width(),
              picture.height(),
              kMinSidePx,
              kMaxSidePx);
    return;
  }
  Picture next{to_i420(picture), picture.width(), picture.height(), info, false};
  {
    const std::lock_guard lock(mutex_);
    if (waiting_) ++num_dropped_;
    waiting_ = std::move(next);
  }
  changed_.notify_one();
}

void VideoEncoder::request_key_picture() {
  {
    const std::lock_guard lock(mutex_);
    key_wanted_ = true;
    repeats_left_ = kMoreRepeats;
  }
  changed_.notify_one();
}

std::optional<VideoEncoder::Picture> VideoEncoder::take() {
  std::unique_lock lock(mutex_);
  // A running camera answers a wish for a key picture by its next one; a standing one by a repeat.
  const auto has_work = [this] { return waiting_ || stopping_; };
  const auto wants_repeat = [this] {
    return current_.pixels && (key_wanted_ || repeats_left_ > 0);
  };
  while (!has_work()) {
    const bool wants_key = key_wanted_;
    const auto is_overtaken = [&] { return has_work() || wants_key != key_wanted_; };
    if (!wants_repeat()) {
      changed_.wait(lock, [&] { return has_work() || wants_repeat(); });
    } else if (!changed_.wait_for(lock, wants_key ? kMinKeyPeriod : kRepeatPeriod, is_overtaken)) {
      if (!wants_key) --repeats_left_;
      Picture repeat = current_;
      repeat.is_repeat = true;
      return repeat;
    }
  }
  if (stopping_) return std::nullopt;
  return std::exchange(waiting_, std::nullopt);
}

void VideoEncoder::feed() {
  auto next = take();
  if (!next) return;
  current_ = *std::move(next);
  const std::pair size{current_.width, current_.height};
  if (size != size_) {
    gst_app_src_set_caps(GST_APP_SRC(source_.get()), caps_of(size.first, size.second).get());
    size_ = size;
  }
  force_key_if_wanted();
  // A buffer of its own over the same pixels: the stamp differs when a picture is repeated.
  GstBuffer* buffer = gst_buffer_copy(current_.pixels.get());
  GST_BUFFER_PTS(buffer) = next_stamp();
  fed_at_ = Clock::now();
  gst_app_src_push_buffer(GST_APP_SRC(source_.get()), buffer);
}

void VideoEncoder::force_key_if_wanted() {
  const auto now = Clock::now();
  if (now - last_key_at_ < kMinKeyPeriod) return;
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(key_wanted_, false)) return;
  }
  last_key_at_ = now;
  const GstHandle<GstPad> output(gst_element_get_static_pad(encoder_.get(), "src"));
  gst_pad_send_event(output.get(),
                     gst_video_event_new_upstream_force_key_unit(GST_CLOCK_TIME_NONE, TRUE, 0));
}

GstClockTime VideoEncoder::next_stamp() {
  const GstHandle<GstClock> clock(gst_element_get_clock(pipeline_.get()));
  const GstClockTime now =
      clock ? gst_clock_get_time(clock.get()) - gst_element_get_base_time(pipeline_.get()) : 0;
  last_stamp_ = std::max(now, last_stamp_ + kTick);
  return last_stamp_;
}

void VideoEncoder::on_encoded(GstBuffer* buffer) {
  const auto now = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    ++num_encoded_;
    encode_ms_.add(elapsed_ms(fed_at_, now));
    if (!current_.is_repeat) capture_to_encoded_ms_.add(elapsed_ms(current_.info.captured_at, now));
  }
  sink_({.buffer = buffer,
         .rtp_stamp = rtp_stamp_of(GST_BUFFER_PTS(buffer)),
         .is_key = !GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT),
         .captured_at = current_.info.captured_at,
         .info_json = current_.info.json});
}

void VideoEncoder::add_to(LiveServerStats& stats) const {
  const std::lock_guard lock(mutex_);
  stats.num_encoded = num_encoded_;
  stats.num_dropped = num_dropped_;
  stats.encode_ms = encode_ms_.median();
  stats.capture_to_encoded_ms = capture_to_encoded_ms_.median();
  stats.capture_to_encoded_p95_ms = capture_to_encoded_ms_.p95();
}

}  // namespace mor::internal
