// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "morgagni/render/free_view.h"
#include "morgagni/render/skin_view.h"
#include "morgagni/render/skin_viewpoint.h"
#include "morgagni/session/fused_atlas.h"
#include "morgagni/session/shown_picture.h"
#include "morgagni/session/touched_point.h"
#include "morgagni/tracking/tracker.h"

namespace mor {

/// The free view of a live case: remembers the last good frame, whose colours the skin goes on to
/// wear while the tracking is uncertain or lost, and what was seen where.
/// @threads draw() and pass_by() on the render thread, the others on any.
class FreePictures {
 public:
  explicit FreePictures(const SkinSphere& skin) : skin_(skin) {}

  /// Draws the free view of what is shown, and puts the virtual camera and the bound in it.
  /// @return Valid until the renderer's next picture.
  [[nodiscard]] Result<ImageView<const Rgba8>> draw(FreeViewRenderer& renderer, ShownPicture& what);

  /// Another picture is shown of this frame.
  void pass_by(const TrackedFrame& shown);

  /// Where the fused texture is to be had; null: there is none yet. Before the first picture.
  using Fused = std::function<std::shared_ptr<const SkinTexture>()>;
  void take_fused_from(Fused fused) { fused_ = std::move(fused); }

  [[nodiscard]] bool is_shown() const;

  /// Age of the picture in whose colours the skin is or would be. None: there has been no good one.
  [[nodiscard]] std::optional<double> colors_age_ms() const;

  /// What is seen at a pixel of the last picture. @errors kInvalidArgument: the background.
  [[nodiscard]] Result<TouchedPoint> touch(const Eigen::Vector2d& pixel) const;

 private:
  void remember(const TrackedFrame& shown);
  void keep(const FreeView& free, ImageView<const float> depth_mm);

  const SkinSphere skin_;
  Fused fused_;
  FusedAtlas atlas_;  ///< Of the render thread.
  mutable std::mutex mutex_;
  std::optional<TrackedFrame> good_;  ///< The last frame that was tracked without a doubt.
  std::optional<SkinView> seen_;      ///< Of the last picture, without its colours. None: another
                                      ///< picture is shown.
};

}  // namespace mor
