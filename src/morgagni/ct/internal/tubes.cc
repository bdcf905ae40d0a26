// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/tubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Dense>
#include <tbb/parallel_for.h>

#include "morgagni/core/statistics.h"
#include "morgagni/ct/internal/volume_sample.h"

namespace mor::internal {
namespace {

using Eigen::Vector3d;

constexpr double kAirHu = -1000.0;
constexpr double kLeastRadiusMm = 1.4;
constexpr double kMostRadiusMm = 7.6;
/// From section to section.
constexpr double kStepMm = 2.0;

/// A tube goes on beyond the scan's ends.
double hu_at(const Volume& volume, Vector3d mm) {
  mm.z() = std::clamp(mm.z(), 0.0, (volume.size[2] - 1) * volume.spacing_mm.z());
  return sampled_hu(volume, mm).value_or(kAirHu);
}

bool is_inside(const Volume& volume, const Vector3d& mm) {
  const Vector3d last_mm =
      (Eigen::Map<const Eigen::Vector3i>(volume.size.data()).array() - 1).cast<double>() *
      volume.spacing_mm.array();
  return (mm.array() >= 0.0).all() && (mm.array() <= last_mm.array()).all();
}

/// A tube cut across.
struct Section {
  Vector3d middle_mm;
  Vector3d along;
  double radius_mm = 0.0;
};

/// How much of a rim must be seen: of 20 rays; of ten pairs of opposite ones so many may see none.
struct Sight {
  std::size_t least_rays;
  std::size_t most_hidden;
  double most_off;  ///< Share of the radius that a ray may end beside the circle.
};
constexpr Sight kAtFirst = {12, 1, 0.12};
/// Once it is known where it must lie: in a fold of the skin.
constexpr Sight kFollowing = {7, 5, 0.2};

/// The rim of something round about a place, seen along rays across an axis.
class Rim {
 public:
  Rim(const Volume& volume, const Section& guess) : middle_mm_(guess.middle_mm) {
    across_ = guess.along.unitOrthogonal();
    down_ = guess.along.cross(across_);
    for (std::size_t ray = 0; ray < kNumRays; ++ray) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(ray) / kNumRays;
      towards_[ray] = {std::cos(angle), std::sin(angle)};
      edges_mm_[ray] = edge_mm(volume, plane_to_grid(towards_[ray]), guess.radius_mm);
    }
  }

  /// The circle through it (Kasa 1976). None where too little is seen of one.
  [[nodiscard]] std::optional<Section> circle(const Vector3d& along) const {
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    std::size_t num = 0;
    for (std::size_t ray = 0; ray < kNumRays; ++ray) {
      if (!edges_mm_[ray]) continue;
      const Eigen::Vector2d edge = *edges_mm_[ray] * towards_[ray];
      const Vector3d terms(2.0 * edge.x(), 2.0 * edge.y(), 1.0);
      gram += terms * terms.transpose();
      right += edge.squaredNorm() * terms;
      ++num;
    }
    if (num < kFollowing.least_rays) return std::nullopt;
    const Vector3d fit = gram.ldlt().solve(right);
    const double radius_mm = std::sqrt(std::max(0.0, fit.z() + fit.head<2>().squaredNorm()));
    return Section{middle_mm_ + plane_to_grid(fit.head<2>()), along, radius_mm};
  }

  /// Whether most of it lies on a circle about the middle. What lies against a tube hides one side
  /// of it; of a plate both edges are not seen.
  [[nodiscard]] bool is_round(double radius_mm, const Sight& sight) const {
    const double most_off_mm = std::max(0.4, sight.most_off * radius_mm);
    const auto lies_on_it = [&](std::size_t ray) {
      return edges_mm_[ray] && std::abs(*edges_mm_[ray] - radius_mm) <= most_off_mm;
    };
    std::size_t num = 0;
    std::size_t num_hidden = 0;
    for (std::size_t ray = 0; ray < kNumRays / 2; ++ray) {
      const std::size_t seen = (lies_on_it(ray) ? 1 : 0) + (lies_on_it(ray + kNumRays / 2) ? 1 : 0);
      num += seen;
      num_hidden += seen == 0 ? 1 : 0;
    }
    return num >= sight.least_rays && num_hidden <= sight.most_hidden;
  }

 private:
  static constexpr std::size_t kNumRays = 20;

  [[nodiscard]] Vector3d plane_to_grid(const Eigen::Vector2d& place) const {
    return place.x() * across_ + place.y() * down_;
  }

  /// Where matter ends, nearest to where it is expected to.
  [[nodiscard]] std::optional<double> edge_mm(const Volume& volume,
                                              const Vector3d& towards,
                                              double expected_mm) const {
    constexpr double kSeekMm = 0.4;
    constexpr double kReachMm = 1.6;
    std::optional<double> edge;
    double mm = std::max(0.0, expected_mm - kReachMm);
    double before_hu = hu_at(volume, middle_mm_ + mm * towards);
    while (mm < expected_mm + kReachMm) {
      mm += kSeekMm;
      const double hu = hu_at(volume, middle_mm_ + mm * towards);
      if (before_hu >= SkinProfile::kEdgeHu && hu < SkinProfile::kEdgeHu) {
        const double at = mm - kSeekMm * (SkinProfile::kEdgeHu - hu) / (before_hu - hu);
        if (!edge || std::abs(at - expected_mm) < std::abs(*edge - expected_mm)) edge = at;
      }
      before_hu = hu;
    }
    return edge;
  }

  Vector3d middle_mm_;
  Vector3d across_;
  Vector3d down_;
  std::array<Eigen::Vector2d, kNumRays> towards_;
  std::array<std::optional<double>, kNumRays> edges_mm_;  ///< From the middle.
};

/// The section nearest to a guess, its middle inside the CT.
std::optional<Section> section_near(const Volume& volume, Section section, const Sight& sight) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const auto found = Rim(volume, section).circle(section.along);
    if (!found || found->radius_mm < kLeastRadiusMm || found->radius_mm > kMostRadiusMm)
      return std::nullopt;
    section = *found;
  }
  if (!is_inside(volume, section.middle_mm)) return std::nullopt;
  if (!Rim(volume, section).is_round(section.radius_mm, sight)) return std::nullopt;
  return section;
}

/// What the surface around a profile turns about, as its normals say. None where it hardly turns.
std::optional<Section> turning_about(const SkinProfiles& profiles, std::size_t profile) {
  constexpr float kLeastCosine = 0.2F;
  constexpr float kLeastTurn = 0.05F;
  const auto& all = profiles.all();
  auto places = profiles.beside(profile);
  std::erase_if(places, [&](std::size_t k) {
    return all[k].inwards.dot(all[profile].inwards) < kLeastCosine;
  });
  places.push_back(profile);
  Eigen::Vector3f place_mm = Eigen::Vector3f::Zero();
  Eigen::Vector3f inwards = Eigen::Vector3f::Zero();
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
  for (const std::size_t k : places) {
    place_mm += all[k].place_mm / static_cast<float>(places.size());
    inwards += all[k].inwards / static_cast<float>(places.size());
    spread += all[k].inwards * all[k].inwards.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(spread);
  if (solver.eigenvalues()[1] < kLeastTurn * solver.eigenvalues()[2]) return std::nullopt;
  const Eigen::Vector3f along = solver.eigenvectors().col(0);
  float closing = 0.0F;
  float turned = 0.0F;
  for (const std::size_t k : places) {
    Eigen::Vector3f turn = all[k].inwards - inwards;
    turn -= turn.dot(along) * along;
    closing -= turn.dot(all[k].place_mm - place_mm);
    turned += turn.squaredNorm();
  }
  const float radius_mm = closing / std::max(1e-6F, turned);
  const Eigen::Vector3f middle_mm = place_mm + radius_mm * inwards;
  return Section{middle_mm.cast<double>(), along.cast<double>(), radius_mm};
}

class Search {
 public:
  Search(const Volume& volume, const SkinProfiles& profiles, const BitMask& settled)
      : volume_(volume), profiles_(profiles), settled_(settled), is_done_(profiles.all().size()) {}

  std::vector<Tube> run() {
    std::vector<std::optional<Section>> starts(is_done_.size());
    tbb::parallel_for(
        std::size_t{0}, starts.size(), [&](std::size_t i) { starts[i] = start_at(i); });
    std::vector<Tube> tubes;
    std::vector<Tube> pieces;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (is_done_[i] != 0 || !starts[i]) continue;
      const Path path = followed(*starts[i]);
      note(path);
      if (is_settled(path)) continue;
      Tube tube = tube_of(path);
      const bool is_certain = length_mm(tube) >= least_mm(tube);
      (is_certain ? tubes : pieces).push_back(std::move(tube));
    }
    join(std::move(pieces), tubes);
    return tubes;
  }

 private:
  using Path = std::vector<Section>;

  /// Where the surface turns as a tube's does.
  [[nodiscard]] std::optional<Section> start_at(std::size_t profile) const {
    if (profiles_.all()[profile].area_mm2 <= 0.0F) return std::nullopt;
    const auto guess = turning_about(profiles_, profile);
    if (!guess || guess->radius_mm < 0.5 * kLeastRadiusMm || guess->radius_mm > 1.3 * kMostRadiusMm)
      return std::nullopt;
    return section_near(volume_, *guess, kAtFirst);
  }

  [[nodiscard]] Path followed(const Section& start) const {
    Section backwards = start;
    backwards.along = -start.along;
    Path path = one_way(backwards);
    std::reverse(path.begin(), path.end());
    path.push_back(start);
    const Path onwards = one_way(start);
    path.insert(path.end(), onwards.begin(), onwards.end());
    return path;
  }

  /// The sections after one, over gaps where something lies against it all around.
  [[nodiscard]] Path one_way(const Section& start) const {
    constexpr std::size_t kMostSections = 1000;
    constexpr int kMostGap = 4;
    Path path;
    Section last = start;
    for (int gap = 0; gap <= kMostGap && path.size() < kMostSections;) {
      Section guess = last;
      guess.middle_mm += kStepMm * (gap + 1) * last.along;
      auto next = section_near(volume_, guess, kFollowing);
      if (!next || !is_as_large(next->radius_mm, start.radius_mm) ||
          (next->middle_mm - guess.middle_mm).norm() > kStepMm) {
        ++gap;
        continue;
      }
      const Vector3d& before = path.size() < 3 ? start.middle_mm : path[path.size() - 3].middle_mm;
      next->along = (next->middle_mm - before).normalized();
      for (int k = 1; k <= gap; ++k) {
        Section between = last;
        between.middle_mm += k / (gap + 1.0) * (next->middle_mm - last.middle_mm);
        path.push_back(between);
      }
      gap = 0;
      path.push_back(*next);
      last = *next;
    }
    return path;
  }

  [[nodiscard]] static bool is_as_large(double radius_mm, double wanted_mm) {
    return std::abs(radius_mm - wanted_mm) <= std::max(0.5, 0.2 * wanted_mm);
  }

  /// Nothing of it is to be followed again.
  void note(const Path& path) {
    for (const Section& section : path)
      profiles_.for_each_within(section.middle_mm.cast<float>(),
                                static_cast<float>(section.radius_mm + 1.5),
                                [&](std::size_t i) { is_done_[i] = 1; });
  }

  [[nodiscard]] bool is_settled(const Path& path) const {
    return std::any_of(path.begin(), path.end(), [&](const Section& section) {
      const Eigen::Vector3i at = volume_.nearest_voxel(section.middle_mm);
      return settled_.test(at.x(), at.y(), at.z());
    });
  }

  [[nodiscard]] static double length_mm(const Tube& tube) {
    return kStepMm * static_cast<double>(tube.axis_mm.size() - 1);
  }

  /// Nothing that is round of three real bodies is as long (RealCovers.NothingOfABodyIsATube).
  [[nodiscard]] static double least_mm(const Tube& tube) {
    constexpr double kLumenHu = -250.0;
    constexpr double kLeastWithLumenMm = 60.0;
    constexpr double kDenseHu = 180.0;
    constexpr double kLeastDenseMm = 80.0;
    constexpr double kLeastMm = 110.0;
    return tube.middle_hu < kLumenHu   ? kLeastWithLumenMm
           : tube.middle_hu > kDenseHu ? kLeastDenseMm
                                       : kLeastMm;
  }

  /// Where a tube bends sharply, or something hides it, it is followed in pieces: what looks like a
  /// tube that is certain and begins where that ends belongs to it. Beside its middle it does not:
  /// the hollows of an ear that a tube passes look like one.
  static void join(std::vector<Tube> pieces, std::vector<Tube>& tubes) {
    for (std::size_t next = 0; next < tubes.size(); ++next) {
      const auto joined = std::partition(pieces.begin(), pieces.end(), [&](const Tube& piece) {
        return !goes_on(tubes[next], piece);
      });
      tubes.insert(tubes.end(), joined, pieces.end());
      pieces.erase(joined, pieces.end());
    }
  }

  [[nodiscard]] static bool goes_on(const Tube& tube, const Tube& piece) {
    constexpr double kLeastShare = 0.25;
    constexpr double kMostGapMm = 12.0;
    constexpr double kAlikeHu = 100.0;
    if (length_mm(piece) < kLeastShare * least_mm(piece) ||
        std::abs(piece.middle_hu - tube.middle_hu) > kAlikeHu ||
        !is_as_large(piece.radius_mm, tube.radius_mm))
      return false;
    const auto ends_at = [](const Tube& one, const Vector3d& mm) {
      return std::min((one.axis_mm.front() - mm).norm(), (one.axis_mm.back() - mm).norm()) <=
             kMostGapMm;
    };
    return ends_at(tube, piece.axis_mm.front()) || ends_at(tube, piece.axis_mm.back());
  }

  [[nodiscard]] Tube tube_of(const Path& path) const {
    Tube tube;
    std::vector<double> radii_mm;
    std::vector<double> hu;
    for (const Section& section : path) {
      tube.axis_mm.push_back(section.middle_mm);
      radii_mm.push_back(section.radius_mm);
      hu.push_back(hu_at(volume_, section.middle_mm));
    }
    tube.radius_mm = quantile(std::move(radii_mm), 0.5);
    tube.middle_hu = quantile(std::move(hu), 0.5);
    return tube;
  }

  const Volume& volume_;
  const SkinProfiles& profiles_;
  const BitMask& settled_;
  std::vector<char> is_done_;  ///< Of each profile.
};

}  // namespace

std::vector<Tube> find_tubes(const Volume& volume,
                             const SkinProfiles& profiles,
                             const BitMask& settled) {
  return Search(volume, profiles, settled).run();
}

void take_out(const Tube& tube, const Volume& before, Volume& volume, BitMask& taken) {
  constexpr double kBlurMm = 1.0;
  constexpr double kCrustMm = 0.15;  // -300 HU lie so much deeper than the middle of the blur.
  const double reach_mm = tube.radius_mm + kCrustMm + 0.5 * kBlurMm;
  const auto visit = [&](const Vector3d& middle_mm) {
    Eigen::Vector3i low =
        ((middle_mm.array() - reach_mm) / volume.spacing_mm.array()).ceil().cast<int>();
    Eigen::Vector3i high =
        ((middle_mm.array() + reach_mm) / volume.spacing_mm.array()).floor().cast<int>();
    low = low.cwiseMax(0);
    high = high.cwiseMin(Eigen::Vector3i(volume.size[0], volume.size[1], volume.size[2]) -
                         Eigen::Vector3i::Ones());
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Vector3d place = Vector3d(x, y, z).cwiseProduct(volume.spacing_mm);
          const double beyond_mm = (place - middle_mm).norm() - tube.radius_mm - kCrustMm;
          const double share = std::clamp(beyond_mm / kBlurMm + 0.5, 0.0, 1.0);
          const std::size_t i = volume.index(x, y, z);
          const double hu = kAirHu + share * (before.hu[i] - kAirHu);
          if (hu >= volume.hu[i]) continue;
          if (volume.hu[i] >= SkinProfile::kEdgeHu && hu < SkinProfile::kEdgeHu)
            taken.set_run(y, z, x, x + 1);
          volume.hu[i] = static_cast<std::int16_t>(std::lround(hu));
        }
      }
    }
  };
  const double end_mm = tube.radius_mm;  // Its ends are no sections.
  const auto& axis = tube.axis_mm;
  const auto between = [&](const Vector3d& from, const Vector3d& to) {
    constexpr int kNum = 5;
    for (int k = 0; k <= kNum; ++k) visit(from + k / (1.0 * kNum) * (to - from));
  };
  for (std::size_t i = 1; i < axis.size(); ++i) between(axis[i - 1], axis[i]);
  between(axis.front(), axis.front() + end_mm * (axis.front() - axis[2]).normalized());
  between(axis.back(), axis.back() + end_mm * (axis.back() - axis[axis.size() - 3]).normalized());
}

}  // namespace mor::internal
