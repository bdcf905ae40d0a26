// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/structure_set_writer.h"

#include <spdlog/fmt/fmt.h>

namespace mor::testing_dicom {
namespace {

std::string numbers_of(const std::vector<Eigen::Vector3d>& places) {
  std::string text;
  for (const auto& place : places)
    text += fmt::format(
        "{}{:.3f}\\{:.3f}\\{:.3f}", text.empty() ? "" : "\\", place.x(), place.y(), place.z());
  return text;
}

}  // namespace

std::string structure_set_file(const std::vector<RoiText>& rois,
                               const std::string& other_data,
                               const char* transfer_syntax) {
  std::vector<std::string> names;
  std::vector<std::string> contours;
  for (std::size_t i = 0; i < rois.size(); ++i) {
    DicomWriter name(transfer_syntax);
    name.text(0x3006'0022, "IS", std::to_string(i + 7));
    name.text(0x3006'0026, "LO", rois[i].name);
    names.push_back(name.data());
    std::vector<std::string> items;
    for (const auto& contour : rois[i].contours) {
      DicomWriter item(transfer_syntax);
      item.text(0x3006'0042, "CS", contour.type);
      item.text(0x3006'0050, "DS", other_data.empty() ? numbers_of(contour.places) : other_data);
      items.push_back(item.data());
    }
    DicomWriter roi(transfer_syntax);
    roi.text(0x3006'002a, "IS", "255\\0\\51");
    roi.sequence(0x3006'0040, items);
    roi.text(0x3006'0084, "IS", std::to_string(i + 7));
    contours.push_back(roi.data());
  }
  DicomWriter out(transfer_syntax);
  out.text(0x0008'0060, "CS", "RTSTRUCT");
  out.sequence(0x3006'0020, names);
  out.sequence(0x3006'0039, contours);
  return out.file();
}

}  // namespace mor::testing_dicom
