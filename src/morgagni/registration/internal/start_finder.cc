// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/start_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>

#include "morgagni/geometry/rigid.h"

namespace mor::internal {
namespace {

constexpr std::size_t kMaxSearched = 160;  ///< Candidates of one search that are glanced at.
constexpr std::size_t kMaxRefined = 24;    ///< Of those, refined.
constexpr std::size_t kMaxVerified = 6;    ///< Of those, refined fully and looked at.
constexpr double kSameShare = 0.08;  ///< Of the extent: poses that put the body this near are one.
constexpr double kFloatingCost = 2.0;
constexpr double kHiddenCost = 0.3;
constexpr float kLookToleranceMm = 2.0F;
constexpr double kLeastScore = 0.6;
constexpr double kLeastExplained = 0.3;
constexpr double kClearlyWorse = 0.8;  ///< The runner-up's share of the best one's evidence.
constexpr std::size_t kLeastPoints = 60;

/// What speaks for a pose less what speaks against it, in pixels.
double evidence(const SkinAgreement& agreement) {
  return agreement.num_agree - kFloatingCost * agreement.num_floating -
         kHiddenCost * agreement.num_hidden;
}

double worth(const SkinAgreement& agreement) {
  return agreement.num_seen > 0.0 ? evidence(agreement) / agreement.num_seen : -1.0;
}

/// How far two poses put the body apart: the largest distance of the corners of its bounds.
double distance_mm(const Eigen::Isometry3d& a,
                   const Eigen::Isometry3d& b,
                   const Eigen::AlignedBox3d& bounds) {
  const Eigen::Isometry3d b_from_a = b * a.inverse();
  double most_mm = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    most_mm = std::max(most_mm, (b_from_a * p - p).norm());
  }
  return most_mm;
}

template <class T>
void keep_best(std::vector<T>& items,
               std::size_t count,
               double near_mm,
               const Eigen::AlignedBox3d& bounds) {
  // Indices are sorted: std::stable_sort's buffer is not aligned for Eigen.
  std::vector<std::size_t> order(items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&items](std::size_t a, std::size_t b) {
    return items[a].score > items[b].score;
  });
  std::vector<T> kept;
  for (const std::size_t i : order) {
    if (kept.size() == count) break;
    auto& item = items[i];
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const T& other) {
      return distance_mm(item.ct_from_depth, other.ct_from_depth, bounds) < near_mm;
    });
    if (is_new) kept.push_back(std::move(item));
  }
  items = std::move(kept);
}

}  // namespace

StartFinder::StartFinder(std::shared_ptr<const FixedSurface> fixed,
                         const PinholeCamera& depth_camera,
                         const AutomaticStartOptions& options,
                         std::unique_ptr<FineRegistration> registration)
    : options_(options),
      maker_(depth_camera),
      extent_mm_(fixed->mesh.bounds().sizes().maxCoeff()),
      registration_(std::move(registration)),
      verifier_(fixed, extent_mm_),
      bounds_(fixed->mesh.bounds().cast<double>()) {
  for (const BodySide side : options.lying_on) volumes_.push_back(make_start_volume(*fixed, side));
}

Result<StartFinder> StartFinder::create(std::shared_ptr<const FixedSurface> fixed,
                                        const PinholeCamera& depth_camera,
                                        const AutomaticStartOptions& options) {
  MOR_TRY(auto registration, make_fine_registration(fixed, {}));
  return StartFinder(std::move(fixed), depth_camera, options, std::move(registration));
}

std::vector<StartPlane> StartFinder::planes_of(const StartPicture& picture) const {
  std::optional<Eigen::Vector3f> up;
  if (options_.gravity) up = -options_.gravity->normalized().cast<float>();
  return find_planes(picture, up);
}

Result<std::vector<StartFinding>> StartFinder::find_on(const StartPicture& picture,
                                                       const StartPlane& plane,
                                                       const std::stop_token& stop) const {
  const auto cancelled = [] {
    return make_error(ErrorCode::kCancelled, "the automatic start was cancelled");
  };
  std::vector<StartFinding> findings;
  for (const auto& volume : volumes_) {
    if (stop.stop_requested()) return cancelled();
    const float height_mm =
        static_cast<float>((volume.lying_from_ct.linear() * bounds_.sizes()).cwiseAbs().z());
    const StartScene scene = make_scene(picture, plane, height_mm, extent_mm_);
    if (scene.full.size() < kLeastPoints) continue;
    auto candidates = search_on_plane(scene, volume, kMaxSearched);
    std::vector<StartFinding> found(candidates.size());
    const float glance_mm = 4.0F * volume.spacing_mm;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      found[i].ct_from_depth = candidates[i].ct_from_depth;
      found[i].search_score = candidates[i].score;
      found[i].glance_score = worth(verifier_.glance(picture, found[i].ct_from_depth, glance_mm));
      found[i].score = found[i].search_score + 0.5 * found[i].glance_score;
    }
    keep_best(found, kMaxRefined, 0.0, bounds_);
    std::vector<std::uint8_t> failed(found.size(), 0);
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
      if (stop.stop_requested()) return;
      const auto fit =
          registration_->align(scene.rough, found[i].ct_from_depth, StartQuality::kRough);
      if (!fit) {
        failed[i] = 1;
        return;
      }
      found[i].ct_from_depth = fit->fixed_from_moving;
      found[i].fit = *fit;
      found[i].glance_score =
          worth(verifier_.glance(picture, found[i].ct_from_depth, 2.0F * volume.spacing_mm));
      found[i].score = fit->explained_fraction + 0.5 * found[i].glance_score;
    });
    if (stop.stop_requested()) return cancelled();
    keep_best(found, kMaxVerified, kSameShare * extent_mm_, bounds_);
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
      if (stop.stop_requested()) return;
      const auto fit =
          registration_->align(scene.full, found[i].ct_from_depth, StartQuality::kTracked);
      if (fit) {
        found[i].ct_from_depth = fit->fixed_from_moving;
        found[i].fit = *fit;
      }
      found[i].agreement = verifier_.look(picture, found[i].ct_from_depth, kLookToleranceMm);
      found[i].score = evidence(found[i].agreement);
    });
    if (stop.stop_requested()) return cancelled();
    findings.insert(findings.end(), found.begin(), found.end());
  }
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
  return findings;
}

AutomaticStartResult StartFinder::decide(const std::vector<StartFinding>& findings) const {
  AutomaticStartResult result;
  if (findings.empty()) {
    result.reason = "nothing that could be a body stands on a plane of the picture";
    return result;
  }
  const StartFinding& best = findings[0];
  result.ct_from_depth = best.ct_from_depth;
  result.score = worth(best.agreement);
  if (findings.size() > 1 && best.score > 0.0) {
    result.runner_up_score = result.score * std::max(0.0, findings[1].score) / best.score;
  }
  if (result.score < kLeastScore || best.fit.explained_fraction < kLeastExplained) {
    result.reason = fmt::format(
        "no pose explains the picture: at the best {:.0f} % of the skin is where it should be seen "
        "and {:.0f} % of what is seen is skin",
        100.0 * std::max(0.0, result.score),
        100.0 * best.fit.explained_fraction);
  } else if (result.runner_up_score > kClearlyWorse * result.score) {
    result.status = AutomaticStartStatus::kAmbiguous;
    result.reason = fmt::format(
        "two poses explain the picture about equally well (scores {:.2f} and {:.2f}): show more of "
        "the body",
        result.score,
        result.runner_up_score);
  } else {
    result.status = AutomaticStartStatus::kFound;
  }
  return result;
}

Result<AutomaticStartResult> StartFinder::find(ImageView<const std::uint16_t> depth_mm,
                                               const std::stop_token& stop) const {
  const StartPicture picture = picture_of(depth_mm);
  std::vector<StartFinding> findings;
  for (const auto& plane : planes_of(picture)) {
    MOR_TRY(auto found, find_on(picture, plane, stop));
    findings.insert(findings.end(), found.begin(), found.end());
  }
  keep_best(findings, findings.size(), kSameShare * extent_mm_, bounds_);
  return decide(findings);
}

}  // namespace mor::internal
