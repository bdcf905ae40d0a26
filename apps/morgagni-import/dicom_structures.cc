// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_structures.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "contour_fill.h"
#include "dicom_file.h"
#include "messages.h"
#include "sandbox.h"
#include "study_files.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPoints = 5'000'000;
constexpr std::size_t kMostStructures = 200;

/// A structure of the set that has closed contours.
struct Roi {
  int number = 0;
  std::string name;
  std::array<double, 3> color{0.8, 0.7, 0.5};
  const DicomElement* contours = nullptr;
};

int number_of(const DicomDataSet& data, Tag tag) {
  const auto numbers = data.numbers(tag);
  return numbers.size() == 1 && std::abs(numbers[0]) < 1e9 ? static_cast<int>(numbers[0]) : -1;
}

bool is_closed(const DicomDataSet& contour) {
  return contour.text(Tag::kContourType) == "CLOSED_PLANAR";
}

std::string name_of(const DicomDataSet& data, int number) {
  const auto* all = data.find(Tag::kStructureRois);
  if (all != nullptr) {
    for (const auto& item : all->items)
      if (number_of(item, Tag::kRoiNumber) == number && !item.text(Tag::kRoiName).empty())
        return item.text(Tag::kRoiName);
  }
  return "structure " + std::to_string(number);
}

/// Those that have closed contours, in the set's order. The rest is named in a note.
std::vector<Roi> rois_of(const DicomDataSet& data) {
  std::vector<Roi> rois;
  std::vector<std::string> left_out;
  const auto* all = data.find(Tag::kRoiContours);
  if (all == nullptr) return rois;
  for (const auto& item : all->items) {
    Roi roi;
    roi.number = number_of(item, Tag::kReferencedRoi);
    roi.name = name_of(data, roi.number);
    roi.contours = item.find(Tag::kContours);
    if (const auto color = item.numbers(Tag::kRoiColor); color.size() == 3)
      for (std::size_t i = 0; i < 3; ++i) roi.color[i] = std::clamp(color[i] / 255.0, 0.0, 1.0);
    const bool has_contours =
        roi.contours != nullptr &&
        std::any_of(roi.contours->items.begin(), roi.contours->items.end(), is_closed);
    if (has_contours && rois.size() < kMostStructures) {
      rois.push_back(roi);
    } else {
      left_out.push_back(roi.name);
    }
  }
  if (!left_out.empty())
    say_note(std::to_string(left_out.size()) +
             " structure(s) left out, because they have no closed contours: " + some_of(left_out));
  return rois;
}

/// @param name  Of the structure, for sentences.
Result<void> check_contour(const std::vector<double>& numbers, const std::string& name) {
  constexpr double kFarthestMm = 1e5;
  if (numbers.size() % 3 != 0 || numbers.size() < 9) {
    return make_error(ErrorCode::kIo,
                      name + " has a damaged contour: " + std::to_string(numbers.size()) +
                          " numbers, of three or more points it would be a multiple of 3");
  }
  const auto far = std::find_if(numbers.begin(), numbers.end(), [](double number) {
    return !(std::abs(number) <= kFarthestMm);
  });
  if (far == numbers.end()) return {};
  return make_error(ErrorCode::kIo,
                    name + " has a damaged contour: one of its points has the coordinate " +
                        short_text(*far) + " mm, the limit is 100000");
}

Result<std::vector<Contour>> contours_of(const Roi& roi, const std::string& name) {
  std::vector<Contour> contours;
  std::size_t num_points = 0;
  for (const auto& item : roi.contours->items) {
    if (!is_closed(item)) continue;
    const auto numbers = item.numbers(Tag::kContourData);
    MOR_CHECK(check_contour(numbers, name));
    num_points += numbers.size() / 3;
    if (num_points > kMostPoints) {
      return make_error(ErrorCode::kInvalidArgument,
                        name + " has more than " + std::to_string(kMostPoints) +
                            " contour points, which is the limit");
    }
    Contour contour;
    for (std::size_t i = 0; i < numbers.size(); i += 3)
      contour.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    contours.push_back(std::move(contour));
  }
  return contours;
}

/// The bytes stay where the parsed file points to.
struct OpenedSet {
  std::string name;
  FileBytes bytes;
  DicomFile file;
};

Result<OpenedSet> find_set(const fs::path& path) {
  MOR_TRY(const auto files, open_study(path));
  for (std::size_t i = 0; i < files->size(); ++i) {
    auto loaded = files->load(i);
    if (!loaded) continue;
    OpenedSet set;
    set.bytes = *std::move(loaded);
    auto parsed = parse_dicom(set.bytes.bytes);
    if (!parsed || parsed->data.text(Tag::kModality) != "RTSTRUCT") continue;
    set.name = files->name(i);
    say_file(set.name);
    set.file = *std::move(parsed);
    return set;
  }
  return make_error(ErrorCode::kUnsupported, path.string() + " holds no RT Structure Set");
}

}  // namespace

bool holds_structure_set(const fs::path& path) {
  return find_set(path).has_value();
}

Result<void> import_dicom_structures(const fs::path& path, const std::string& wanted) {
  MOR_TRY(const auto set, find_set(path));
  const auto rois = rois_of(set.file.data);
  if (rois.empty())
    return make_error(ErrorCode::kUnsupported,
                      path.string() + " holds no structure with closed contours");
  say_num_maps(rois.size());
  std::size_t number = 1;
  if (!wanted.empty()) {
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error != std::errc() || number < 1 || number > rois.size())
      return make_error(ErrorCode::kInvalidArgument,
                        path.string() + " has no structure \"" + wanted + "\"");
  }
  const Roi& roi = rois[number - 1];
  const std::string name = set.name + ": the structure " + roi.name;
  MOR_TRY(const auto contours, contours_of(roi, name));
  MOR_TRY(const auto stack, stack_of(contours, name));
  MOR_TRY(const ImportHeader header, grid_of(stack, name));
  MOR_TRY(const auto voxels, open_voxels(header));
  allow_memory(voxels.size_bytes());
  fill(stack, header, static_cast<std::int16_t>(number), voxels);
  say_label(static_cast<int>(number), roi.color, roi.name);
  return {};
}

}  // namespace mor::import
