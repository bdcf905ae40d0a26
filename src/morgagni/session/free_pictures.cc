// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/free_pictures.h"

#include <algorithm>
#include <chrono>

#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

bool is_good(const TrackedFrame& frame) {
  return frame.state == TrackingState::kTracking && frame.ct_from_depth && !frame.is_held;
}

}  // namespace

Result<ImageView<const Rgba8>> FreePictures::draw(FreeViewRenderer& renderer, ShownPicture& what) {
  remember(what.tracked);
  const auto& color = what.tracked.frame->color;
  FreeView free = free_view(what.view,
                            skin_,
                            color.width(),
                            color.height(),
                            good_ ? good_->frame.get() : nullptr,
                            good_ ? good_->ct_from_depth : std::nullopt);
  if (what.view.free.wears_fused) {
    free.picture.reset();
    if (const auto texture = fused_ ? fused_() : nullptr) free.atlas = atlas_.picture(texture);
  }
  MOR_TRY(const FreePicture drawn, renderer.render(free));
  keep(free, drawn.depth_mm);
  what.is_free = true;
  what.camera = free.camera;
  what.camera_from_ct = free.view_from_ct;
  const auto middle = touch({free.camera.center_x_px, free.camera.center_y_px});
  what.bound_mm = middle ? middle->bound_mm : std::nullopt;
  return drawn.picture;
}

void FreePictures::keep(const FreeView& free, ImageView<const float> depth_mm) {
  const std::lock_guard lock(mutex_);
  if (!seen_) seen_.emplace();
  seen_->camera = free.camera;
  seen_->view_from_ct = free.view_from_ct;
  if (seen_->depth_mm.width() != depth_mm.width() ||
      seen_->depth_mm.height() != depth_mm.height()) {
    seen_->depth_mm = Image<float>(depth_mm.width(), depth_mm.height());
  }
  for (int y = 0; y < depth_mm.height(); ++y) {
    std::copy_n(depth_mm.row(y), depth_mm.width(), seen_->depth_mm.view().row(y));
  }
}

void FreePictures::pass_by(const TrackedFrame& shown) {
  remember(shown);
  const std::lock_guard lock(mutex_);
  seen_.reset();
}

void FreePictures::remember(const TrackedFrame& shown) {
  if (!is_good(shown)) return;
  const std::lock_guard lock(mutex_);
  good_ = shown;
}

bool FreePictures::is_shown() const {
  const std::lock_guard lock(mutex_);
  return seen_.has_value();
}

std::optional<double> FreePictures::colors_age_ms() const {
  const std::lock_guard lock(mutex_);
  if (!good_) return std::nullopt;
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                   good_->frame->captured_at)
      .count();
}

Result<TouchedPoint> FreePictures::touch(const Eigen::Vector2d& pixel) const {
  const std::lock_guard lock(mutex_);
  const auto ct_mm = seen_ ? seen_->ct_point(pixel) : std::nullopt;
  if (!ct_mm) {
    return make_error(ErrorCode::kInvalidArgument, "there is no body at this point: tap the body");
  }
  TouchedPoint touched{.ct_mm = *ct_mm, .bound_mm = std::nullopt, .state = TrackingState::kWaiting};
  if (!good_) return touched;
  touched.state = good_->state;
  if (good_->covariance) touched.bound_mm = error_bound_mm(*good_->covariance, *ct_mm);
  return touched;
}

}  // namespace mor
