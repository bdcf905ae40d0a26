// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "morgagni/camera/internal/kinect_noise.h"
#include "morgagni/camera/internal/table.h"
#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

struct ScenePicture {
  IdealDepth depth;
  Image<Rgb8> color;
};

/// Draws a body on a table above a floor: a lamp at the camera, one on the ceiling, and the light
/// of the room.
class Scene {
 public:
  /// @param camera  Without lens distortion.
  Scene(std::shared_ptr<const TriangleMesh> skin, const PinholeCamera& camera, std::uint64_t seed);

  /// @threads Safe to call from many at once.
  [[nodiscard]] ScenePicture draw(const Eigen::Isometry3d& ct_from_camera) const;

 private:
  /// A skin vertex on the picture, lit.
  struct Lit {
    float x_px;
    float y_px;
    float facing;
    float r, g, b;
  };

  [[nodiscard]] std::vector<Lit> light(const Eigen::Isometry3d& ct_from_camera) const;
  void draw_skin_pixel(const std::vector<Lit>& lit,
                       std::uint32_t triangle,
                       int x,
                       int y,
                       const Eigen::Vector3f& at_ct,
                       ScenePicture& picture) const;
  /// Where the rays of one row of pixels go past the skin.
  struct RoomRow {
    explicit RoomRow(int width)
        : x(Eigen::ArrayXf::LinSpaced(width, 0.0F, static_cast<float>(width - 1))),
          cosine(width),
          per_fall(width),
          table_column(width),
          table_row(width) {}
    Eigen::ArrayXf x;
    Eigen::ArrayXf cosine;    ///< Between ray and vertical.
    Eigen::ArrayXf per_fall;  ///< Depth a millimetre of fall.
    Eigen::ArrayXf table_column;
    Eigen::ArrayXf table_row;
  };
  void look_past_skin(int y,
                      const Eigen::Vector3f& eye_ct,
                      const Eigen::Vector3f& first_ray_ct,
                      const Eigen::Vector3f& ray_step_ct,
                      RoomRow& row) const;
  [[nodiscard]] Rgb8 floor_color(const Eigen::Vector3f& at_ct, float cosine) const;
  void soften_outline(const Image<std::uint8_t>& is_skin, Image<Rgb8>& color) const;

  std::shared_ptr<const TriangleMesh> skin_;
  PinholeCamera camera_;
  Table table_;
  std::vector<Eigen::Vector3f> normals_;
  std::vector<Eigen::Vector3f> albedo_;  ///< One a vertex, 0..255.
  std::vector<float> pores_;             ///< A cube of kPoreSide^3 brightness factors.
  Image<float> inverse_ray_length_;
};

}  // namespace mor::internal
