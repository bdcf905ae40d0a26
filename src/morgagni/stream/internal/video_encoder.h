// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/core/statistics.h"
#include "morgagni/stream/internal/gst_handles.h"
#include "morgagni/stream/live_server.h"

namespace mor::internal {

/// A VP8 picture as it leaves the encoder.
struct EncodedPicture {
  GstBuffer* buffer = nullptr;  ///< Lives as long as the call.
  std::uint32_t rtp_stamp = 0;  ///< 90 kHz, what the browser calls rtpTimestamp.
  bool is_key = false;
  std::chrono::steady_clock::time_point captured_at;
  const std::string& info_json;
};

/// `appsrc ! vp8enc ! fakesink`: takes the newest picture whenever the encoder is free, so nothing
/// queues before it. The appsrc's thread is the encoder's thread.
class VideoEncoder {
 public:
  /// Called on the encoder's thread for each picture, in order.
  using Sink = std::function<void(const EncodedPicture&)>;

  [[nodiscard]] static Result<std::unique_ptr<VideoEncoder>> create(int bitrate_kbps, Sink sink);
  ~VideoEncoder();
  VideoEncoder(const VideoEncoder&) = delete;
  VideoEncoder& operator=(const VideoEncoder&) = delete;

  /// Copies the picture (as I420); one that still waits is dropped. Any thread.
  void show(ImageView<const Rgba8> picture, const PictureInfo& info);

  /// The next picture can be decoded without the ones before it. While no new picture comes, the
  /// last one is sent again, so that a viewer who joins a standing picture sees it. Any thread.
  void request_key_picture();

  void add_to(LiveServerStats& stats) const;
  [[nodiscard]] GstElement* pipeline() const { return pipeline_.get(); }

 private:
  struct Picture {
    std::shared_ptr<GstBuffer> pixels;
    int width = 0;
    int height = 0;
    PictureInfo info;
    bool is_repeat = false;
  };

  VideoEncoder() = default;
  Result<void> build(int bitrate_kbps);
  [[nodiscard]] std::optional<Picture> take();
  void feed();
  void force_key_if_wanted();
  void on_encoded(GstBuffer* buffer);
  [[nodiscard]] GstClockTime next_stamp();

  static constexpr std::size_t kTimedPictures = 60;

  Sink sink_;
  GstHandle<GstElement> pipeline_;
  GstHandle<GstElement> source_;
  GstHandle<GstElement> encoder_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Picture> waiting_;
  bool key_wanted_ = false;
  int repeats_left_ = 0;  ///< Of a standing picture, after somebody wanted a key picture.
  bool stopping_ = false;
  std::uint64_t num_encoded_ = 0;
  std::uint64_t num_dropped_ = 0;
  RollingWindow encode_ms_{kTimedPictures};
  RollingWindow capture_to_encoded_ms_{kTimedPictures};

  // Of the encoder's thread alone.
  Picture current_;
  std::pair<int, int> size_{0, 0};
  GstClockTime last_stamp_ = 0;
  std::chrono::steady_clock::time_point fed_at_;
  std::chrono::steady_clock::time_point last_key_at_;
};

/// The 90 kHz stamp that rtpvp8pay (timestamp-offset=0) gives a picture.
[[nodiscard]] std::uint32_t rtp_stamp_of(GstClockTime running_time);

}  // namespace mor::internal
