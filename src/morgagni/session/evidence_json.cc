// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/evidence_json.h"

#include <algorithm>

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/core/utc.h"
#include "morgagni/core/version.h"

namespace mor::evidence {

using std::chrono::system_clock;

Json head(const Case& body) {
  return {{"case", body.name},
          {"ct", body.ct_description},
          {"ct_voxels_sha256", body.ct_voxels_sha256},
          {"made_by", fmt::format("Morgagni {}", kVersion)},
          {"notice", kNotice}};
}

Json to_json(const PinholeCamera& camera) {
  return {{"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"focal_px", {camera.focal_x_px, camera.focal_y_px}},
          {"center_px", {camera.center_x_px, camera.center_y_px}},
          {"distortion", camera.distortion}};
}

Json to_json(const RgbdCalibration& calibration) {
  Json json = {{"depth", to_json(calibration.depth)},
               {"color", to_json(calibration.color)},
               {"color_from_depth", to_json(calibration.color_from_depth)}};
  if (!calibration.origin.empty()) json["origin"] = calibration.origin;
  if (calibration.depth_correction) {
    json["depth_correction"] = Json::parse(depth_correction_to_json(*calibration.depth_correction));
  }
  return json;
}

std::string skin_words(const std::shared_ptr<const FixedSurface>& skin) {
  if (!skin || skin->change.empty()) return "the CT's skin";
  return "the skin " + skin->change;
}

Json to_json(const Eigen::Isometry3d& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(pose(row, column));
  }
  return rows;
}

system_clock::time_point wall_clock(std::chrono::steady_clock::time_point time) {
  return system_clock::now() - std::chrono::duration_cast<system_clock::duration>(
                                   std::chrono::steady_clock::now() - time);
}

std::string file_name(system_clock::time_point time) {
  std::string name = utc_text(time);
  std::replace(name.begin(), name.end(), ':', '-');
  return name;
}

}  // namespace mor::evidence
