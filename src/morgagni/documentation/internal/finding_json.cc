// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/finding_json.h"

#include <nlohmann/json.hpp>

#include "morgagni/documentation/findings_io.h"

namespace mor::internal {
namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

}  // namespace

Json to_json(const Finding& finding) {
  Json points = Json::array();
  for (const auto& point : finding.points)
    points.push_back({{"ct_mm", to_json(point.ct_mm)},
                      {"on_skin", point.is_on_skin},
                      {"bound_mm", or_null(point.bound_mm)}});
  Json path = Json::array();
  for (const auto& p : finding.path_ct_mm) path.push_back(to_json(p));
  return {{"id", finding.id},
          {"kind", to_string(finding.kind)},
          {"note", finding.note},
          {"points", points},
          {"path_ct_mm", path},
          {"length_mm", or_null(finding.length_mm)},
          {"length_bound_mm", or_null(finding.length_bound_mm)},
          {"created_at", finding.created_at},
          {"photo", finding.photo}};
}

}  // namespace mor::internal
