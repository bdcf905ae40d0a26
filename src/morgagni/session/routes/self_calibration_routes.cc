// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/self_calibration_routes.h"

#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

using api::Json;

/// The correction over the picture in the middle of its distances, to be drawn.
Json map_of(const SelfCalibration& found) {
  const auto& correction = found.correction;
  const double at_mm = 0.5 * (correction.near_mm + correction.far_mm);
  const int width = found.depth.width_px;
  const int height = found.depth.height_px;
  Json values = Json::array();
  for (int row = 0; row < correction.rows; ++row) {
    for (int column = 0; column < correction.columns; ++column) {
      const Eigen::Vector2d pixel(column * (width - 1.0) / (correction.columns - 1),
                                  row * (height - 1.0) / (correction.rows - 1));
      values.push_back(correction.add_mm(pixel, width, height, at_mm));
    }
  }
  return {{"columns", correction.columns},
          {"rows", correction.rows},
          {"at_mm", at_mm},
          {"add_mm", values}};
}

Json found_json(const SelfCalibration& found) {
  const auto& held = found.held_out;
  const auto& gain = found.follows_skin && !found.corrects_sensor() ? held.skin : held.sensor;
  return {{"verdict", to_string(found.verdict)},
          {"corrects_sensor", found.corrects_sensor()},
          {"follows_skin", found.follows_skin},
          {"now_mm", found.now_mm()},
          {"shift_mm", found.shift_mm},
          {"remaining_mm", found.proposes() ? found.left_mm() : found.remaining_mm},
          {"views", found.num_views},
          {"sees_table", found.sees_table},
          {"parts_better", gain.num_better},
          {"parts", held.num_folds},
          {"significance", gain.significance},
          {"held_out_mm", {held.as_it_is_mm, held.skin_mm, held.sensor_mm, held.both_mm}},
          {"skin_mm", found.skin_rms_mm},
          {"skin_most_mm", found.skin_most_mm},
          {"skin_shift_mm", found.skin_shift_mm},
          {"focal_ratio", {found.focal_x_ratio, found.focal_y_ratio}},
          {"map", map_of(found)}};
}

Json applied_json(const AppliedCorrection& applied) {
  return {{"origin", applied.origin},
          {"corrects_sensor", applied.corrects_sensor},
          {"follows_skin", applied.follows_skin},
          {"skin_most_mm", applied.skin_most_mm},
          {"shift_mm", applied.shift_mm},
          {"remaining_mm", applied.remaining_mm},
          {"kept", !applied.kept_in.empty()},
          {"kept_in", applied.kept_in.empty() ? Json() : Json(applied.kept_in)}};
}

Json to_json(const SelfCalibratorStatus& status) {
  return {
      {"phase", to_string(status.phase)},
      {"views", status.num_views},
      {"wanted_views", status.wanted_views},
      {"views_in_part", status.coverage.views_in_part},
      {"missing", status.num_views > 0 ? status.coverage.missing() : std::vector<std::string>()},
      {"found", status.found ? found_json(*status.found) : Json()},
      {"applied", status.applied ? applied_json(*status.applied) : Json()},
      {"device", status.device_id.empty() ? Json() : Json(status.device_id)},
      {"problem", status.problem.empty() ? Json() : Json(status.problem)},
      {"view_ms", status.view_ms},
      {"found_s", status.found_s}};
}

}  // namespace

std::vector<HttpRoute> make_self_calibration_routes(std::shared_ptr<SelfCalibrator> calibrator) {
  const auto command = [=](const char* what, Result<void> (SelfCalibrator::*act)()) {
    return api::post(std::string("/api/self-calibration/") + what,
                     [=](const auto&) -> Result<Json> {
                       MOR_CHECK(((*calibrator).*act)());
                       return to_json(calibrator->status());
                     });
  };
  return {api::get("/api/self-calibration",
                   [=](const HttpRequest&) { return api::answer(to_json(calibrator->status())); }),
          command("apply", &SelfCalibrator::apply),
          command("discard", &SelfCalibrator::discard),
          command("undo", &SelfCalibrator::undo),
          api::post("/api/self-calibration/again", [=](const auto&) -> Result<Json> {
            calibrator->look_again();
            return to_json(calibrator->status());
          })};
}

}  // namespace mor
