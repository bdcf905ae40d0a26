// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/pick.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "morgagni/render/internal/slice_layer.h"
#include "morgagni/render/internal/transfer_table.h"

namespace mor {
namespace {

using Eigen::Vector3d;

constexpr float kLeastOpacity = 0.05F;  ///< What is paler is not what a finger means.
constexpr const char* kSkinName = "skin";

/// From the camera, frame ct; a step of 1 goes 1 mm along the camera's z.
struct Ray {
  Vector3d start;
  Vector3d direction;

  [[nodiscard]] Vector3d at(double z_mm) const { return start + z_mm * direction; }
};

struct Hit {
  double z_mm = std::numeric_limits<double>::infinity();
  PickedPoint point;
};

/// The nearest crossing behind `from_z_mm` (Moller & Trumbore 1997).
void hit_mesh(const TriangleMesh& mesh, const Ray& ray, double from_z_mm, Hit& nearest) {
  const auto vertex = [&mesh](std::uint32_t i) {
    return Vector3d(mesh.vertices[i].cast<double>());
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d ab = vertex(b) - vertex(a);
    const Vector3d ac = vertex(c) - vertex(a);
    const Vector3d across = ray.direction.cross(ac);
    const double determinant = ab.dot(across);
    if (determinant == 0.0) continue;
    const Vector3d from_a = ray.start - vertex(a);
    const double u = from_a.dot(across) / determinant;
    if (u < 0.0 || u > 1.0) continue;
    const Vector3d other = from_a.cross(ab);
    const double v = ray.direction.dot(other) / determinant;
    const double z_mm = ac.dot(other) / determinant;
    if (v < 0.0 || u + v > 1.0 || z_mm < from_z_mm || z_mm >= nearest.z_mm) continue;
    nearest.z_mm = z_mm;
    nearest.point.ct_mm = ray.at(z_mm);
    nearest.point.facing = std::abs(ab.cross(ac).normalized().dot(ray.direction.normalized()));
  }
}

/// HU of the voxel around a point; kOutsideHu beside the grid.
std::int16_t hu_at(const Volume& volume, const Vector3d& ct_mm) {
  const Vector3d voxel =
      (volume.ct_from_grid.inverse() * ct_mm).cwiseQuotient(volume.spacing_mm).array().round();
  for (int axis = 0; axis < 3; ++axis) {
    if (!(voxel[axis] >= 0.0 && voxel[axis] <= volume.size[static_cast<std::size_t>(axis)] - 1))
      return kOutsideHu;
  }
  const Eigen::Vector3i at = voxel.cast<int>();
  return volume.hu[volume.index(at.x(), at.y(), at.z())];
}

bool is_in_hole(const Hole& hole, const PinholeCamera& camera, const Eigen::Vector2d& pixel) {
  if (hole.radius >= 2.0F) return true;
  const Eigen::Vector2d center((hole.center.x() * camera.width_px) - 0.5,
                               (hole.center.y() * camera.height_px) - 0.5);
  return (pixel - center).norm() < static_cast<double>(hole.radius) * camera.height_px;
}

/// z of the skin at the middle of the hole, from which the camera's slice counts; 0: none there.
double skin_z_mm(const RenderScene& scene, const OverlayView& view, const Vector3d& eye) {
  const auto& camera = view.color_camera;
  const Eigen::Vector2d center((view.hole.center.x() * camera.width_px) - 0.5,
                               (view.hole.center.y() * camera.height_px) - 0.5);
  Hit hit;
  const Vector3d direction =
      view.color_from_ct->linear().transpose() * camera.ray(center).homogeneous();
  hit_mesh(scene.skin, {eye, direction}, 1.0, hit);
  return std::isfinite(hit.z_mm) ? hit.z_mm : 0.0;
}

/// The slice, where the body is in it. @return z of its plane on the ray, before which a slice that
/// cuts leaves nothing; infinite: the ray never meets it; 0: there is no slice.
double hit_slice(const RenderScene& scene, const OverlayView& view, const Ray& ray, Hit& nearest) {
  if (!scene.volume || view.slice.plane == SlicePlane::kNone) return 0.0;
  const auto plane = internal::slice_plane(
      view.slice, *scene.volume, *view.color_from_ct, skin_z_mm(scene, view, ray.start));
  const Vector3d in_camera = view.color_from_ct->linear() * ray.direction;
  const double slope = plane->normal().dot(in_camera);
  const double z_mm = -plane->offset() / slope;
  if (std::abs(slope) < 1e-6 || z_mm < 0.0) return std::numeric_limits<double>::infinity();
  const bool is_seen =
      view.slice.opacity >= kLeastOpacity && hu_at(*scene.volume, ray.at(z_mm)) != kOutsideHu;
  if (is_seen && z_mm < nearest.z_mm) {
    nearest = {z_mm, {ray.at(z_mm), PickedThing::kSlice, "", 1.0}};
  }
  return z_mm;
}

void hit_structures(const RenderScene& scene,
                    const OverlayView& view,
                    const Ray& ray,
                    double from_z_mm,
                    Hit& nearest) {
  for (const auto& structure : scene.structures) {
    const auto look = view.structure_opacity.find(structure.name);
    const float opacity = look == view.structure_opacity.end() ? 1.0F : look->second;
    if (opacity < kLeastOpacity || structure.name == kSkinName) continue;
    Hit hit{.z_mm = nearest.z_mm, .point = {}};
    hit_mesh(structure.mesh, ray, from_z_mm, hit);
    if (hit.z_mm >= nearest.z_mm) continue;
    nearest = hit;
    nearest.point.thing = PickedThing::kStructure;
    nearest.point.structure = structure.name;
  }
}

/// Where the ray has lost half of its light in the volume.
void hit_volume(const RenderScene& scene,
                const OverlayView& view,
                const Ray& ray,
                double from_z_mm,
                Hit& nearest) {
  if (!scene.volume || view.volume.preset == VolumePreset::kNone) return;
  constexpr double kStepMm = 0.5;
  const auto table = internal::make_transfer_table(view.volume, static_cast<float>(kStepMm));
  const auto box = scene.skin.bounds();
  const double far_z_mm = std::min(
      nearest.z_mm, (box.center().cast<double>() - ray.start).norm() + box.diagonal().norm());
  const double step_z_mm = kStepMm / ray.direction.norm();
  double light = 1.0;
  for (double z_mm = from_z_mm; z_mm < far_z_mm; z_mm += step_z_mm) {
    const std::int16_t hu = hu_at(*scene.volume, ray.at(z_mm));
    if (hu == kOutsideHu) continue;
    const int entry =
        std::clamp<int>(hu, internal::TransferTable::kLeastHu, internal::TransferTable::kMostHu) -
        internal::TransferTable::kLeastHu;
    light *= 1.0 - static_cast<double>(table.opacity[static_cast<std::size_t>(entry)]);
    if (light > 0.5) continue;
    nearest = {z_mm, {ray.at(z_mm), PickedThing::kVolume, "", 1.0}};
    return;
  }
}

}  // namespace

std::optional<PickedPoint> pick_point(const RenderScene& scene,
                                      const OverlayView& view,
                                      const Eigen::Vector2d& pixel) {
  const auto& camera = view.color_camera;
  const bool is_inside = pixel.x() >= -0.5 && pixel.y() >= -0.5 &&
                         pixel.x() <= camera.width_px - 0.5 && pixel.y() <= camera.height_px - 0.5;
  if (!view.color_from_ct || !is_inside) return std::nullopt;
  const Eigen::Isometry3d ct_from_color = view.color_from_ct->inverse();
  const Ray ray{ct_from_color.translation(),
                ct_from_color.linear() * camera.ray(pixel).homogeneous()};
  Hit nearest;
  if (view.opacity >= kLeastOpacity && is_in_hole(view.hole, camera, pixel)) {
    const double slice_z_mm = hit_slice(scene, view, ray, nearest);
    const double from_z_mm = view.slice.cuts ? std::max(1.0, slice_z_mm) : 1.0;
    hit_structures(scene, view, ray, from_z_mm, nearest);
    hit_volume(scene, view, ray, from_z_mm, nearest);
  }
  if (!std::isfinite(nearest.z_mm)) hit_mesh(scene.skin, ray, 1.0, nearest);
  if (!std::isfinite(nearest.z_mm)) return std::nullopt;
  return nearest.point;
}

}  // namespace mor
