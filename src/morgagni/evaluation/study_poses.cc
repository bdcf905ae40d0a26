// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/study_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <spdlog/fmt/fmt.h>

#include "morgagni/geometry/kd_tree.h"
#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastElevationRad = 40.0 * std::numbers::pi / 180.0;
constexpr double kNearestMm = 500.0;
constexpr double kFarthestMm = 850.0;
/// A reading this near to where a place should be shows the place, and nothing in front of it.
constexpr double kInSightMm = 15.0;
constexpr double kLeastFacing = 0.3;
constexpr int kMaxViewsPerPose = 400;
constexpr std::size_t kNumLandmarks = 4;

/// Box and Muller 1958: the standard library's normal distribution may differ between
/// implementations, this does not.
class NormalDraws {
 public:
  explicit NormalDraws(std::uint64_t seed) : random_(seed) {}
  double operator()(double sd) {
    const double u = unit();
    return sd * std::sqrt(-2.0 * std::log(1.0 - u)) * std::cos(2.0 * std::numbers::pi * unit());
  }
  Vector3d vector(double sd) {
    const double x = (*this)(sd);
    const double y = (*this)(sd);
    return {x, y, (*this)(sd)};
  }
  std::size_t choice(std::size_t count) { return random_() % count; }

 private:
  double unit() { return static_cast<double>(random_() >> 11U) * 0x1.0p-53; }
  std::mt19937_64 random_;
};

/// The reading at a pixel: the median of its 3 x 3 neighbourhood's.
std::optional<double> depth_at(const Image<std::uint16_t>& depth_mm, const Vector2d& pixel) {
  const auto x = static_cast<int>(std::lround(pixel.x()));
  const auto y = static_cast<int>(std::lround(pixel.y()));
  std::vector<std::uint16_t> readings;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (!depth_mm.view().contains(x + dx, y + dy)) continue;
      const auto z_mm = depth_mm(x + dx, y + dy);
      if (z_mm > 0) readings.push_back(z_mm);
    }
  }
  if (readings.empty()) return std::nullopt;
  std::nth_element(readings.begin(), readings.begin() + readings.size() / 2, readings.end());
  return readings[readings.size() / 2];
}

/// One view, as the study's person sees it.
struct View {
  const RgbdFrame& frame;
  const PinholeCamera& true_camera;
  Eigen::Isometry3d depth_from_ct;
  Vector3d eye_ct;

  /// Where a place of the skin appears; none where it is out of the picture, hidden, or seen at too
  /// flat an angle to be tagged.
  [[nodiscard]] std::optional<Vector2d> sight_of(const Vector3d& ct, const Vector3d& normal) const {
    if (normal.dot((eye_ct - ct).normalized()) < kLeastFacing) return std::nullopt;
    const Vector3d p = depth_from_ct * ct;
    const auto pixel = true_camera.project(p);
    if (!pixel) return std::nullopt;
    const auto z_mm = depth_at(frame.depth_mm, *pixel);
    if (!z_mm || std::abs(*z_mm - p.z()) > kInSightMm) return std::nullopt;
    return pixel;
  }
};

/// Tags in the colour picture and reads the depth there, with what the camera says of itself.
std::optional<Vector3d> tagged_in_picture(const View& view,
                                          const Vector2d& pixel,
                                          double error_px,
                                          NormalDraws& draw) {
  const double x_px = pixel.x() + draw(error_px);
  const double y_px = pixel.y() + draw(error_px);
  const auto z_mm = depth_at(view.frame.depth_mm, {x_px, y_px});
  if (!z_mm) return std::nullopt;
  const Vector2d ray = view.frame.calibration->depth.ray({x_px, y_px});
  return Vector3d(ray.x() * *z_mm, ray.y() * *z_mm, *z_mm);
}

/// A place of the skin and the skin's normal there.
struct SkinPlace {
  Vector3d ct;
  Vector3d normal;
};

std::vector<SkinPlace> on_skin(const std::vector<Target>& markers, const TriangleMesh& skin) {
  const KdTree vertices(skin.vertices);
  std::vector<SkinPlace> places;
  for (const auto& marker : markers) {
    const auto nearest = vertices.nearest(marker.ct.cast<float>());
    places.push_back({marker.ct, skin.normals[nearest.index].cast<double>()});
  }
  return places;
}

std::vector<TaggedMarker> tag_markers(const View& view,
                                      const std::vector<SkinPlace>& markers,
                                      const TaggingOptions& tagging,
                                      NormalDraws& draw) {
  struct Candidate {
    double off_center_px;
    TaggedMarker marker;
  };
  const auto& camera = view.true_camera;
  const Vector2d center(camera.center_x_px, camera.center_y_px);
  std::vector<Candidate> candidates;
  for (const auto& marker : markers) {
    const auto pixel = view.sight_of(marker.ct, marker.normal);
    if (!pixel) continue;
    const auto tagged = tagged_in_picture(view, *pixel, tagging.marker_px, draw);
    // Who tags sees when the reading is that of something else.
    const double expected_mm = (view.depth_from_ct * marker.ct).z();
    if (!tagged || std::abs(tagged->z() - expected_mm) > kInSightMm) continue;
    const Vector3d tagged_ct = marker.ct + draw.vector(tagging.marker_ct_mm);
    candidates.push_back({(*pixel - center).norm(), {marker.ct, tagged_ct, *tagged}});
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.off_center_px < b.off_center_px;
  });
  std::vector<TaggedMarker> nearest;
  for (std::size_t i = 0; i < std::min(candidates.size(), kMarkersUsed); ++i) {
    nearest.push_back(candidates[i].marker);
  }
  return nearest;
}

/// Four visible places of the skin, each as far from the others as can be.
std::vector<Vector3d> choose_landmarks(const View& view,
                                       const TriangleMesh& skin,
                                       NormalDraws& draw) {
  constexpr std::size_t kEvery = 7;
  std::vector<Vector3d> visible;
  for (std::size_t i = 0; i < skin.vertices.size(); i += kEvery) {
    const Vector3d at = skin.vertices[i].cast<double>();
    if (view.sight_of(at, skin.normals[i].cast<double>())) visible.push_back(at);
  }
  std::vector<Vector3d> chosen;
  if (visible.size() < kNumLandmarks) return chosen;
  chosen.push_back(visible[draw.choice(visible.size())]);
  while (chosen.size() < kNumLandmarks) {
    const auto apart_mm = [&](const Vector3d& at) {
      double least = std::numeric_limits<double>::infinity();
      for (const auto& other : chosen) least = std::min(least, (at - other).norm());
      return least;
    };
    chosen.push_back(*std::max_element(
        visible.begin(), visible.end(), [&](const Vector3d& a, const Vector3d& b) {
          return apart_mm(a) < apart_mm(b);
        }));
  }
  return chosen;
}

/// The paper's T_init: Horn's fit of four landmarks that a person picked by eye.
Result<Eigen::Isometry3d> start_from_landmarks(const View& view,
                                               const std::vector<Vector3d>& landmarks,
                                               double error_mm,
                                               NormalDraws& draw) {
  std::vector<Vector3d> picked;
  for (const auto& ct : landmarks)
    picked.push_back(view.depth_from_ct * ct + draw.vector(error_mm));
  return fit_rigid(landmarks, picked);
}

Result<double> fiducial_error_mm(const std::vector<TaggedMarker>& markers) {
  std::vector<Vector3d> fixed;
  std::vector<Vector3d> moving;
  for (const auto& marker : markers) {
    fixed.push_back(marker.tagged_ct);
    moving.push_back(marker.tagged_depth);
  }
  MOR_TRY(const Eigen::Isometry3d ct_from_depth, fit_rigid(fixed, moving));
  double squares = 0.0;
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    squares += (ct_from_depth * moving[i] - fixed[i]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(fixed.size()));
}

bool is_from_above(const Eigen::Isometry3d& ct_from_depth) {
  return ct_from_depth.linear()(1, 2) >= std::sin(kLeastElevationRad);
}

bool is_near_enough(const RgbdFrame& frame) {
  const auto center_mm =
      depth_at(frame.depth_mm, {0.5 * frame.depth_mm.width(), 0.5 * frame.depth_mm.height()});
  return center_mm && *center_mm >= kNearestMm && *center_mm <= kFarthestMm;
}

/// What the picture was truly taken with, an error of the stated focal length taken out.
PinholeCamera true_camera(const SimulatedCamera& camera, const SimulatedCameraOptions& options) {
  PinholeCamera pinhole = camera.calibration().depth;
  pinhole.focal_x_px /= 1.0 + 0.01 * options.focal_error_percent;
  pinhole.focal_y_px /= 1.0 + 0.01 * options.focal_error_percent;
  return pinhole;
}

}  // namespace

Result<std::vector<StudyPose>> draw_study_poses(const TriangleMesh& skin,
                                                const SimulatedCamera& camera,
                                                const SimulatedCameraOptions& camera_options,
                                                const std::vector<Target>& markers,
                                                const TaggingOptions& tagging,
                                                int num_poses) {
  const auto pinhole = true_camera(camera, camera_options);
  const auto places = on_skin(markers, skin);
  std::vector<StudyPose> poses;
  for (int view_id = 0; view_id < kMaxViewsPerPose * num_poses; ++view_id) {
    if (poses.size() == static_cast<std::size_t>(num_poses)) return poses;
    const auto id = static_cast<std::uint64_t>(view_id);
    StudyPose pose;
    pose.ct_from_depth = camera.ct_from_camera(id);
    if (!is_from_above(pose.ct_from_depth)) continue;
    pose.frame = camera.frame_at(id);
    if (!is_near_enough(*pose.frame)) continue;
    const View view{
        *pose.frame, pinhole, pose.ct_from_depth.inverse(), pose.ct_from_depth.translation()};
    NormalDraws draw(camera_options.seed * 1'000'003U + id);
    pose.markers = tag_markers(view, places, tagging, draw);
    const auto landmarks = choose_landmarks(view, skin, draw);
    if (pose.markers.size() < kMarkersUsed || landmarks.size() < kNumLandmarks) continue;
    MOR_TRY(pose.start, start_from_landmarks(view, landmarks, tagging.landmark_mm, draw));
    MOR_TRY(pose.fre_mm, fiducial_error_mm(pose.markers));
    poses.push_back(std::move(pose));
  }
  if (poses.size() == static_cast<std::size_t>(num_poses)) return poses;
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("only {} of {} views show {} of the {} markers",
                                poses.size(),
                                kMaxViewsPerPose * num_poses,
                                kMarkersUsed,
                                markers.size()));
}

}  // namespace mor
