// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// The start finder's second half: what one picture or several say of the poses found.
#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/registration/internal/sensor_points.h"
#include "morgagni/registration/internal/start_decision.h"
#include "morgagni/registration/internal/start_finder.h"
#include "morgagni/registration/internal/start_mirror.h"
#include "morgagni/registration/internal/start_refinement.h"

namespace mor::internal {
namespace {

constexpr std::size_t kMostLookedAt = 10;
constexpr double kHopeless = -1.0;     ///< Trust that no closer fit betters enough.
constexpr double kTwinShare = 0.01;    ///< Of the extent: poses this near are the same one.
constexpr double kAroundShift = 0.08;  ///< Of the extent.
constexpr double kAroundTurnRad = 0.3;
constexpr std::size_t kMostSearchedAround = 3;
constexpr int kAroundSteps = 6;
constexpr int kAroundTurns = 9;
constexpr std::size_t kAroundKept = 6;

}  // namespace

SkinAgreement StartFinder::glance_at(const SeenViews& views,
                                     const Eigen::Isometry3d& ct_from_depth) const {
  std::vector<SkinAgreement> glances;
  for (const auto& view : views.all()) {
    const Eigen::Isometry3d pose = ct_from_depth * view.newest_from_this;
    glances.push_back(
        verifier_.glance(view.picture, pose, kLookToleranceMm + 2.0F * noise_at(pose)));
  }
  return pooled(glances);
}

SkinAgreement StartFinder::look_at(const SeenViews& views,
                                   StartPicture SeenView::*kind,
                                   const Eigen::Isometry3d& ct_from_depth) const {
  std::vector<SkinAgreement> looks;
  for (const auto& view : views.all()) {
    looks.push_back(verifier_.look(
        view.*kind, view.planes, ct_from_depth * view.newest_from_this, kLookToleranceMm));
  }
  return pooled(looks);
}

/// Brings a finding to where the bare skin in all pictures fits, if that speaks for it.
void StartFinder::refine_together(const SeenViews& views,
                                  const PointCloud& standing,
                                  const SensorPoints& readings,
                                  StartFinding& finding) const {
  finding.score = evidence(glance_at(views, finding.ct_from_depth));
  const auto keep_if_better = [&](const Eigen::Isometry3d& pose) {
    const auto agreement = glance_at(views, pose);
    if (evidence(agreement) < finding.score) return;
    finding.ct_from_depth = pose;
    finding.score = evidence(agreement);
  };
  const float noise_mm = noise_at(finding.ct_from_depth);
  const Eigen::Isometry3d held =
      refine_on_plane(fixed_->field,
                      readings,
                      finding.ct_from_depth,
                      {finding.up_ct, 3.0, 0.02},
                      {2.0F * noise_mm + 1.0F, 3.0F * noise_mm + 2.0F, true, 8});
  keep_if_better(held);
  const auto free = fine_.align(standing, held, StartQuality::kTracked);
  if (free) keep_if_better(free->fixed_from_moving);
}

std::vector<StartFinding> StartFinder::judge_together(const SeenViews& views,
                                                      std::vector<StartFinding> findings) const {
  const PointCloud standing = views.standing();
  const SensorPoints readings = take_points(standing);
  // Those first that the pictures they were found in speak for: wrong ones often have more skin
  // that agrees so-so.
  for (auto& finding : findings) finding.score = trust(finding.agreement);
  keep_best(findings, kMostLookedAt, kTwinShare * extent_mm_, bounds_);
  tbb::parallel_for(std::size_t{0}, findings.size(), [&](std::size_t i) {
    StartFinding& finding = findings[i];
    if (finding.is_judged) {
      finding.score = believed_evidence(finding.agreement);
      return;
    }
    const Eigen::Isometry3d as_found = finding.ct_from_depth;
    const double trusted = finding.score;
    refine_together(views, standing, readings, finding);
    finding.is_judged = true;
    finding.agreement = look_at(views, &SeenView::picture, finding.ct_from_depth);
    finding.score = believed_evidence(finding.agreement);
    const auto fit_closely = [&](const Eigen::Isometry3d& pose) {
      const Eigen::Isometry3d close = refine_on_plane(
          fixed_->field, readings, pose, {finding.up_ct, 3.0, 0.02}, close_round(noise_at(pose)));
      const auto agreement = look_at(views, &SeenView::picture, close);
      if (believed_evidence(agreement) <= finding.score) return;
      finding.ct_from_depth = close;
      finding.agreement = agreement;
      finding.score = believed_evidence(agreement);
    };
    if (trust(finding.agreement) >= kHopeless) fit_closely(finding.ct_from_depth);
    // A towel that hugs the skin may have drawn a pose away that was right in its own picture.
    if (trust(finding.agreement) <= 0.0 && trusted > kHopeless) fit_closely(as_found);
  });
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
  if (findings.empty() || margin(findings[0].agreement, 0.0, 2) > 0.0) return findings;
  // A sensor's own errors do not go away in the mean of its pictures: each for itself, then.
  const auto apart = look_at(views, &SeenView::own, findings[0].ct_from_depth);
  if (margin(apart, 0.0, 2) > 0.0) {
    findings[0].agreement = apart;
    findings[0].score = believed_evidence(apart);
  }
  return findings;
}

/// The finding put back onto its plane: shifts along it and the turn about its normal are kept.
Eigen::Isometry3d StartFinder::laid_down(const StartFinding& finding) const {
  const Eigen::Isometry3d moved = finding.ct_from_depth * finding.on_plane.inverse();
  const Eigen::Vector3d shift = moved * bounds_.center() - bounds_.center();
  const Eigen::AngleAxisd turned(Eigen::Matrix3d(moved.linear()));
  return about_center(shift - finding.up_ct * finding.up_ct.dot(shift),
                      turned.angle() * turned.axis().dot(finding.up_ct),
                      finding.up_ct) *
         finding.on_plane;
}

Eigen::Isometry3d StartFinder::about_center(const Eigen::Vector3d& shift_mm,
                                            double turn_rad,
                                            const Eigen::Vector3d& up_ct) const {
  return Eigen::Translation3d(bounds_.center() + shift_mm) * Eigen::AngleAxisd(turn_rad, up_ct) *
         Eigen::Translation3d(-bounds_.center());
}

/// Glances at all places near where the finding lies on its plane, and keeps those where most of
/// the skin shows.
std::vector<StartFinding> StartFinder::places_around(const StartPicture& picture,
                                                     const StartFinding& finding) const {
  const Eigen::Isometry3d middle = laid_down(finding);
  const Eigen::Vector3d along = finding.up_ct.unitOrthogonal();
  const Eigen::Vector3d across = finding.up_ct.cross(along);
  const double step_mm = kAroundShift * extent_mm_ / kAroundSteps;
  const double step_rad = kAroundTurnRad / kAroundTurns;
  const auto tolerance_mm = kLookToleranceMm + 0.5F * static_cast<float>(step_mm) +
                            2.0F * picture.noise_share * noise_at(middle);
  constexpr int kSide = 2 * kAroundSteps + 1;
  std::vector<StartFinding> places(static_cast<std::size_t>((2 * kAroundTurns + 1) * kSide * kSide),
                                   finding);
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const int cell = static_cast<int>(i);
    const double turn_rad = step_rad * (cell / (kSide * kSide) - kAroundTurns);
    const double x_mm = step_mm * (cell % kSide - kAroundSteps);
    const double y_mm = step_mm * (cell / kSide % kSide - kAroundSteps);
    places[i].ct_from_depth =
        about_center(x_mm * along + y_mm * across, turn_rad, finding.up_ct) * middle;
    places[i].score = evidence(verifier_.glance(picture, places[i].ct_from_depth, tolerance_mm));
  });
  keep_best(places, kAroundKept, 1.5 * step_mm, bounds_);
  return places;
}

/// Looks for a better dip around the best findings: beside clutter there are several next to one
/// another, and where the noise is less the right one is deeper.
void StartFinder::search_around(const StartPicture& picture,
                                const std::vector<StartPlane>& planes,
                                const SensorPoints& points,
                                std::size_t count,
                                std::vector<StartFinding>& findings) const {
  std::vector<StartFinding> around;
  for (std::size_t i = 0; i < std::min(findings.size(), count); ++i) {
    const auto places = places_around(picture, findings[i]);
    around.insert(around.end(), places.begin(), places.end());
  }
  tbb::parallel_for(std::size_t{0}, around.size(), [&](std::size_t i) {
    StartFinding& finding = around[i];
    const float noise_mm = picture.noise_share * noise_at(finding.ct_from_depth);
    finding.ct_from_depth = refine_on_plane(fixed_->field,
                                            points,
                                            finding.ct_from_depth,
                                            {finding.up_ct, 0.5, 0.003},
                                            {noise_mm + 1.0F, noise_mm + 2.0F, true, 8});
    finding.ct_from_depth = refine_on_plane(fixed_->field,
                                            points,
                                            finding.ct_from_depth,
                                            {finding.up_ct, 3.0, 0.02},
                                            close_round(noise_mm));
    finding.agreement = verifier_.look(picture, planes, finding.ct_from_depth, kLookToleranceMm);
    finding.score = believed_evidence(finding.agreement);
    finding.is_judged = false;
  });
  findings.insert(findings.end(), around.begin(), around.end());
}

/// Judges the findings together with what is found around the best of them.
std::vector<StartFinding> StartFinder::judge_around(const SeenViews& views,
                                                    std::vector<StartFinding> findings) const {
  const auto& newest = views.newest();
  search_around(
      newest.picture, newest.planes, take_points(newest.standing), kMostSearchedAround, findings);
  return judge_together(views, std::move(findings));
}

/// The believed evidence for the CT's mirror image, of what the same pictures have for the finding
/// itself. It gets the same chance: the same search on the finding's plane, the same judgement.
Result<double> StartFinder::mirrored_share(const SeenViews& views,
                                           const StartFinding& finding,
                                           const std::stop_token& stop) const {
  if (!(finding.score > 0.0)) return 1.0;
  const SeenViews others = mirrored(views);
  const auto& newest = others.newest();
  std::vector<StartFinding> found;
  MOR_CHECK(find_on_each(
      newest.picture, newest.planes, mirrored({plane_of(finding)}), kFirstEffort, found, stop));
  if (views.are_several()) {
    found.push_back(finding);
    found.back().is_judged = false;
    found.back().ct_from_depth = mirrored(finding.ct_from_depth, bounds_.center());
    found.back().on_plane = mirrored(finding.on_plane, bounds_.center());
    found.back().up_ct.x() = -finding.up_ct.x();
    found = judge_around(others, judge_together(others, std::move(found)));
  }
  return found.empty() ? 0.0 : std::max(0.0, found[0].score / finding.score);
}

Result<AutomaticStartResult> StartFinder::decide(const StartRecall& recall,
                                                 const std::vector<StartFinding>& findings,
                                                 const std::stop_token& stop) const {
  AutomaticStartResult result;
  if (findings.empty()) {
    result.reason = "nothing that could be a body stands on a plane of the picture";
    return result;
  }
  const StartFinding& best = findings[0];
  const double num_open = best.agreement.num_seen - best.agreement.num_hidden;
  result.ct_from_depth = best.ct_from_depth;
  result.score = num_open > 0.0 ? best.agreement.num_agree / num_open : 0.0;
  result.runner_up_score = result.score * runner_up_share(findings);
  StartCase start{.look = best.agreement,
                  .runner_up_share = runner_up_share(findings),
                  .num_tries = recall.num_searched};
  if (passes(findings, recall.num_searched)) {
    MOR_TRY(start.mirrored_share, mirrored_share(recall.views, best, stop));
  }
  StartVerdict verdict = decide_start(start);
  result.status = verdict.status;
  result.reason = std::move(verdict.reason);
  return result;
}

}  // namespace mor::internal
