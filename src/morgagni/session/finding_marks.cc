// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/finding_marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/documentation/findings_io.h"

namespace mor {
namespace {

using Json = nlohmann::json;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// What hides a finding is looked for on a coarse picture, and not for each picture anew: it
/// changes slowly, and only how bright a mark is depends on it.
constexpr double kRasterScale = 0.25;
constexpr std::chrono::milliseconds kRasterPeriod{150};
constexpr double kHiddenBehindMm = 8.0;
/// A way over the skin is drawn with fewer points, so far from the true ones at most.
constexpr double kLineToleranceMm = 0.5;
constexpr std::size_t kMaxLinePoints = 80;
constexpr double kMarginPx = 30.0;  ///< So far beside the picture a mark may still reach into it.

double distance_to_line(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length_sq = ab.squaredNorm();
  const double share = length_sq > 0.0 ? std::clamp((p - a).dot(ab) / length_sq, 0.0, 1.0) : 0.0;
  return (p - a - share * ab).norm();
}

/// Douglas & Peucker (1973): no dropped point is farther than the tolerance from what is left.
std::vector<Vector3d> simplified(const std::vector<Vector3d>& path, double tolerance_mm) {
  if (path.size() < 3) return path;
  std::vector<bool> is_kept(path.size(), false);
  is_kept.front() = is_kept.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> stretches = {{0, path.size() - 1}};
  while (!stretches.empty()) {
    const auto [first, last] = stretches.back();
    stretches.pop_back();
    std::size_t farthest = first;
    double most_mm = tolerance_mm;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance_mm = distance_to_line(path[i], path[first], path[last]);
      if (distance_mm > most_mm) {
        most_mm = distance_mm;
        farthest = i;
      }
    }
    if (farthest == first) continue;
    is_kept[farthest] = true;
    stretches.emplace_back(first, farthest);
    stretches.emplace_back(farthest, last);
  }
  std::vector<Vector3d> kept;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (is_kept[i]) kept.push_back(path[i]);
  }
  return kept;
}

std::vector<Vector3d> line_of(const Finding& finding) {
  if (finding.kind == FindingKind::kPoint) return {};
  if (finding.kind == FindingKind::kDistance) {
    return {finding.points.front().ct_mm, finding.points.back().ct_mm};
  }
  double tolerance_mm = kLineToleranceMm;
  auto line = simplified(finding.path_ct_mm, tolerance_mm);
  while (line.size() > kMaxLinePoints) {
    tolerance_mm *= 2.0;
    line = simplified(finding.path_ct_mm, tolerance_mm);
  }
  return line;
}

/// Tenths of a pixel are enough, and short.
double rounded(double px) {
  return std::round(px * 10.0) / 10.0;
}

}  // namespace

std::string length_label(double length_mm, const std::optional<double>& bound_mm) {
  return bound_mm ? fmt::format("{:.1f} mm ± {:.1f} mm", length_mm, *bound_mm)
                  : fmt::format("{:.1f} mm", length_mm);
}

FindingMarks::FindingMarks(std::shared_ptr<const TriangleMesh> skin) : skin_(std::move(skin)) {}

void FindingMarks::set(const std::vector<Finding>& findings,
                       const std::vector<FindingPoint>& picks) {
  std::vector<Mark> marks;
  // The newest are what the user works on.
  for (auto finding = findings.rbegin(); finding != findings.rend() && marks.size() < kMaxMarks;
       ++finding) {
    Mark mark{.id = finding->id,
              .kind = std::string(to_string(finding->kind)),
              .label = finding->length_mm
                           ? length_label(*finding->length_mm, finding->length_bound_mm)
                           : std::string(),
              .places = {},
              .line = {}};
    for (const auto& point : finding->points)
      mark.places.push_back({point.ct_mm, point.is_on_skin});
    const bool is_on_skin = finding->kind == FindingKind::kGeodesic ||
                            std::all_of(finding->points.begin(),
                                        finding->points.end(),
                                        [](const FindingPoint& point) { return point.is_on_skin; });
    for (const auto& place : line_of(*finding)) mark.line.push_back({place, is_on_skin});
    marks.push_back(std::move(mark));
  }
  for (const auto& pick : picks)
    marks.push_back({.id = "",
                     .kind = "pick",
                     .label = "",
                     .places = {{pick.ct_mm, pick.is_on_skin}},
                     .line = {}});
  const std::lock_guard lock(mutex_);
  marks_ = std::move(marks);
}

std::string FindingMarks::json(const ShownPicture& shown) {
  const std::lock_guard lock(mutex_);
  if (marks_.empty() || !shown.camera_from_ct) return {};
  look(shown);
  Json list = Json::array();
  const auto& camera = shown.camera;
  // Undistorted far beside the picture, a lens model says anything.
  const auto is_near = [&camera](const Vector2d& pixel) {
    return pixel.x() > -kMarginPx && pixel.y() > -kMarginPx &&
           pixel.x() < camera.width_px + kMarginPx && pixel.y() < camera.height_px + kMarginPx;
  };
  const auto placed = [&](const std::vector<Place>& places) {
    Json points = Json::array();
    for (const auto& place : places) {
      const auto pixel = camera.project(*shown.camera_from_ct * place.ct_mm);
      if (!pixel || !is_near(*pixel)) continue;
      points.push_back(
          {rounded(pixel->x()), rounded(pixel->y()), is_dim(place, *pixel, shown) ? 1 : 0});
    }
    return points;
  };
  for (const auto& mark : marks_) {
    Json points = placed(mark.places);
    Json line = placed(mark.line);
    if (points.empty() && line.empty()) continue;
    list.push_back({{"id", mark.id},
                    {"kind", mark.kind},
                    {"label", mark.label},
                    {"points", std::move(points)},
                    {"line", std::move(line)}});
  }
  return list.dump();
}

void FindingMarks::look(const ShownPicture& shown) {
  const auto now = Clock::now();
  const bool is_fresh = seen_ && now - seen_->made_at < kRasterPeriod;
  if (is_fresh) return;
  PinholeCamera camera = shown.camera.scaled(kRasterScale);
  camera.distortion = {};
  seen_ = Seen{.raster = rasterize_depth(*skin_, camera, *shown.camera_from_ct),
               .camera = camera,
               .camera_from_ct = *shown.camera_from_ct,
               .made_at = now};
}

bool FindingMarks::is_hidden(const Vector3d& ct_mm) const {
  const Vector3d point = seen_->camera_from_ct * ct_mm;
  const auto pixel = seen_->camera.project(point);
  if (!pixel) return false;
  // The farthest of the pixels around: at an edge, what is just behind it is not hidden.
  double seen_mm = 0.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      const int px = static_cast<int>(std::lround(pixel->x())) + x;
      const int py = static_cast<int>(std::lround(pixel->y())) + y;
      if (!seen_->raster.depth_mm.view().contains(px, py)) return false;
      const double depth_mm = static_cast<double>(seen_->raster.depth_mm(px, py));
      if (depth_mm == 0.0) return false;
      seen_mm = std::max(seen_mm, depth_mm);
    }
  }
  return point.z() > seen_mm + kHiddenBehindMm;
}

bool FindingMarks::is_dim(const Place& place,
                          const Vector2d& pixel,
                          const ShownPicture& shown) const {
  if (place.is_on_skin) return is_hidden(place.ct_mm);
  const auto& [center, radius, rim] = shown.view.hole;
  if (radius >= 2.0F) return false;
  const Vector2d middle(center.x() * shown.camera.width_px, center.y() * shown.camera.height_px);
  return (pixel - middle).norm() > static_cast<double>(radius) * shown.camera.height_px;
}

}  // namespace mor
