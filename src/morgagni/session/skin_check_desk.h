// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "morgagni/ct/body_check.h"
#include "morgagni/session/routes/api_json.h"
#include "morgagni/session/skin_check.h"

namespace mor {

/// What the page of a skin check asks and commands. All calls from the server's thread but wait().
class SkinCheckDesk {
 public:
  SkinCheckDesk(std::shared_ptr<const Volume> volume, UseBody use, const SkinCheckOptions& options);

  /// Finds the body for the first time.
  [[nodiscard]] Result<void> begin();

  [[nodiscard]] api::Json state();
  /// Other thresholds, or another verdict on one part; then what state() says.
  [[nodiscard]] Result<api::Json> change(const std::string& text);
  [[nodiscard]] Result<api::Json> use();
  [[nodiscard]] Result<api::Json> cancel();
  [[nodiscard]] HttpResponse slice(const HttpRequest& request) const;
  /// Vertices and triangles as bytes (docs/http-api.md).
  [[nodiscard]] HttpResponse surface(const HttpRequest& request) const;

  [[nodiscard]] std::optional<PrepareSummary> wait(std::stop_token stop);

 private:
  enum class Stage : std::uint8_t { kChecking, kPreparing, kDone, kFailed, kCancelled };

  [[nodiscard]] Result<std::size_t> listed(const api::Json& json,
                                           const char* key,
                                           std::size_t size) const;
  [[nodiscard]] Result<void> decide(SkinOptions& skin, const api::Json& json) const;
  [[nodiscard]] Result<void> take_off(SkinOptions& skin, const api::Json& json) const;
  [[nodiscard]] Result<void> find(const SkinOptions& skin);
  [[nodiscard]] Result<void> check_open() const;
  [[nodiscard]] api::Json parts_json() const;
  [[nodiscard]] api::Json doubts_json() const;
  /// The slices through a place.
  [[nodiscard]] api::Json slices_through(const Eigen::Vector3d& place_mm) const;
  void finish(Result<PrepareSummary> made);

  const SkinCheckOptions options_;
  const UseBody use_;
  BodyCheck check_;
  PrepareOptions prepare_;
  int version_ = 0;  ///< Grows when another body was found.
  std::chrono::milliseconds took_{0};

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any changed_;
  Stage stage_ = Stage::kChecking;
  std::string step_;
  double fraction_ = 0.0;
  std::string error_;
  std::optional<PrepareSummary> made_;
  bool end_was_told_ = false;
  std::jthread worker_;
};

}  // namespace mor
