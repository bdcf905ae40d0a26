// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/shown_picture.h"

#include <nlohmann/json.hpp>

#include "morgagni/session/evidence_json.h"

namespace mor {
using Json = nlohmann::ordered_json;

std::string picture_json(const ShownPicture& shown, const std::string& marks) {
  Json json = {{"frame_id", shown.tracked.frame->frame_id},
               {"state", to_string(shown.tracked.state)},
               {"held", shown.tracked.is_held},
               {"frozen", shown.is_still},
               {"picture", shown.is_free ? "free" : "camera"},
               {"bound_mm", shown.bound_mm ? Json(*shown.bound_mm) : Json(nullptr)},
               {"ct_from_camera", nullptr},
               {"marks", Json::array()}};
  if (shown.camera_from_ct)
    json["ct_from_camera"] = evidence::to_json(shown.camera_from_ct->inverse());
  if (!marks.empty()) json["marks"] = Json::parse(marks, nullptr, /*allow_exceptions=*/false);
  return json.dump();
}

}  // namespace mor
