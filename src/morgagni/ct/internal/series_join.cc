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

/// Where in the list a series stands. Parts of one series, of several acquisitions, share its UID
/// and its description: they are told by their number alone.
Result<std::size_t> find_series(const std::vector<CtSeries>& all,
                                const std::string& wanted,
                                const std::filesystem::path& path) {
  if (wanted.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("name the series of the {} in {} that others are joined to "
                                  "(--series): see --list-series",
                                  all.size(),
                                  path.string()));
  }
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (wanted == std::to_string(i + 1)) return i;
    if (wanted == all[i].uid || wanted == all[i].description) named.push_back(i);
  }
  if (named.size() == 1) return named.front();
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{} holds {} series \"{}\": see --list-series",
                                path.string(),
                                named.empty() ? "no" : "more than one",
                                wanted));
}

Result<Volume> import_numbered(const std::filesystem::path& path,
                               std::size_t index,
                               const Progress& progress) {
  return import_volume(path, {.series = std::to_string(index + 1)}, progress);
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
  MOR_TRY(const std::size_t first, find_series(all, options.series, path));
  std::vector<std::size_t> others;
  for (const auto& wanted : options.join) {
    MOR_TRY(const std::size_t other, find_series(all, wanted, path));
    if (other == first || std::find(others.begin(), others.end(), other) != others.end()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("series \"{}\" is named twice: each is joined once", wanted));
    }
    MOR_CHECK(check_frames(all[first], all[other], options.align));
    others.push_back(other);
  }
  MOR_TRY(Volume whole, import_numbered(path, first, progress));
  std::string description = whole.description;
  for (const std::size_t other : others) {
    MOR_TRY(const Volume next, import_numbered(path, other, progress));
    MOR_TRY(const auto place,
            options.align ? align_volumes(whole, next, progress)
                          : by_coordinates(whole, next, all[other].description));
    MOR_CHECK(check_hu(place.quality, all[other].description));
    const std::string how = words(place.quality, all[other], !options.align);
    log::info("series{}", how);
    description += how;
    MOR_TRY(whole, join_volumes(whole, next, place.first_from_second, progress));
  }
  whole.description = description;
  return whole;
}

}  // namespace mor::internal
