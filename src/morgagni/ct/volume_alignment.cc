// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/volume_alignment.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/internal/block_search.h"
#include "morgagni/ct/internal/body_block.h"
#include "morgagni/ct/internal/overlap_fit.h"

namespace mor {
namespace {

constexpr double kSearchCubeMm = 4.0;
constexpr double kFineCubeMm = 3.0;
constexpr double kLeastOverlapMm = 20.0;
/// What is believed: these are far from what two scans of an unmoved body give (0.3 and 1 mm).
constexpr double kLeastCorrelation = 0.85;
constexpr double kMostMedianMm = 2.0;
constexpr double kMostP90Mm = 6.0;
constexpr int kLeastPieces = 8;
/// Another place that fits nearly as well makes both doubtful.
constexpr double kClearlyBetter = 0.02;
constexpr double kOtherPlaceMm = 10.0;

bool is_believed(const OverlapQuality& quality) {
  return quality.correlation >= kLeastCorrelation && quality.median_offset_mm <= kMostMedianMm &&
         quality.p90_offset_mm <= kMostP90Mm && quality.num_pieces >= kLeastPieces;
}

std::string figures(const OverlapQuality& quality) {
  return fmt::format(
      "{:.0f} mm in common, correlation {:.2f} (at least {:.2f} is wanted), pieces lie "
      "off by {:.1f} mm in the middle (at most {:.1f}) and {:.1f} mm at 90 % (at most "
      "{:.1f})",
      quality.overlap_mm,
      quality.correlation,
      kLeastCorrelation,
      quality.median_offset_mm,
      kMostMedianMm,
      quality.p90_offset_mm,
      kMostP90Mm);
}

bool are_same_place(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Volume& second) {
  const Eigen::Vector3d middle_mm =
      second.ct_from_grid * (0.5 * Eigen::Vector3d(second.size[0], second.size[1], second.size[2])
                                       .cwiseProduct(second.spacing_mm));
  return (a * middle_mm - b * middle_mm).norm() < kOtherPlaceMm;
}

Result<OverlapQuality> quality_of(const Volume& first_block,
                                  const Volume& second_block,
                                  const Eigen::Isometry3d& first_from_second) {
  const internal::OverlapFit fit(first_block, second_block);
  const OverlapQuality quality = fit.quality(first_from_second);
  if (quality.overlap_mm >= kLeastOverlapMm) return quality;
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("the two CTs show only {:.0f} mm of the body in common, at least {:.0f} mm are "
                  "wanted to check that they fit",
                  quality.overlap_mm,
                  kLeastOverlapMm));
}

}  // namespace

Result<OverlapQuality> overlap_quality(const Volume& first,
                                       const Volume& second,
                                       const Eigen::Isometry3d& first_from_second) {
  return quality_of(internal::body_block(first, kFineCubeMm),
                    internal::body_block(second, kFineCubeMm),
                    first_from_second);
}

Result<AlignedVolumes> align_volumes(const Volume& first,
                                     const Volume& second,
                                     const Progress& progress) {
  constexpr const char* kStage = "align series";
  const auto report = [&](double fraction) {
    if (progress) progress(kStage, fraction);
  };
  report(0.0);
  const Volume first_coarse = internal::body_block(first, kSearchCubeMm);
  const Volume second_coarse = internal::body_block(second, kSearchCubeMm);
  const auto starts = internal::search_blocks(first_coarse, second_coarse);
  report(0.3);
  const Volume first_wide = internal::body_block(first, 2.0 * kSearchCubeMm);
  const Volume second_wide = internal::body_block(second, 2.0 * kSearchCubeMm);
  const Volume first_fine = internal::body_block(first, kFineCubeMm);
  const Volume second_fine = internal::body_block(second, kFineCubeMm);
  report(0.5);

  std::vector<AlignedVolumes> found;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    AlignedVolumes candidate;
    candidate.first_from_second = starts[i];
    for (const auto& [a, b] : {std::pair(&first_wide, &second_wide),
                               std::pair(&first_coarse, &second_coarse),
                               std::pair(&first_fine, &second_fine)})
      candidate.first_from_second =
          internal::OverlapFit(*a, *b).refined(candidate.first_from_second);
    const internal::OverlapFit fine(first_fine, second_fine);
    candidate.quality = fine.quality(candidate.first_from_second);
    if (candidate.quality.overlap_mm >= kLeastOverlapMm) found.push_back(candidate);
    report(0.5 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(starts.size() + 1));
  }
  std::sort(found.begin(), found.end(), [](const AlignedVolumes& a, const AlignedVolumes& b) {
    return a.quality.correlation > b.quality.correlation;
  });
  report(1.0);
  if (found.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "nothing in one series is found in the other: they cannot be joined");
  }
  const auto& best = found.front();
  if (!is_believed(best.quality)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        "the series do not fit together where they fit best: " + figures(best.quality));
  }
  for (const auto& other : found) {
    if (are_same_place(other.first_from_second, best.first_from_second, second)) continue;
    if (!is_believed(other.quality) ||
        other.quality.correlation < best.quality.correlation - kClearlyBetter)
      continue;
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the series fit together in two places nearly as well (correlation {:.3f} and "
                    "{:.3f}): they cannot be joined by what they show",
                    best.quality.correlation,
                    other.quality.correlation));
  }
  return best;
}

}  // namespace mor
