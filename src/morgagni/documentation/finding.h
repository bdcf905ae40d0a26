// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace mor {

enum class FindingKind : std::uint8_t {
  kPoint,     ///< A place on the skin or inside.
  kDistance,  ///< The straight way between two places.
  kGeodesic,  ///< The shortest way between two places over the skin.
};

/// A place of a finding, and how sure it is.
struct FindingPoint {
  Eigen::Vector3d ct_mm = Eigen::Vector3d::Zero();
  bool is_on_skin = true;
  std::optional<double> bound_mm;  ///< 95 % error bound of the pose there when it was tapped. None:
                                   ///< not known.
};

/// Something that somebody marked on the body. It stays where it is in the CT.
struct Finding {
  std::string id;  ///< "F1", "F2", ... in the order of their making; never used twice in a case.
  FindingKind kind = FindingKind::kPoint;
  std::string note;                         ///< In the user's words; UTF-8.
  std::vector<FindingPoint> points;         ///< One, or two of a measurement.
  std::vector<Eigen::Vector3d> path_ct_mm;  ///< kGeodesic: the way over the skin, ends included.
  std::optional<double> length_mm;          ///< Of a measurement,
  std::optional<double> length_bound_mm;    ///< and its uncertainty (95 %). None: not known.
  std::string created_at;                   ///< UTC, ISO 8601: "2026-11-26T16:20:05Z".
  std::string photo;  ///< File name of the picture's crop beside findings.json; empty: none.
};

}  // namespace mor
