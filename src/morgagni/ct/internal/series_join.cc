// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/series_join.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/log.h"
#include "morgagni/ct/join_volumes.h"
#include "morgagni/ct/volume_alignment.h"

namespace mor::internal {
namespace {

/// Other contrast or another scanner is told; more than this is no CT of the same body.
constexpr double kNotableHu = 20.0;
constexpr double kMostHu = 100.0;
/// Coordinates that two scans share are believed unless the body moved by more than this.
constexpr double kMovedMm = 3.0;
constexpr double kMovedFarMm = 10.0;

Result<CtSeries> series_named(const std::vector<CtSeries>& all,
                              const std::string& wanted,
                              const std::filesystem::path& path) {
  if (wanted.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("name the series of the {} in {} that others are joined to "
                                  "(--series): see --list-series",
                                  all.size(),
                                  path.string()));
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (wanted == std::to_string(i + 1) || wanted == all[i].uid || wanted == all[i].description)
      return all[i];
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("{} holds no series \"{}\": see --list-series", path.string(), wanted));
}

Result<void> check_hu(const OverlapQuality& quality, const std::string& name) {
  if (std::abs(quality.hu_difference) > kMostHu) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("soft tissue differs by {:.0f} HU between the series where \"{}\" is "
                    "joined, the limit is {:.0f} HU",
                    quality.hu_difference,
                    name,
                    kMostHu));
  }
  if (std::abs(quality.hu_difference) > kNotableHu) {
    log::warn(
        "soft tissue differs by {:.0f} HU where \"{}\" is joined: other contrast or another "
        "scanner?",
        quality.hu_difference,
        name);
  }
  return {};
}

/// By their coordinates. What both show must not contradict them.
Result<AlignedVolumes> by_coordinates(const Volume& first,
                                      const Volume& second,
                                      const std::string& name) {
  AlignedVolumes aligned;
  const auto quality = overlap_quality(first, second, aligned.first_from_second);
  if (!quality) {
    log::warn("\"{}\" is joined by its coordinates alone: {}", name, quality.error().message);
    return aligned;
  }
  aligned.quality = *quality;
  if (quality->num_pieces > 0 && quality->median_offset_mm > kMovedFarMm) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("\"{}\" lies {:.0f} mm off in the middle where both show the body, more than "
                    "{:.0f} mm: the body has moved",
                    name,
                    quality->median_offset_mm,
                    kMovedFarMm));
  }
  if (quality->median_offset_mm > kMovedMm) {
    log::warn("the body has moved by about {:.1f} mm before \"{}\": --align-series may help",
              quality->median_offset_mm,
              name);
  }
  return aligned;
}

std::string words(const OverlapQuality& quality, const CtSeries& series, bool by_coordinates) {
  if (quality.num_pieces == 0)
    return fmt::format("; joined with \"{}\" by coordinates", series.description);
  return fmt::format(
      "; joined with \"{}\" {}: {:.0f} mm in common, off by {:.1f} mm in the middle, "
      "{:.1f} mm at 90 %",
      series.description,
      by_coordinates ? "by coordinates" : "by what both show",
      quality.overlap_mm,
      quality.median_offset_mm,
      quality.p90_offset_mm);
}

bool share_frame(const CtSeries& a, const CtSeries& b) {
  return !a.frame_of_reference_uid.empty() && a.frame_of_reference_uid == b.frame_of_reference_uid;
}

Result<void> check_frames(const CtSeries& first, const CtSeries& other, bool align) {
  if (align || share_frame(first, other)) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("\"{}\" and \"{}\" have different frames of reference, so that their coordinates "
                  "do not belong together: --align-series joins them by what both show",
                  first.description,
                  other.description));
}

}  // namespace

Result<Volume> import_joined(const std::filesystem::path& path,
                             const ImportOptions& options,
                             const Progress& progress) {
  MOR_TRY(const auto all, list_ct_series(path, progress));
  MOR_TRY(const CtSeries first, series_named(all, options.series, path));
  std::vector<CtSeries> others;
  for (const auto& wanted : options.join) {
    MOR_TRY(const CtSeries other, series_named(all, wanted, path));
    const bool is_there =
        other.uid == first.uid || std::any_of(others.begin(), others.end(), [&](const auto& o) {
          return o.uid == other.uid;
        });
    if (is_there) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("series \"{}\" is named twice: each is joined once", wanted));
    }
    MOR_CHECK(check_frames(first, other, options.align));
    others.push_back(other);
  }
  MOR_TRY(Volume whole, import_volume(path, {.series = options.series}, progress));
  std::string description = whole.description;
  for (std::size_t i = 0; i < others.size(); ++i) {
    MOR_TRY(const Volume next, import_volume(path, {.series = options.join[i]}, progress));
    MOR_TRY(const auto place,
            options.align ? align_volumes(whole, next, progress)
                          : by_coordinates(whole, next, others[i].description));
    MOR_CHECK(check_hu(place.quality, others[i].description));
    const std::string how = words(place.quality, others[i], !options.align);
    log::info("series{}", how);
    description += how;
    MOR_TRY(whole, join_volumes(whole, next, place.first_from_second, progress));
  }
  whole.description = description;
  return whole;
}

}  // namespace mor::internal
