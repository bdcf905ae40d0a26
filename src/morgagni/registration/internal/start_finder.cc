// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>

#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/start_decision.h"
#include "morgagni/registration/internal/start_refinement.h"

namespace mor::internal {
namespace {

/// Where the first finds nothing to be believed, as where clutter hides most of the body.
constexpr SearchEffort kSecondEffort{.max_searched = 400, .max_refined = 60, .max_verified = 16};
constexpr StartVolumeOptions kCoarseVolume{.nodes_along_body = 48.0F, .reach_nodes = 2.5F};
constexpr StartVolumeOptions kFineVolume{.nodes_along_body = 96.0F, .reach_nodes = 2.5F};
constexpr double kFloatingCost = 2.0;
constexpr float kMostBelowTable = 0.05F;  ///< Of the readings.
constexpr std::size_t kLeastPoints = 60;
constexpr std::size_t kMostRecalled = 12;
constexpr std::size_t kMostSharpened = 4;

}  // namespace

RefinementRound close_round(float noise_mm) {
  return {0.6F * noise_mm + 0.6F, noise_mm + 1.0F, true, 8};
}

float StartFinder::noise_at(const Eigen::Isometry3d& ct_from_depth) const {
  return axial_noise_mm(static_cast<float>((ct_from_depth.inverse() * bounds_.center()).z()));
}

StartFinder::StartFinder(std::shared_ptr<const FixedSurface> fixed,
                         const PinholeCamera& depth_camera,
                         const AutomaticStartOptions& options)
    : options_(options),
      maker_(depth_camera),
      fixed_(fixed),
      extent_mm_(fixed->mesh.bounds().sizes().maxCoeff()),
      verifier_(fixed, extent_mm_),
      fine_(fixed, {}),
      bounds_(fixed->mesh.bounds().cast<double>()) {
  for (const BodySide side : options.lying_on) {
    const bool is_on_side = side == BodySide::kLeft || side == BodySide::kRight;
    height_mm_ = std::max(height_mm_, static_cast<float>(bounds_.sizes()[is_on_side ? 0 : 1]));
    lyings_.push_back({make_start_volume(*fixed, side, kCoarseVolume),
                       make_start_volume(*fixed, side, kFineVolume)});
  }
}

std::vector<StartPlane> StartFinder::planes_of(const StartPicture& picture) const {
  std::optional<Eigen::Vector3f> up;
  if (options_.gravity) up = -options_.gravity->normalized().cast<float>();
  return find_planes(picture, up);
}

/// Places and turns on the plane, polished, best first.
std::vector<StartFinding> StartFinder::search(const StartPicture& picture,
                                              const StartScene& scene,
                                              const Lying& lying,
                                              const SearchEffort& effort) const {
  const auto candidates = search_on_plane(scene, lying.coarse, effort.max_searched);
  const Eigen::Isometry3d ct_from_lying = lying.coarse.lying_from_ct.inverse();
  std::vector<StartFinding> findings(candidates.size());
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
    const auto polished =
        polish_on_plane(scene, lying.fine, candidates[i], lying.coarse.spacing_mm);
    findings[i].ct_from_depth =
        ct_from_lying * polished.lying_from_table() * scene.table_from_depth;
    findings[i].on_plane = findings[i].ct_from_depth;
    findings[i].agreement =
        verifier_.glance(picture, findings[i].ct_from_depth, 2.0F * lying.fine.spacing_mm);
    findings[i].score = polished.score + findings[i].agreement.num_agree -
                        kFloatingCost * findings[i].agreement.num_floating;
  });
  keep_best(findings, effort.max_refined, lying.fine.spacing_mm, bounds_);
  return findings;
}

/// Brings the findings to where bare skin fits, and counts what speaks for them there.
void StartFinder::refine(const StartPicture& picture,
                         const StartScene& scene,
                         std::vector<StartFinding>& findings,
                         const std::stop_token& stop) const {
  const SensorPoints full = take_points(scene.full);
  tbb::parallel_for(std::size_t{0}, findings.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    Eigen::Isometry3d& pose = findings[i].ct_from_depth;
    const float noise_mm = noise_at(pose);
    const Eigen::Vector3d up_ct = pose.linear() * scene.plane.normal.cast<double>();
    if (scene.plane.is_supposed) {
      // Its height is off by up to half the step between supposed planes.
      const auto near = fine_.align(scene.full, pose, StartQuality::kRough);
      if (near) pose = near->fixed_from_moving;
    }
    pose = refine_on_plane(fixed_->field,
                           full,
                           pose,
                           {up_ct, 0.5, 0.003},
                           {3.0F * noise_mm + 2.0F, 4.0F * noise_mm + 3.0F, true, 6});
    pose = refine_on_plane(fixed_->field,
                           full,
                           pose,
                           {up_ct, 3.0, 0.02},
                           {2.0F * noise_mm + 1.0F, 3.0F * noise_mm + 2.0F, true, 8});
    const float tolerance_mm = kLookToleranceMm + 2.0F * noise_mm;
    findings[i].agreement = verifier_.glance(picture, pose, tolerance_mm);
    findings[i].score = evidence(findings[i].agreement);
    const auto keep_if_better = [&](const Eigen::Isometry3d& other) {
      const auto agreement = verifier_.glance(picture, other, tolerance_mm);
      if (evidence(agreement) < findings[i].score) return;
      pose = other;
      findings[i].agreement = agreement;
      findings[i].score = evidence(agreement);
    };
    // The hold keeps a pose that little skin fixes; free of it, one that much skin fixes is better.
    const auto fine = fine_.align(scene.full, pose, StartQuality::kTracked);
    if (fine) keep_if_better(fine->fixed_from_moving);
    // Where clutter lies beside the skin, all of these are drawn away from a place that was right.
    keep_if_better(straight_from_plane(scene, findings[i].on_plane, up_ct));
  });
}

/// Where the skin fits closely next to where the search on the plane put the body.
Eigen::Isometry3d StartFinder::straight_from_plane(const StartScene& scene,
                                                   const Eigen::Isometry3d& on_plane,
                                                   const Eigen::Vector3d& up_ct) const {
  const float noise_mm = noise_at(on_plane);
  const Eigen::Isometry3d narrow =
      refine_on_plane(fixed_->field,
                      scene.even,
                      on_plane,
                      {up_ct, 0.5, 0.003},
                      {2.0F * noise_mm + 1.0F, 3.0F * noise_mm + 2.0F, true, 8});
  return refine_on_plane(
      fixed_->field, scene.even, narrow, {up_ct, 3.0, 0.02}, close_round(noise_mm));
}

/// Looks at the findings pixel by pixel, and sorts them.
void StartFinder::verify(const StartPicture& picture,
                         const std::vector<StartPlane>& planes,
                         std::vector<StartFinding>& findings,
                         const std::stop_token& stop) const {
  tbb::parallel_for(std::size_t{0}, findings.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    findings[i].agreement =
        verifier_.look(picture, planes, findings[i].ct_from_depth, kLookToleranceMm);
    findings[i].score = believed_evidence(findings[i].agreement);
  });
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
}

/// Brings the best findings to where bare skin fits very closely, if that is worth more: a towel a
/// few millimetres above skin draws a pose that is let to look farther.
void StartFinder::sharpen(const StartPicture& picture,
                          const std::vector<StartPlane>& planes,
                          std::vector<StartFinding>& findings,
                          const std::stop_token& stop) const {
  const std::size_t count = std::min(findings.size(), kMostSharpened);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    StartFinding& finding = findings[i];
    const auto keep_if_better = [&](const Eigen::Isometry3d& pose) {
      const auto agreement = verifier_.look(picture, planes, pose, kLookToleranceMm);
      if (believed_evidence(agreement) <= finding.score) return;
      finding.ct_from_depth = pose;
      finding.agreement = agreement;
      finding.score = believed_evidence(agreement);
    };
    if (stop.stop_requested()) return;
    keep_if_better(refine_on_plane(fixed_->field,
                                   finding.scene->even,
                                   finding.ct_from_depth,
                                   {finding.up_ct, 3.0, 0.02},
                                   close_round(noise_at(finding.ct_from_depth))));
    // The wider rounds may have left the right dip.
    if (stop.stop_requested()) return;
    keep_if_better(straight_from_plane(*finding.scene, finding.on_plane, finding.up_ct));
  });
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
}

Result<std::vector<StartFinding>> StartFinder::find_on(
    const StartPicture& picture,
    const std::vector<StartPlane>& planes,
    const std::shared_ptr<const StartScene>& scene,
    const SearchEffort& effort,
    const std::stop_token& stop) const {
  const auto cancelled = [] {
    return make_error(ErrorCode::kCancelled, "the automatic start was cancelled");
  };
  std::vector<StartFinding> findings;
  if (stop.stop_requested()) return cancelled();
  if (scene->full.size() < kLeastPoints) return findings;
  for (const auto& lying : lyings_) {
    auto found = search(picture, *scene, lying, effort);
    if (stop.stop_requested()) return cancelled();
    refine(picture, *scene, found, stop);
    keep_best(found, effort.max_verified, kSameShare * extent_mm_, bounds_);
    findings.insert(findings.end(), found.begin(), found.end());
    if (stop.stop_requested()) return cancelled();
  }
  for (auto& finding : findings) {
    finding.scene = scene;
    finding.up_ct = finding.on_plane.linear() * scene->plane.normal.cast<double>();
    finding.foot_ct_mm = static_cast<double>(scene->plane.offset_mm) +
                         finding.up_ct.dot(finding.on_plane.translation());
  }
  verify(picture, planes, findings, stop);
  if (settles(findings)) return findings;
  sharpen(picture, planes, findings, stop);
  if (!settles(findings)) {
    search_around(picture, planes, scene->even, 1, findings);
    keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
  }
  if (stop.stop_requested()) return cancelled();
  return findings;
}

/// Where the table may be, if gravity is known and nothing level is seen at such heights.
std::vector<StartPlane> StartFinder::tables_not_seen(const StartPicture& picture,
                                                     const std::vector<StartPlane>& planes) const {
  if (!options_.gravity) return {};
  const auto supposed = suppose_planes(picture,
                                       -options_.gravity->normalized().cast<float>(),
                                       height_mm_,
                                       2.0F * lyings_[0].coarse.spacing_mm);
  if (supposed.empty()) return {};
  const bool is_seen = std::any_of(planes.begin(), planes.end(), [&](const StartPlane& plane) {
    // Below a flat part of a body there is more of it.
    return share_below(picture, plane, height_mm_) < kMostBelowTable &&
           plane.offset_mm <= supposed.front().offset_mm &&
           plane.offset_mm >= supposed.back().offset_mm;
  });
  return is_seen ? std::vector<StartPlane>() : supposed;
}

/// Adds what is found on these planes to the findings; stops at what is beyond doubt.
Result<void> StartFinder::find_on_each(const StartPicture& picture,
                                       const std::vector<StartPlane>& seen_planes,
                                       const std::vector<StartPlane>& planes,
                                       const SearchEffort& effort,
                                       std::vector<StartFinding>& findings,
                                       const std::stop_token& stop) const {
  for (const auto& plane : planes) {
    const auto scene =
        std::make_shared<const StartScene>(make_scene(picture, plane, height_mm_, extent_mm_));
    MOR_TRY(const auto found, find_on(picture, seen_planes, scene, effort, stop));
    findings.insert(findings.end(), found.begin(), found.end());
    keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
    if (settles(findings)) break;
  }
  return {};
}

Result<StartFinder::Findings> StartFinder::find_all(const StartRecall& recall,
                                                    bool searches_wide,
                                                    const std::stop_token& stop) const {
  const StartPicture& picture = recall.views.newest().picture;
  const auto& seen = recall.views.newest().planes;
  Findings findings;
  const auto search = [&](const std::vector<StartPlane>& planes,
                          const SearchEffort& effort) -> Result<bool> {
    MOR_CHECK(find_on_each(picture, seen, planes, effort, findings.here, stop));
    if (!recall.views.are_several()) return passes(findings.here, recall.num_searched);
    auto all = findings.together.empty() ? recall.findings : std::move(findings.together);
    all.insert(all.end(), findings.here.begin(), findings.here.end());
    findings.together = judge_together(recall.views, std::move(all));
    if (passes(findings.together, recall.num_searched)) return true;
    findings.together = judge_around(recall.views, std::move(findings.together));
    return passes(findings.together, recall.num_searched);
  };
  MOR_TRY(bool is_found, search(seen, kFirstEffort));
  if (is_found) return findings;
  const auto not_seen = tables_not_seen(picture, seen);
  if (!not_seen.empty()) {
    MOR_TRY(is_found, search(not_seen, kFirstEffort));
    if (is_found) return findings;
  }
  if (searches_wide) MOR_CHECK(search(seen, kSecondEffort));
  return findings;
}

void StartFinder::take_in(ImageView<const std::uint16_t> depth_mm, StartRecall& recall) const {
  StartPicture picture = maker_.make(depth_mm, static_cast<float>(options_.max_distance_mm));
  auto planes = planes_of(picture);
  const auto last_from_newest = recall.views.add(std::move(picture), std::move(planes), extent_mm_);
  if (!last_from_newest) recall.findings.clear();
  for (auto& finding : recall.findings) {
    finding.ct_from_depth = finding.ct_from_depth * *last_from_newest;
    finding.on_plane = finding.on_plane * *last_from_newest;
    finding.is_judged = false;
  }
  ++recall.num_searched;
}

/// Whether the newest picture alone would settle the best finding.
bool StartFinder::settles_alone(const StartRecall& recall,
                                const std::vector<StartFinding>& here) const {
  if (here.empty()) return false;
  auto alone = here;
  alone[0].agreement = verifier_.look(recall.views.newest().own,
                                      recall.views.newest().planes,
                                      here[0].ct_from_depth,
                                      kLookToleranceMm);
  return passes(alone, recall.num_searched);
}

Result<AutomaticStartResult> StartFinder::find(ImageView<const std::uint16_t> depth_mm,
                                               const std::stop_token& stop) const {
  StartRecall alone;
  take_in(depth_mm, alone);
  MOR_TRY(const auto findings, find_all(alone, true, stop));
  return decide(alone, findings.here, stop);
}

Result<AutomaticStartResult> StartFinder::find_next(ImageView<const std::uint16_t> depth_mm,
                                                    StartRecall& recall,
                                                    const std::stop_token& stop) const {
  take_in(depth_mm, recall);
  const bool searches_wide = recall.num_searched > 1 && recall.num_searched % 2 == 1;
  auto findings = find_all(recall, searches_wide, stop);
  auto result =
      findings ? decide(recall, findings->judged(), stop) : tl::unexpected<Error>(findings.error());
  if (!result) {
    recall = {};  // Poses and pictures must belong together.
    return result;
  }
  if (!passes(findings->judged(), recall.num_searched) && settles_alone(recall, findings->here)) {
    // What came before does not bear out what this picture alone would settle: begin anew here.
    if (recall.views.are_several()) recall.views.forget_earlier();
    recall.findings = std::move(findings->here);
  } else {
    recall.findings = findings->judged();
  }
  recall.findings.resize(std::min(recall.findings.size(), kMostRecalled));
  return result;
}

}  // namespace mor::internal
