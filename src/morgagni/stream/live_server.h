// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/video_recording.h"

namespace mor {

struct HttpRequest {
  std::string path;
  std::map<std::string, std::string> query;
  std::string body;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
};

/// Called on the server's thread; must return soon.
using HttpHandler = std::function<HttpResponse(const HttpRequest&)>;

struct HttpRoute {
  std::string method;  ///< "GET", "POST", ...
  std::string path;    ///< Exact.
  HttpHandler handler;
};

struct LiveServerOptions {
  std::uint16_t port = 8080;       ///< On 127.0.0.1 only. 0: any free port.
  std::filesystem::path web_root;  ///< The built page.
  int bitrate_kbps = 4000;         ///< Of the VP8 stream. 100..50000.
  int max_viewers = 8;

  [[nodiscard]] Result<void> check() const;
};

/// What a picture carries to the page besides its pixels.
struct PictureInfo {
  std::chrono::steady_clock::time_point captured_at;  ///< Of the frame shown.
  std::string json;  ///< Sent to every viewer as {"rtp": <stamp>, ...this object's members} over
                     ///< the data channel "pictures", in step with the picture.
};

struct LiveServerStats {
  int num_viewers = 0;
  std::uint64_t num_encoded = 0;
  std::uint64_t num_dropped = 0;  ///< Pictures that were replaced before the encoder took them.
  double encode_ms = 0.0;         ///< Median of the last 60.
  double capture_to_encoded_ms = 0.0;  ///< Median of the last 60.
  double capture_to_encoded_p95_ms = 0.0;
};

/// Serves the page and the live picture: VP8 over WebRTC (WHEP: POST /whep, DELETE /whep/ID),
/// status by server-sent events (GET /api/events), JSON commands by routes. One GLib loop in a
/// thread of its own.
class LiveServer {
 public:
  /// Listens on 127.0.0.1. @errors kInvalidArgument (options); kDevice: the port is in use (names
  /// it and what to do), a GStreamer plug-in is missing (names the package); kNotFound: the page is
  /// not built.
  [[nodiscard]] static Result<std::unique_ptr<LiveServer>> start(const LiveServerOptions& options,
                                                                 std::vector<HttpRoute> routes);
  virtual ~LiveServer() = default;

  /// Hands over a picture; an older one that still waits is dropped. Sizes may change. Any thread.
  virtual void show(ImageView<const Rgba8> picture, const PictureInfo& info) = 0;

  /// Sends one event of name `status` to every page. Any thread.
  virtual void publish_status(std::string json) = 0;

  /// Writes what is streamed into a video, from the next picture on; the stream does not wait for
  /// it. @errors kInvalidArgument: one is being written already; kIo: which file, and why.
  [[nodiscard]] virtual Result<void> start_video(const VideoFiles& files) = 0;
  /// Of the video that is written, or of the last one.
  [[nodiscard]] virtual VideoStatus video() const = 0;
  /// Ends the video and waits until its files are whole. Any thread but the server's own.
  virtual VideoStatus stop_video() = 0;

  [[nodiscard]] virtual LiveServerStats stats() const = 0;
  [[nodiscard]] virtual std::uint16_t port() const = 0;
};

}  // namespace mor
