// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/findings_desk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/session/depth_pick.h"
#include "morgagni/session/photo_crop.h"
#include "morgagni/session/scene_view.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

/// Pictures are remembered so long as a tap on them can still be under way.
constexpr std::size_t kMaxShown = 24;
constexpr std::size_t kMaxPicks = 8;
constexpr double kInFrontMm = 25.0;   ///< Nearer than the skin by more: a hand, an instrument.
constexpr double kLeastFacing = 0.2;  ///< Below, the skin is seen too flat to say more.
constexpr double kPhotoMarginMm = 50.0;
constexpr std::uintmax_t kMaxPhotoBytes = 64U << 20U;

tl::unexpected<Error> refuse(std::string sentence) {
  return make_error(ErrorCode::kInvalidArgument, std::move(sentence));
}

bool is_color_picture(const ShownPicture& shown) {
  return shown.camera == shown.tracked.frame->calibration->color;
}

OverlayView view_of(const ShownPicture& shown) {
  OverlayView view = overlay_view(*shown.tracked.frame,
                                  shown.tracked.ct_from_depth,
                                  shown.tracked.ct_from_ghost,
                                  shown.view,
                                  shown.is_still);
  view.color_camera = shown.camera;
  view.color_from_ct = shown.camera_from_ct;
  return view;
}

/// Whether the camera measured something before the skin at this pixel.
bool is_covered(const RenderScene& scene, const ShownPicture& shown, const Eigen::Vector2d& pixel) {
  if (!is_color_picture(shown)) return false;
  const auto measured = depth_point_at(*shown.tracked.frame, pixel);
  OverlayView closed = view_of(shown);
  closed.hole.radius = 0.0F;
  const auto skin = pick_point(scene, closed, pixel);
  if (!measured || !skin) return false;
  const Eigen::Vector3d measured_ct = *shown.tracked.ct_from_depth * *measured;
  return (*shown.camera_from_ct * measured_ct).z() <
         (*shown.camera_from_ct * skin->ct_mm).z() - kInFrontMm;
}

std::vector<Eigen::Vector3d> places_of(const std::vector<FindingPick>& picks) {
  std::vector<Eigen::Vector3d> places;
  for (const auto& pick : picks) places.push_back(pick.point.ct_mm);
  return places;
}

}  // namespace

FindingsDesk::FindingsDesk(std::shared_ptr<const Case> body, std::shared_ptr<const LiveLoop> loop)
    : body_(std::move(body)),
      loop_(std::move(loop)),
      scene_(scene_of(*body_)),
      book_(FindingBook::open(body_->folder / "findings")),
      marks_(std::shared_ptr<const TriangleMesh>(body_->skin, &body_->skin->mesh)) {
  show_marks();
}

std::string FindingsDesk::marks(const ShownPicture& shown) {
  {
    const std::lock_guard lock(mutex_);
    shown_.push_back(shown);
    if (shown_.size() > kMaxShown) shown_.pop_front();
  }
  return marks_.json(shown);
}

Result<ShownPicture> FindingsDesk::shown_picture(std::optional<std::uint64_t> frame_id) const {
  const std::lock_guard lock(mutex_);
  if (shown_.empty()) return refuse("there is no picture yet");
  if (!frame_id) return shown_.back();
  const auto found = std::find_if(shown_.rbegin(), shown_.rend(), [&](const ShownPicture& shown) {
    return shown.tracked.frame->frame_id == *frame_id;
  });
  if (found == shown_.rend())
    return refuse("the picture that was tapped is gone already: tap again, or freeze it first");
  return *found;
}

Result<FindingPick> FindingsDesk::pick(const Eigen::Vector2d& pixel,
                                       std::optional<std::uint64_t> frame_id) {
  MOR_TRY(const ShownPicture shown, shown_picture(frame_id));
  // There the skin is cut away where it has no colours, of which pick_point knows nothing.
  if (shown.is_free)
    return refuse("findings are set on the camera's picture: switch back from the free view");
  if (!shown.camera_from_ct || !shown.tracked.ct_from_depth)
    return refuse("the body is not tracked: there is no point of it here");
  if (shown.tracked.is_held)
    return refuse("this picture has no pose of its own: wait until the body is tracked again");
  const auto seen = pick_point(scene_, view_of(shown), pixel);
  if (!seen) return refuse("there is no body at this point: tap the body");
  if (is_covered(scene_, shown, pixel))
    return refuse("something lies in front of the body here: tap beside it, or take it away");
  FindingPick pick{.number = ++last_pick_,
                   .point = {.ct_mm = seen->ct_mm,
                             .is_on_skin = seen->thing == PickedThing::kSkin,
                             .bound_mm = std::nullopt},
                   .seen = *seen,
                   .shown = shown};
  if (shown.tracked.covariance) {
    const double facing = pick.point.is_on_skin ? std::max(seen->facing, kLeastFacing) : 1.0;
    pick.point.bound_mm = error_bound_mm(*shown.tracked.covariance, seen->ct_mm) / facing;
  }
  picks_.push_back(pick);
  if (picks_.size() > kMaxPicks) picks_.erase(picks_.begin());
  show_marks();
  return pick;
}

void FindingsDesk::forget_picks() {
  picks_.clear();
  show_marks();
}

Result<std::vector<FindingPick>> FindingsDesk::picks_of(const std::vector<int>& numbers) const {
  std::vector<FindingPick> picks;
  for (const int number : numbers) {
    const auto found = std::find_if(
        picks_.begin(), picks_.end(), [number](const auto& pick) { return pick.number == number; });
    if (found == picks_.end()) return refuse("this point is no longer known: tap it again");
    picks.push_back(*found);
  }
  return picks;
}

Result<Finding> FindingsDesk::add(FindingKind kind,
                                  const std::vector<int>& picks,
                                  const std::string& note) {
  if (!book_) return tl::unexpected<Error>(book_.error());
  const std::size_t num_wanted = kind == FindingKind::kPoint ? 1 : 2;
  if (picks.size() != num_wanted)
    return refuse(fmt::format("this finding needs {} point(s), got {}", num_wanted, picks.size()));
  MOR_TRY(const auto tapped, picks_of(picks));
  Finding finding;
  finding.kind = kind;
  finding.note = note;
  for (const auto& pick : tapped) finding.points.push_back(pick.point);
  MOR_CHECK(measure(finding));
  auto added = book_->add(std::move(finding), photos_of(tapped));
  if (added) picks_.clear();
  show_marks();
  return added;
}

Result<void> FindingsDesk::measure(Finding& finding) {
  if (finding.kind == FindingKind::kPoint) return {};
  const auto& from = finding.points.front();
  const auto& to = finding.points.back();
  finding.length_bound_mm = length_bound_mm(from, to);
  if (finding.kind == FindingKind::kDistance) {
    finding.length_mm = straight_length(from, to).length_mm;
    return {};
  }
  if (!from.is_on_skin || !to.is_on_skin)
    return refuse("a way over the skin needs two points on the skin: one is inside");
  const auto skin = std::shared_ptr<const TriangleMesh>(body_->skin, &body_->skin->mesh);
  if (!ways_) ways_.emplace(skin);
  MOR_TRY(const auto start, nearest_on_surface(*skin, from.ct_mm));
  MOR_TRY(const auto end, nearest_on_surface(*skin, to.ct_mm));
  MOR_TRY(auto path, ways_->shortest_path(start, end));
  finding.length_mm = path.length_mm;
  finding.path_ct_mm = std::move(path.points_mm);
  return {};
}

FindingPhotos FindingsDesk::photos_of(const std::vector<FindingPick>& picks) const {
  const auto& tracked = picks.back().shown.tracked;
  const auto& calibration = *tracked.frame->calibration;
  const auto places = places_of(picks);
  FindingPhotos photos;
  const Eigen::Isometry3d color_from_ct =
      calibration.color_from_depth * tracked.ct_from_depth->inverse();
  if (const auto box = box_around(places, calibration.color, color_from_ct, kPhotoMarginMm))
    photos.plain = encode_png(cropped(tracked.frame->color.view(), *box).view());
  const auto snapshot = loop_->snapshot();
  if (!snapshot || !snapshot->shown.camera_from_ct) return photos;
  const auto& [pixels, shown, marks] = *snapshot;
  if (const auto box = box_around(places, shown.camera, *shown.camera_from_ct, kPhotoMarginMm)) {
    auto crop = cropped(pixels.view(), *box);
    for (const auto& place : places) {
      const auto pixel = shown.camera.project(*shown.camera_from_ct * place);
      if (pixel) draw_ring(crop.view(), *pixel - box->min().cast<double>());
    }
    photos.overlay = encode_png(crop.view());
  }
  return photos;
}

Result<void> FindingsDesk::changed(const Result<void>& change) {
  show_marks();
  return change;
}

Result<void> FindingsDesk::set_note(const std::string& id, const std::string& note) {
  if (!book_) return tl::unexpected<Error>(book_.error());
  return changed(book_->set_note(id, note));
}

Result<void> FindingsDesk::remove(const std::string& id) {
  if (!book_) return tl::unexpected<Error>(book_.error());
  return changed(book_->remove(id));
}

Result<void> FindingsDesk::undo() {
  if (!book_) return tl::unexpected<Error>(book_.error());
  return changed(book_->undo());
}

Result<std::vector<Finding>> FindingsDesk::findings() const {
  if (!book_) return tl::unexpected<Error>(book_.error());
  return book_->findings();
}

std::string FindingsDesk::undoable() const {
  return book_ ? book_->undoable() : std::string();
}

Result<std::vector<std::byte>> FindingsDesk::photo(const std::string& id, bool overlay) const {
  if (!book_) return tl::unexpected<Error>(book_.error());
  const Finding* const finding = book_->find(id);
  if (finding == nullptr || finding->photo.empty()) return refuse("there is no such photo");
  const std::string name = overlay ? overlay_photo_name(finding->photo) : finding->photo;
  return read_file(body_->folder / "findings" / name, kMaxPhotoBytes);
}

void FindingsDesk::show_marks() {
  std::vector<FindingPoint> points;
  for (const auto& pick : picks_) points.push_back(pick.point);
  marks_.set(book_ ? book_->findings() : std::vector<Finding>(), points);
}

}  // namespace mor
