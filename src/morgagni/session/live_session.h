// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "morgagni/session/live_loop.h"
#include "morgagni/session/routes/ct_routes.h"
#include "morgagni/stream/live_server.h"

namespace mor {

struct LiveSessionOptions {
  LiveLoopOptions loop;
  LiveServerOptions server;
  std::string camera_name;  ///< As the user gave it, for the status.
  CtChoice cts;             ///< Of a case with several.
};

/// One live case with its server: from the camera to the tablet.
class LiveSession {
 public:
  /// Starts everything. It runs until it is destroyed. @errors As LiveLoop's and LiveServer's.
  [[nodiscard]] static Result<std::unique_ptr<LiveSession>> start(
      Case body, std::unique_ptr<RangeCamera> camera, const LiveSessionOptions& options);
  virtual ~LiveSession() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;
  [[nodiscard]] virtual LiveStatus status() const = 0;
  [[nodiscard]] virtual LiveServerStats stream_stats() const = 0;
};

}  // namespace mor
