// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/core/image.h"
#include "morgagni/core/latest_slot.h"
#include "morgagni/documentation/skin_texture.h"
#include "morgagni/documentation/texture_fusion.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

class SkinCoverage;

/// What the page shows of the fused texture.
struct TextureStatus {
  bool is_ready = false;  ///< The skin is unwrapped; before, nothing can be recorded.
  bool is_recording = false;
  double coverage = 0.0;              ///< Of the skin that could be seen (SkinCoverage), 0..1.
  std::size_t num_frames = 0;         ///< That have given texels.
  std::optional<FusionOutcome> last;  ///< What became of the newest frame. None: no frame yet.
  std::uint64_t version = 0;          ///< Of `sides_png` and `texture`: grows when they change.
  bool is_saving = false;
  bool is_saved = false;  ///< The case has what is here.
  std::string problem;    ///< Why it could not be loaded or saved. Empty: nothing is wrong.
};

/// Melts the live loop's frames into the case's texture, in a thread of its own at low priority:
/// at most four frames a second, only well tracked ones. The texture lies in the case's folder
/// `texture`; what lies there is gone on from.
/// @threads Any.
class TextureRecorder {
 public:
  explicit TextureRecorder(std::shared_ptr<const Case> body);
  ~TextureRecorder();

  /// LiveLoop::Observe.
  void look(const TrackedFrame& tracked);

  /// @errors kInvalidArgument: the skin is still being unwrapped, or cannot be.
  [[nodiscard]] Result<void> record(bool on);
  /// Forgets what was melted. The case keeps what it has until save().
  void start_again();
  /// Saves in the recorder's thread; the status says when it is done. @errors kInvalidArgument:
  /// nothing has been seen yet.
  [[nodiscard]] Result<void> save();

  [[nodiscard]] TextureStatus status() const;
  /// PNG: the body from its four sides, what was never seen marked. Empty before it is ready.
  [[nodiscard]] std::vector<std::byte> sides_png() const;
  /// The texture as it was a second ago at most. Null before it is ready.
  [[nodiscard]] std::shared_ptr<const SkinTexture> texture() const;

 private:
  void run(std::stop_token stop);
  /// Unwraps the skin, or takes what the case has. None: the reason is in the status.
  [[nodiscard]] std::optional<TextureFusion> begin();
  void melt(TextureFusion& fusion, const TrackedFrame& tracked);
  void show(const TextureFusion& fusion);
  void write();

  const std::shared_ptr<const Case> body_;
  LatestSlot<std::optional<TrackedFrame>> slot_;  ///< An empty one wakes the thread.

  mutable std::mutex mutex_;  ///< Guards everything down to the next blank line.
  TextureStatus status_;
  bool wants_again_ = false;
  bool wants_save_ = false;
  std::vector<std::byte> sides_png_;
  std::shared_ptr<const SkinTexture> texture_;

  std::unique_ptr<SkinCoverage> coverage_;  ///< Of the thread alone, as the next.
  std::uint64_t shown_version_ = 0;
  std::jthread thread_;
};

}  // namespace mor
