// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/scene/table_things.h"

#include <cmath>

#include "morgagni/camera/internal/scene/sweep.h"

namespace mor::internal {
namespace {

using Eigen::Vector3f;

const Vector3f kSteel(168.0F, 174.0F, 180.0F);
const Vector3f kFoam(92.0F, 98.0F, 112.0F);

float between(Draws& draw, double least, double most) {
  return static_cast<float>(draw(least, most));
}

/// Each face with corners of its own, so that edges stay sharp. `half` along its own axes.
TriangleMesh block(const Vector3f& half) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      const Vector3f out = side * Vector3f::Unit(axis);
      const Vector3f across = Vector3f::Unit((axis + 1) % 3);
      const Vector3f up = out.cross(across);
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& [a, b] :
           {std::pair{-1.0F, -1.0F}, {1.0F, -1.0F}, {1.0F, 1.0F}, {-1.0F, 1.0F}}) {
        mesh.vertices.emplace_back(half.cwiseProduct(out + a * across + b * up));
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  return mesh;
}

/// At a place on the table, turned about the vertical; up is -y.
Eigen::Isometry3f standing(float x_mm, float z_mm, float table_top_mm, float turn_rad) {
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translation() = Vector3f(x_mm, table_top_mm, z_mm);
  pose.linear() = Eigen::AngleAxisf(turn_rad, Vector3f::UnitY()).toRotationMatrix();
  return pose;
}

/// A flat dish with a rim, and rods in it. Its own frame: the table is y = 0.
PaintedMesh tray(float half_x_mm, float half_z_mm, Draws& draw) {
  constexpr float kRimMm = 16.0F;
  PaintedMesh result;
  const auto add = [&](const Vector3f& half, const Vector3f& center, const Vector3f& albedo) {
    result.append(painted(block(half), albedo, 60.0F),
                  Eigen::Isometry3f(Eigen::Translation3f(center)));
  };
  add({half_x_mm, 2.0F, half_z_mm}, {0.0F, -2.0F, 0.0F}, kSteel);
  for (const float side : {-1.0F, 1.0F}) {
    add({1.5F, kRimMm, half_z_mm}, {side * half_x_mm, -kRimMm, 0.0F}, 0.9F * kSteel);
    add({half_x_mm, kRimMm, 1.5F}, {0.0F, -kRimMm, side * half_z_mm}, 0.9F * kSteel);
  }
  const auto num_rods = 2 + draw.choice(4);
  for (std::size_t i = 0; i < num_rods; ++i) {
    const float x_mm =
        half_x_mm * (-0.75F + 1.5F * static_cast<float>(i) / static_cast<float>(num_rods));
    const float length_mm = 0.7F * half_z_mm;
    const float slant_mm = between(draw, -8.0, 8.0);
    const float radius_mm = between(draw, 3.0, 7.0);
    const Vector3f end(x_mm + slant_mm, -4.0F - radius_mm, length_mm);
    const Vector3f begin(x_mm - slant_mm, -4.0F - radius_mm, -length_mm);
    result.append(painted(tube(begin, end, radius_mm, 0.6F * radius_mm), 1.1F * kSteel, 80.0F));
  }
  return result;
}

PaintedMesh bottle(Draws& draw) {
  const float radius_mm = between(draw, 22.0, 40.0);
  const float height_mm = between(draw, 70.0, 150.0);
  const Vector3f color(
      between(draw, 120.0, 240.0), between(draw, 120.0, 230.0), between(draw, 90.0, 220.0));
  PaintedMesh result =
      painted(tube(Vector3f::Zero(), {0.0F, radius_mm - height_mm, 0.0F}, radius_mm, radius_mm),
              color,
              50.0F);
  result.append(painted(tube({0.0F, 0.4F * radius_mm - height_mm, 0.0F},
                             {0.0F, -height_mm - 18.0F, 0.0F},
                             0.45F * radius_mm,
                             0.42F * radius_mm),
                        {235.0F, 235.0F, 235.0F},
                        40.0F));
  return result;
}

}  // namespace

PaintedMesh table_things(const Eigen::AlignedBox3f& body, float table_top_mm, Draws& draw) {
  const Vector3f half = 0.5F * body.sizes();
  const float side = draw(0.0, 1.0) < 0.5 ? -1.0F : 1.0F;
  const auto beside = [&](float which_side, float half_width_mm, float gap_mm) {
    return body.center().x() + which_side * (half.x() + gap_mm + half_width_mm);
  };
  const auto along = [&] { return body.center().z() + between(draw, -0.8, 0.1) * half.z(); };
  PaintedMesh things;
  const float tray_x_mm = between(draw, 45.0, 75.0);
  const float tray_z_mm = between(draw, 70.0, 120.0);
  things.append(tray(tray_x_mm, tray_z_mm, draw),
                standing(beside(side, tray_x_mm, between(draw, 15.0, 45.0)),
                         along(),
                         table_top_mm,
                         between(draw, -0.2, 0.2)));
  things.append(
      bottle(draw),
      standing(beside(-side, 40.0F, between(draw, 15.0, 60.0)), along(), table_top_mm, 0.0F));
  const float block_z_mm = body.max().z() - between(draw, 0.1, 0.5) * half.z();
  for (const float which_side : {-1.0F, 1.0F}) {
    const Vector3f size(between(draw, 18.0, 30.0),
                        between(draw, 0.12, 0.3) * half.y() + 15.0F,
                        between(draw, 35.0, 60.0));
    auto pose = standing(beside(which_side, size.x(), between(draw, 2.0, 14.0)),
                         block_z_mm,
                         table_top_mm,
                         between(draw, -0.08, 0.08));
    pose.translation().y() -= size.y();
    things.append(painted(block(size), kFoam, 6.0F), pose);
  }
  return things;
}

}  // namespace mor::internal
