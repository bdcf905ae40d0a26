// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/documentation/finding.h"
#include "morgagni/geometry/depth_raster.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/session/shown_picture.h"

namespace mor {

/// "123.4 mm ± 2.1 mm"; without the bound where that is not known.
[[nodiscard]] std::string length_label(double length_mm, const std::optional<double>& bound_mm);

/// Where the findings are in a picture, for the page to draw them there.
class FindingMarks {
 public:
  /// As many as a picture carries; the rest is in the list alone.
  static constexpr std::size_t kMaxMarks = 200;

  /// @param skin  What can hide a finding. Shared, never changed.
  explicit FindingMarks(std::shared_ptr<const TriangleMesh> skin);

  /// What to mark from now on. @param picks  Points of a finding that is not made yet. Any thread.
  void set(const std::vector<Finding>& findings, const std::vector<FindingPoint>& picks);

  /// The marks of a picture as JSON (docs/http-api.md). One thread at a time.
  [[nodiscard]] std::string json(const ShownPicture& shown);

 private:
  using Clock = std::chrono::steady_clock;

  struct Place {
    Eigen::Vector3d ct_mm = Eigen::Vector3d::Zero();
    bool is_on_skin = true;
  };
  struct Mark {
    std::string id;
    std::string kind;
    std::string label;
    std::vector<Place> places;
    std::vector<Place> line;
  };
  struct Seen {
    DepthRaster raster;
    PinholeCamera camera;
    Eigen::Isometry3d camera_from_ct;
    Clock::time_point made_at;
  };

  void look(const ShownPicture& shown);
  [[nodiscard]] bool is_hidden(const Eigen::Vector3d& ct_mm) const;
  [[nodiscard]] bool is_dim(const Place& place,
                            const Eigen::Vector2d& pixel,
                            const ShownPicture& shown) const;

  std::shared_ptr<const TriangleMesh> skin_;
  std::mutex mutex_;
  std::vector<Mark> marks_;
  std::optional<Seen> seen_;  ///< Of json()'s thread.
};

}  // namespace mor
