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
constexpr double kHopeless = -1.0;   ///< Trust that no closer fit betters enough.
constexpr double kTwinShare = 0.01;  ///< Of the extent: poses this near are the same one.

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
                                   const Eigen::Isometry3d& ct_from_depth) const {
  std::vector<SkinAgreement> looks;
  for (const auto& view : views.all()) {
    looks.push_back(verifier_.look(
        view.picture, view.planes, ct_from_depth * view.newest_from_this, kLookToleranceMm));
  }
  return pooled(looks);
}

/// Brings a finding to where the bare skin in all pictures fits, if that speaks for it.
void StartFinder::refine_together(const SeenViews& views,
                                  const PointCloud& standing,
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
                      standing,
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
  // Those first that the pictures they were found in speak for: wrong ones often have more skin
  // that agrees so-so.
  for (auto& finding : findings) finding.score = trust(finding.agreement);
  keep_best(findings, kMostLookedAt, kTwinShare * extent_mm_, bounds_);
  tbb::parallel_for(std::size_t{0}, findings.size(), [&](std::size_t i) {
    refine_together(views, standing, findings[i]);
    StartFinding& finding = findings[i];
    finding.agreement = look_at(views, finding.ct_from_depth);
    finding.score = believed_evidence(finding.agreement);
    if (trust(finding.agreement) < kHopeless) return;
    const Eigen::Isometry3d close = refine_on_plane(fixed_->field,
                                                    standing,
                                                    finding.ct_from_depth,
                                                    {finding.up_ct, 3.0, 0.02},
                                                    close_round(noise_at(finding.ct_from_depth)));
    const auto agreement = look_at(views, close);
    if (believed_evidence(agreement) <= finding.score) return;
    finding.ct_from_depth = close;
    finding.agreement = agreement;
    finding.score = believed_evidence(agreement);
  });
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
  return findings;
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
    found.back().ct_from_depth = mirrored(finding.ct_from_depth, bounds_.center());
    found.back().up_ct.x() = -finding.up_ct.x();
    found = judge_together(others, std::move(found));
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
