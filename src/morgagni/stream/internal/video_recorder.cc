// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/video_recorder.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <gst/app/gstappsrc.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/core/log.h"
#include "morgagni/stream/internal/gst_parts.h"

namespace mor::internal {
namespace {

/// So much may wait for a disk that stalls.
constexpr std::size_t kMaxWaitingBytes = 64U << 20U;
constexpr guint64 kMaxQueuedPictures = 2;
constexpr GstClockTime kEndLimit = 30 * GST_SECOND;

std::string utc_of(std::chrono::steady_clock::time_point time) {
  const auto now = std::chrono::system_clock::now();
  const auto then = std::chrono::time_point_cast<std::chrono::milliseconds>(
      now - std::chrono::duration_cast<std::chrono::system_clock::duration>(
                std::chrono::steady_clock::now() - time));
  const auto whole = std::chrono::floor<std::chrono::seconds>(then);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(whole)),
                     (then - whole).count());
}

std::string line_of(std::uint64_t number, double time_s, const EncodedPicture& picture) {
  std::string line = fmt::format(R"({{"picture":{},"time_s":{:.6f},"captured_at":"{}")",
                                 number,
                                 time_s,
                                 utc_of(picture.captured_at));
  const std::string& own = picture.info_json;
  const auto first = own.find('{');
  const auto last = own.rfind('}');
  if (first != std::string::npos && last > first + 1)
    line.append(",").append(own, first + 1, last - first - 1);
  return line.append("}\n");
}

std::string sentence_of(GstMessage* message) {
  GError* raw = nullptr;
  gst_message_parse_error(message, &raw, nullptr);
  const GErrorHandle error(raw);
  if (error && g_error_matches(error.get(), GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NO_SPACE_LEFT))
    return "the disk is full: the video ends here";
  return fmt::format("the video cannot be written any further: {}",
                     error ? error->message : "no reason");
}

}  // namespace

std::pair<int, int> vp8_size(GstBuffer* buffer) {
  std::array<guint8, 10> head{};
  if (gst_buffer_extract(buffer, 0, head.data(), head.size()) != head.size()) return {0, 0};
  const bool is_key = (head[0] & 1U) == 0 && head[3] == 0x9D && head[4] == 0x01 && head[5] == 0x2A;
  if (!is_key) return {0, 0};
  return {(head[6] | (head[7] << 8)) & 0x3FFF, (head[8] | (head[9] << 8)) & 0x3FFF};
}

Result<std::unique_ptr<VideoRecorder>> VideoRecorder::create(const VideoFiles& files) {
  if (auto sentence = missing_part("webmmux", "gstreamer1.0-plugins-good"); !sentence.empty())
    return make_error(ErrorCode::kDevice, std::move(sentence));
  std::unique_ptr<VideoRecorder> recorder(new VideoRecorder(files));
  const auto make = [](const std::filesystem::path& path) {
    return open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC | O_APPEND, 0644);
  };
  recorder->lines_fd_ = make(files.pictures);
  const int video_fd = recorder->lines_fd_ < 0 ? -1 : make(files.video);
  if (video_fd < 0) {
    const auto& path = recorder->lines_fd_ < 0 ? files.pictures : files.video;
    const std::string why = std::strerror(errno);
    if (recorder->lines_fd_ >= 0) unlink(files.pictures.c_str());
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: the video cannot be made: {}", path.string(), why));
  }
  close(video_fd);
  auto* const self = recorder.get();
  recorder->thread_ = std::jthread([self](std::stop_token stop) { self->write(stop); });
  return recorder;
}

VideoRecorder::~VideoRecorder() {
  finish();
  if (lines_fd_ >= 0) close(lines_fd_);
}

void VideoRecorder::add(const EncodedPicture& picture) {
  const auto [width, height] = picture.is_key ? vp8_size(picture.buffer) : std::pair(0, 0);
  std::unique_lock lock(mutex_);
  if (!status_.is_running) return;
  if (first_stamp_ == GST_CLOCK_TIME_NONE) {
    if (width == 0) return;
    first_stamp_ = GST_BUFFER_PTS(picture.buffer);
    status_.width_px = width;
    status_.height_px = height;
  }
  const bool is_other = width != 0 && (width != status_.width_px || height != status_.height_px);
  if (is_other || waiting_bytes_ > kMaxWaitingBytes) {
    status_.is_running = false;
    status_.problem = is_other ? "the picture's size has changed: the video ends here"
                               : "the disk is too slow: the video ends here";
    return;
  }
  const GstClockTime stamp = GST_BUFFER_PTS(picture.buffer) - first_stamp_;
  const double time_s = static_cast<double>(stamp) / GST_SECOND;
  GstBufferHandle buffer(gst_buffer_copy(picture.buffer));
  GST_BUFFER_PTS(buffer.get()) = stamp;
  GST_BUFFER_DTS(buffer.get()) = GST_CLOCK_TIME_NONE;
  GST_BUFFER_DURATION(buffer.get()) = GST_CLOCK_TIME_NONE;
  const std::size_t num_bytes = gst_buffer_get_size(buffer.get());
  status_.num_bytes += num_bytes;
  status_.seconds = time_s;
  waiting_bytes_ += num_bytes;
  waiting_.push_back({std::move(buffer), line_of(status_.num_pictures++, time_s, picture), time_s});
  lock.unlock();
  changed_.notify_one();
}

void VideoRecorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    status_.is_running = false;
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

VideoStatus VideoRecorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void VideoRecorder::write(std::stop_token stop) {
  bool is_good = true;
  for (;;) {
    Entry entry;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [this] { return !waiting_.empty(); });
      if (waiting_.empty()) break;  // All is written, and no more comes.
      entry = std::move(waiting_.front());
      waiting_.pop_front();
      waiting_bytes_ -= gst_buffer_get_size(entry.buffer.get());
    }
    is_good = is_good && write_entry(entry);
  }
  close_video();
}

bool VideoRecorder::write_entry(Entry& entry) {
  if ((!pipeline_ && !open_video()) || !wait_for_room()) return false;
  if (gst_app_src_push_buffer(GST_APP_SRC(source_.get()), entry.buffer.release()) != GST_FLOW_OK) {
    if (!has_failed()) fail("the video cannot be written any further");
    return false;
  }
  const auto count = ::write(lines_fd_, entry.line.data(), entry.line.size());
  if (count == static_cast<ssize_t>(entry.line.size())) return true;
  fail(count < 0 && errno != ENOSPC
           ? fmt::format("the video's poses cannot be written: {}", std::strerror(errno))
           : "the disk is full: the video ends here");
  return false;
}

bool VideoRecorder::open_video() {
  const VideoStatus now = status();
  pipeline_.reset(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new("recorder"))));
  const auto source = add_part(GST_BIN(pipeline_.get()), "appsrc");
  const auto muxer = add_part(GST_BIN(pipeline_.get()), "webmmux");
  const auto sink = add_part(GST_BIN(pipeline_.get()), "filesink");
  if (!source || !muxer || !sink) {
    fail("GStreamer cannot make the video");
    return false;
  }
  source_.reset(GST_ELEMENT(gst_object_ref(*source)));
  const GstCapsHandle caps(gst_caps_new_simple("video/x-vp8",
                                               "width",
                                               G_TYPE_INT,
                                               now.width_px,
                                               "height",
                                               G_TYPE_INT,
                                               now.height_px,
                                               "framerate",
                                               GST_TYPE_FRACTION,
                                               0,  // Pictures come when they come.
                                               1,
                                               nullptr));
  g_object_set(*source, "format", GST_FORMAT_TIME, "caps", caps.get(), nullptr);
  g_object_set(*muxer, "writing-app", "Morgagni", nullptr);
  g_object_set(*sink, "location", files_.video.c_str(), "sync", FALSE, "async", FALSE, nullptr);
  gst_util_set_object_arg(G_OBJECT(*sink), "buffer-mode", "unbuffered");
  gst_element_link_many(*source, *muxer, *sink, nullptr);
  if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE)
    return true;
  if (!has_failed()) fail("the video cannot be made");
  return false;
}

bool VideoRecorder::wait_for_room() {
  constexpr GstClockTime kLook = 5 * GST_MSECOND;
  const GstHandle<GstBus> bus(gst_element_get_bus(pipeline_.get()));
  while (gst_app_src_get_current_level_buffers(GST_APP_SRC(source_.get())) >= kMaxQueuedPictures) {
    if (GstMessage* message = gst_bus_timed_pop_filtered(bus.get(), kLook, GST_MESSAGE_ERROR)) {
      fail(sentence_of(message));
      gst_message_unref(message);
      return false;
    }
  }
  return !has_failed();
}

bool VideoRecorder::has_failed() {
  const GstHandle<GstBus> bus(gst_element_get_bus(pipeline_.get()));
  if (GstMessage* message = gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR)) {
    fail(sentence_of(message));
    gst_message_unref(message);
  }
  return is_broken_;
}

void VideoRecorder::close_video() {
  if (!pipeline_) return;
  const GstHandle<GstBus> bus(gst_element_get_bus(pipeline_.get()));
  gst_app_src_end_of_stream(GST_APP_SRC(source_.get()));
  if (!is_broken_) {
    GstMessage* const message = gst_bus_timed_pop_filtered(
        bus.get(), kEndLimit, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
    if (message == nullptr) {
      fail("the video could not be ended in time");
    } else if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
      fail(sentence_of(message));
    }
    if (message != nullptr) gst_message_unref(message);
  }
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  fsync(lines_fd_);
}

void VideoRecorder::fail(std::string sentence) {
  log::warn("{}", sentence);
  is_broken_ = true;
  const std::lock_guard lock(mutex_);
  status_.is_running = false;
  if (status_.problem.empty()) status_.problem = std::move(sentence);
}

}  // namespace mor::internal

namespace mor {

Result<std::uint64_t> repair_video(const std::filesystem::path& from,
                                   const std::filesystem::path& to) {
  using namespace internal;
  MOR_CHECK(check_gstreamer());
  GError* raw = nullptr;
  const GstHandle<GstElement> pipeline(
      gst_parse_launch("filesrc name=in ! matroskademux ! webmmux name=mux writing-app=Morgagni ! "
                       "filesink name=out sync=false async=false",
                       &raw));
  const GErrorHandle error(raw);
  const auto failed = [&](const std::string& why) {
    std::error_code status;
    std::filesystem::remove(to, status);
    return make_error(ErrorCode::kIo,
                      fmt::format("{}: the video cannot be repaired: {}", from.string(), why));
  };
  if (!pipeline || error) return failed(error ? error->message : "GStreamer cannot");
  const auto part = [&](const char* name) {
    return GstHandle<GstElement>(gst_bin_get_by_name(GST_BIN(pipeline.get()), name));
  };
  g_object_set(part("in").get(), "location", from.c_str(), nullptr);
  g_object_set(part("out").get(), "location", to.c_str(), nullptr);
  std::atomic<std::uint64_t> num_pictures = 0;
  const auto muxer = part("mux");
  g_signal_connect(muxer.get(),
                   "pad-added",
                   G_CALLBACK(+[](GstElement*, GstPad* pad, gpointer counter) {
                     if (GST_PAD_DIRECTION(pad) != GST_PAD_SINK) return;
                     gst_pad_add_probe(
                         pad,
                         GST_PAD_PROBE_TYPE_BUFFER,
                         [](GstPad*, GstPadProbeInfo*, gpointer count) {
                           ++*static_cast<std::atomic<std::uint64_t>*>(count);
                           return GST_PAD_PROBE_OK;
                         },
                         counter,
                         nullptr);
                   }),
                   &num_pictures);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const GstHandle<GstBus> bus(gst_element_get_bus(pipeline.get()));
  GstMessage* const message = gst_bus_timed_pop_filtered(
      bus.get(), 600 * GST_SECOND, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  const bool is_done = message != nullptr && GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS;
  const std::string why = is_done              ? ""
                          : message != nullptr ? sentence_of(message)
                                               : "it takes too long";
  if (message != nullptr) gst_message_unref(message);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (!is_done) return failed(why);
  if (num_pictures == 0) return failed("it has no picture");
  return num_pictures.load();
}

}  // namespace mor
