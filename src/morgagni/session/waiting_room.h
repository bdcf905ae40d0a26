// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "morgagni/core/result.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// The page while there is no camera yet: it says what is waited for. The session that follows is
/// started at the same port once this is gone, and the page goes on with that by itself.
class WaitingRoom {
 public:
  /// @param case_name  For the page's head. @errors As LiveServer's.
  [[nodiscard]] static Result<std::unique_ptr<WaitingRoom>> open(const std::string& case_name,
                                                                 const std::string& camera_name,
                                                                 const LiveServerOptions& server);
  virtual ~WaitingRoom() = default;

  /// What is waited for, in a sentence. Any thread.
  virtual void say(const std::string& sentence) = 0;
  [[nodiscard]] virtual std::uint16_t port() const = 0;
};

}  // namespace mor
