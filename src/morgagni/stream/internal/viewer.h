// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#define GST_USE_UNSTABLE_API
#include <gst/webrtc/webrtc.h>

#include "morgagni/core/main_loop.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/internal/gst_handles.h"
#include "morgagni/stream/internal/session_offer.h"
#include "morgagni/stream/internal/video_encoder.h"

namespace mor::internal {

/// One browser: `appsrc ! rtpvp8pay ! webrtcbin` in a pipeline of its own, so that no viewer can
/// hold up the encoder or another viewer, and removing one touches nothing else.
///
/// Made, answered and closed in the main loop; send() comes from the encoder's thread.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  using Clock = std::chrono::steady_clock;
  using Answered = std::function<void(Result<std::string>)>;

  /// @param main_loop      Outlives the viewer.
  /// @param timing         Its clock and base time are shared: stamps mean the same everywhere.
  /// @param on_key_wanted  From any thread: the browser cannot decode without a key picture.
  [[nodiscard]] static Result<std::shared_ptr<Viewer>> create(MainLoop& main_loop,
                                                              GstElement* timing,
                                                              int vp8_payload_type,
                                                              std::function<void()> on_key_wanted);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Negotiates; `answered` gets the SDP answer with all candidates, or why there is none. Once.
  void answer(SdpHandle offer, Answered answered);

  /// Ends everything. What still arrives for this viewer is dropped.
  void close();

  /// A picture, and what belongs to it. A viewer who does not keep up misses pictures and goes on
  /// with the next key picture; it never waits. Encoder's thread.
  void send(const EncodedPicture& picture, const std::string& message);

  /// Never connected, hung up, or silent for too long: it should be closed.
  [[nodiscard]] bool is_gone(Clock::time_point now) const;

 private:
  Viewer(MainLoop& main_loop, std::function<void()> on_key_wanted);
  Result<void> build(GstElement* timing, int vp8_payload_type);
  Result<GstElement*> add_payloader(int vp8_payload_type);
  void stay_on_loopback();
  void watch();

  void on_change_of(const char* property, void (Viewer::*handler)());
  void after(const std::function<void(GstPromise*)>& step,
             std::function<void(Viewer&, const GstStructure*)> next);

  void create_answer();
  void adopt_answer(const GstStructure* reply);
  void on_gathering_changed();
  void on_connection_changed();
  void on_channel(GstWebRTCDataChannel* channel);
  void on_message(const std::string& text);
  void finish_answer(Result<std::string> result);
  void send_message(const std::string& text);

  MainLoop& main_loop_;
  std::function<void()> on_key_wanted_;
  GstHandle<GstElement> pipeline_;
  GstHandle<GstElement> source_;
  GstElement* webrtc_ = nullptr;  ///< Belongs to the pipeline.
  Answered answered_;
  Clock::time_point created_at_ = Clock::now();
  bool has_failed_ = false;
  bool is_waiting_for_key_ = true;  ///< Of the encoder's thread.
  std::atomic<bool> is_connected_ = false;

  mutable std::mutex mutex_;
  GObjectHandle<GstWebRTCDataChannel> channel_;
  Clock::time_point heard_at_;
};

/// Milliseconds of the server's own clock, as the page is told them.
[[nodiscard]] double server_ms(Viewer::Clock::time_point time);

}  // namespace mor::internal
