// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_series.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "morgagni/core/printable_text.h"

#include "messages.h"
#include "slice_reader.h"

namespace mor::import {
namespace {

constexpr double kSamePlaceMm = 0.01;
constexpr double kAlike = 1e-3;

/// The names of what is left out, by the reason.
using LeftOut = std::map<std::string, std::vector<std::string>>;

double height_of(const DicomSlice& slice, const Eigen::Vector3d& normal) {
  return normal.dot(*slice.position_mm);
}

bool fit_together(const DicomSlice& a, const DicomSlice& b) {
  return a.series_uid == b.series_uid && a.columns == b.columns && a.rows == b.rows &&
         (a.spacing_mm - b.spacing_mm).cwiseAbs().maxCoeff() < kAlike &&
         (*a.axes - *b.axes).cwiseAbs().maxCoeff() < kAlike;
}

void sort_along_normal(DicomSeries& series) {
  const Eigen::Vector3d normal = series.front().normal();
  std::stable_sort(series.begin(), series.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return height_of(a, normal) < height_of(b, normal);
  });
}

bool at_same_place(const DicomSlice& a, const DicomSlice& b) {
  return (*a.position_mm - *b.position_mm).norm() < kSamePlaceMm;
}

/// A number for a slice's pixels, so that many are compared and each is decoded once.
class PixelSums {
 public:
  explicit PixelSums(const StudyFiles& files) : reader_(files) {}

  [[nodiscard]] bool are_same(const DicomSlice& a, const DicomSlice& b) {
    if (a.sop_instance_uid == b.sop_instance_uid && !a.sop_instance_uid.empty() &&
        a.frame == b.frame)
      return true;
    const auto sum = sum_of(a);
    return sum && sum == sum_of(b);
  }

 private:
  /// Nothing: the pixels cannot be read.
  std::optional<std::size_t> sum_of(const DicomSlice& slice) {
    const auto [known, is_new] = sums_.try_emplace({slice.file, slice.frame});
    if (is_new) {
      if (const auto hu = reader_.read_hu(slice))
        known->second = std::hash<std::string_view>{}(
            {reinterpret_cast<const char*>(hu->data()), hu->size() * sizeof(hu->front())});
    }
    return known->second;
  }

  SliceReader reader_;
  std::map<std::pair<std::size_t, int>, std::optional<std::size_t>> sums_;  ///< File, frame.
};

/// Neighbours in a sorted series that are the same slice are kept once.
void drop_copies(DicomSeries& series, const StudyFiles& files, LeftOut& left_out) {
  PixelSums sums(files);
  const Eigen::Vector3d normal = series.front().normal();
  DicomSeries kept;
  for (auto& slice : series) {
    bool is_copy = false;
    for (auto other = kept.rbegin(); other != kept.rend() && !is_copy; ++other) {
      if (height_of(slice, normal) - height_of(*other, normal) > kSamePlaceMm) break;
      is_copy = at_same_place(slice, *other) && sums.are_same(slice, *other);
    }
    if (is_copy) {
      left_out["it is there twice"].push_back(slice.name);
    } else {
      kept.push_back(std::move(slice));
    }
  }
  series = std::move(kept);
}

bool shares_places(const DicomSeries& series) {
  return std::adjacent_find(series.begin(), series.end(), at_same_place) != series.end();
}

/// Whether an acquisition begins before another one ends: two table positions or two phases, whose
/// slices would come in turns. Acquisitions that follow one another are one scan, as are slices
/// with a number each.
bool acquisitions_overlap(const DicomSeries& series) {
  struct Range {
    double low_mm;
    double high_mm;
  };
  const Eigen::Vector3d normal = series.front().normal();
  std::map<int, Range> by_number;
  for (const auto& slice : series) {
    const double height_mm = height_of(slice, normal);
    by_number.try_emplace(slice.acquisition_number, Range{height_mm, 0.0}).first->second.high_mm =
        height_mm;  // They are in order.
  }
  std::vector<Range> ranges;
  for (const auto& [number, range] : by_number)
    if (range.high_mm - range.low_mm > kSamePlaceMm) ranges.push_back(range);
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) {
    return a.low_mm < b.low_mm;
  });
  return std::adjacent_find(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) {
           return b.low_mm < a.high_mm - kSamePlaceMm;
         }) != ranges.end();
}

std::vector<DicomSeries> by_acquisition(DicomSeries series) {
  std::map<int, DicomSeries> acquisitions;
  for (auto& slice : series) acquisitions[slice.acquisition_number].push_back(std::move(slice));
  std::vector<DicomSeries> parts;
  for (auto& [number, part] : acquisitions) parts.push_back(std::move(part));
  return parts;
}

std::string gone_wrong(const std::string& name, const Error& error) {
  return name + " " + error.message;
}

/// Reads all files' heads and puts slices that fit together into one series.
std::vector<DicomSeries> gather(const StudyFiles& files,
                                LeftOut& left_out,
                                std::vector<DamagedFile>& damaged) {
  std::vector<DicomSeries> all;
  std::map<std::string, std::vector<std::size_t>> by_uid;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = files.name(i);
    say_file(name);
    if (i % 8 == 0)
      say_progress(kScanShare * static_cast<double>(i) / static_cast<double>(files.size()));
    const auto loaded = files.load(i);
    if (!loaded) {
      damaged.push_back({name, {}, {loaded.error().code, gone_wrong(name, loaded.error())}});
      continue;
    }
    const auto parsed = parse_dicom(loaded->bytes);
    if (!parsed && parsed.error().code == ErrorCode::kUnsupported) {
      left_out["it is no DICOM file"].push_back(name);
      continue;
    }
    if (!parsed) {
      damaged.push_back(
          {name,
           series_uid_of_damaged(loaded->bytes),
           {parsed.error().code, gone_wrong(name, parsed.error()) + ": copy the series again"}});
      continue;
    }
    if (parsed->data.find(Tag::kDirectoryRecords) != nullptr) continue;
    for (auto& slice : slices_of(*parsed, i, name)) {
      if (!slice.flaw.empty()) {
        left_out[slice.flaw].push_back(slice.name);
        continue;
      }
      auto& candidates = by_uid[slice.series_uid];
      const auto found = std::find_if(candidates.begin(), candidates.end(), [&](std::size_t k) {
        return fit_together(all[k].front(), slice);
      });
      if (found != candidates.end()) {
        all[*found].push_back(std::move(slice));
      } else {
        candidates.push_back(all.size());
        all.push_back({std::move(slice)});
      }
    }
  }
  return all;
}

std::string reason_for_few(const DicomSeries& series, const std::vector<DicomSeries>& all) {
  const auto& slice = series.front();
  const auto rest = std::find_if(all.begin(), all.end(), [&](const DicomSeries& other) {
    return other.size() >= kMinSlices && other.front().series_uid == slice.series_uid;
  });
  if (rest == all.end())
    return "its series has fewer than " + std::to_string(kMinSlices) + " slices";
  const auto& other = rest->front();
  if (other.columns != slice.columns || other.rows != slice.rows)
    return "it has another size than the other slices of its series";
  if ((other.spacing_mm - slice.spacing_mm).cwiseAbs().maxCoeff() >= kAlike)
    return "it has another spacing than the other slices of its series";
  if (!fit_together(other, slice)) return "it is turned against the other slices of its series";
  return "it is of another acquisition than the other slices of its series, and lies among them";
}

void note_left_out(const LeftOut& left_out, const std::string& where) {
  for (const auto& [reason, names] : left_out) {
    say_note(std::to_string(names.size()) + " of " + where + " left out, because " + reason + ": " +
             some_of(names));
  }
}

std::string title_of(const DicomSeries& series, std::size_t number) {
  return std::to_string(number) + ": \"" + series.front().series_description + "\" with " +
         std::to_string(series.size()) + " slices";
}

std::string list_of(const std::vector<DicomSeries>& all) {
  std::string list;
  for (std::size_t i = 0; i < all.size(); ++i)
    list += (i == 0 ? "" : ", ") + title_of(all[i], i + 1);
  return list;
}

}  // namespace

Result<FoundSeries> find_series(const StudyFiles& files, const std::string& where) {
  LeftOut left_out;
  std::vector<DamagedFile> damaged;
  auto gathered = gather(files, left_out, damaged);
  std::vector<DicomSeries> whole;
  for (auto& series : gathered) {
    sort_along_normal(series);
    if (shares_places(series)) drop_copies(series, files, left_out);
    if (!shares_places(series) && !acquisitions_overlap(series)) {
      whole.push_back(std::move(series));
      continue;
    }
    for (auto& part : by_acquisition(std::move(series))) whole.push_back(std::move(part));
  }
  std::vector<DicomSeries> usable;
  for (const auto& series : whole) {
    if (series.size() >= kMinSlices) {
      usable.push_back(series);
      continue;
    }
    for (const auto& slice : series) left_out[reason_for_few(series, whole)].push_back(slice.name);
  }
  note_left_out(left_out, where);
  std::sort(usable.begin(), usable.end(), [](const DicomSeries& a, const DicomSeries& b) {
    const auto key = [](const DicomSeries& series) {
      const auto& first = series.front();
      return std::tie(first.series_number, first.series_uid, first.acquisition_number, first.name);
    };
    return key(a) < key(b);
  });
  if (!usable.empty()) return FoundSeries{std::move(usable), std::move(damaged)};
  if (!damaged.empty()) return tl::unexpected<Error>(damaged.front().error);
  if (left_out.empty() || (left_out.size() == 1 && left_out.contains("it is no DICOM file")))
    return make_error(ErrorCode::kUnsupported, where + " holds no DICOM file with a slice");
  left_out.erase("it is no DICOM file");
  return make_error(ErrorCode::kUnsupported,
                    where + " holds no CT series of " + std::to_string(kMinSlices) +
                        " or more slices: " + left_out.begin()->second.front() +
                        " is of no use, because " + left_out.begin()->first);
}

Result<DicomSeries> choose_series(std::vector<DicomSeries> all,
                                  const std::string& wanted,
                                  const std::string& where) {
  if (wanted.empty() && all.size() == 1) return std::move(all.front());
  if (wanted.empty()) {
    return make_error(
        ErrorCode::kUnsupported,
        where + " holds several CT series (" + list_of(all) + "): choose one with --series");
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& first = all[i].front();
    if (wanted == std::to_string(i + 1) || wanted == first.series_uid) return std::move(all[i]);
  }
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (printable_text(wanted) == printable_text(all[i].front().series_description))
      named.push_back(i);
  if (named.size() == 1) return std::move(all[named.front()]);
  return make_error(ErrorCode::kInvalidArgument,
                    where + " holds " + (named.empty() ? "no" : "more than one") + " series \"" +
                        wanted + "\", but " + list_of(all));
}

Result<void> leave_out_damaged(const std::vector<DamagedFile>& damaged, const DicomSeries& series) {
  std::vector<std::string> names;
  for (const auto& file : damaged) {
    if (file.series_uid.empty() || file.series_uid == series.front().series_uid)
      return tl::unexpected<Error>(file.error);
    names.push_back(file.name);
  }
  if (!names.empty()) {
    say_note(std::to_string(names.size()) +
             " damaged file(s) of other series left out: " + some_of(names));
  }
  return {};
}

SliceStack stack_of(const DicomSeries& series) {
  SliceStack stack;
  const auto& first = series.front();
  stack.columns = first.columns;
  stack.rows = first.rows;
  stack.spacing_mm = first.spacing_mm;
  stack.axes = *first.axes;
  for (const auto& slice : series) {
    stack.origins_mm.push_back(*slice.position_mm);
    stack.names.push_back(slice.name);
  }
  return stack;
}

void leave_out_strays(DicomSeries& series) {
  constexpr double kLeastShare = 0.8;
  const Eigen::Vector3d normal = series.front().normal();
  std::size_t start = 0;
  std::pair<std::size_t, std::size_t> longest;
  for (std::size_t k = 1; k <= series.size(); ++k) {
    const bool ends = k == series.size() ||
                      height_of(series[k], normal) - height_of(series[k - 1], normal) > kMaxGapMm;
    if (!ends) continue;
    if (k - start > longest.second - longest.first) longest = {start, k};
    start = k;
  }
  const std::size_t num_kept = longest.second - longest.first;
  if (num_kept == series.size() || num_kept < kMinSlices ||
      static_cast<double>(num_kept) < kLeastShare * static_cast<double>(series.size()))
    return;
  std::vector<std::string> names;
  DicomSeries kept;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (k >= longest.first && k < longest.second) {
      kept.push_back(std::move(series[k]));
    } else {
      names.push_back(series[k].name);
    }
  }
  say_note(std::to_string(names.size()) +
           " slice(s) left out, because they lie far away from the others: " + some_of(names));
  series = std::move(kept);
}

}  // namespace mor::import
