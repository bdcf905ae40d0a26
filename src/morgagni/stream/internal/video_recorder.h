// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "morgagni/core/result.h"
#include "morgagni/stream/internal/gst_handles.h"
#include "morgagni/stream/internal/video_encoder.h"
#include "morgagni/stream/video_recording.h"

namespace mor::internal {

/// Writes the encoder's pictures into a WebM file, `appsrc ! webmmux ! filesink`, in a thread of
/// its own: a slow or full disk ends the video, never the stream. Each picture is in the file as
/// soon as the disk takes it, so that a killed program leaves a video that plays.
class VideoRecorder {
 public:
  /// Makes both files, which must not be there. @errors kIo.
  [[nodiscard]] static Result<std::unique_ptr<VideoRecorder>> create(const VideoFiles& files);
  ~VideoRecorder();
  VideoRecorder(const VideoRecorder&) = delete;
  VideoRecorder& operator=(const VideoRecorder&) = delete;

  /// The next picture. Those before the first key picture are left out. Encoder's thread; never
  /// waits for the disk.
  void add(const EncodedPicture& picture);

  /// Writes what is still to be written and ends the file properly. Once. Waits.
  void finish();

  [[nodiscard]] VideoStatus status() const;

 private:
  struct Entry {
    GstBufferHandle buffer;
    std::string line;
    double time_s = 0.0;
  };

  explicit VideoRecorder(const VideoFiles& files) : files_(files) { status_.is_running = true; }
  void write(std::stop_token stop);
  [[nodiscard]] bool write_entry(Entry& entry);
  [[nodiscard]] bool open_video();
  [[nodiscard]] bool wait_for_room();
  /// Looks for an error of the pipeline, which ends the video.
  [[nodiscard]] bool has_failed();
  void close_video();
  void fail(std::string sentence);

  const VideoFiles files_;
  int lines_fd_ = -1;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Entry> waiting_;
  std::size_t waiting_bytes_ = 0;
  VideoStatus status_;
  GstClockTime first_stamp_ = GST_CLOCK_TIME_NONE;

  // Of the writing thread.
  GstHandle<GstElement> pipeline_;
  GstHandle<GstElement> source_;
  bool is_broken_ = false;  ///< Nothing more can be written; a video may end otherwise too.

  std::jthread thread_;
};

/// Width and height that a VP8 key picture says of itself; zeros: it is none (RFC 6386, 9.1).
[[nodiscard]] std::pair<int, int> vp8_size(GstBuffer* buffer);

}  // namespace mor::internal
