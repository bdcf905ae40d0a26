// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "morgagni/camera/internal/kinect_noise.h"
#include "morgagni/camera/internal/scene/painted_mesh.h"
#include "morgagni/camera/internal/scene/shade_map.h"
#include "morgagni/camera/internal/scene/table.h"
#include "morgagni/core/image.h"
#include "morgagni/geometry/pinhole_camera.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

struct ScenePicture {
  IdealDepth depth;
  Image<Rgb8> color;
};

/// Draws a body on a table above a floor, and what else lies there: a lamp at the camera, one on
/// the ceiling, and the light of the room.
class Scene {
 public:
  /// @param camera  Without lens distortion.
  /// @param is_marked  The skin has marks (skin_marks.h). @param table_uneven_mm  As Table.
  Scene(const TriangleMesh& skin,
        const PinholeCamera& camera,
        std::uint64_t seed,
        bool is_marked,
        double table_uneven_mm = 0.0);

  /// @param things  Beside the body and the table; may be empty.
  /// @threads Safe to call from many at once.
  [[nodiscard]] ScenePicture draw(const Eigen::Isometry3d& ct_from_camera,
                                  const PaintedMesh& things) const;

  [[nodiscard]] float table_top_mm() const { return table_.top_mm(); }

 private:
  /// A vertex on the picture, lit.
  struct Lit {
    float x_px;
    float y_px;
    float facing;
    float r, g, b;
  };

  /// A surface as one picture has it.
  struct Seen {
    const TriangleMesh* mesh;
    std::vector<Lit> lit;
    Image<std::uint32_t> triangle_idx;
  };
  [[nodiscard]] std::vector<Lit> light(const PaintedMesh& surface,
                                       const Eigen::Isometry3d& ct_from_camera,
                                       const ShadeMap& shade) const;
  [[nodiscard]] Seen look_at(const PaintedMesh& surface,
                             const Eigen::Isometry3d& ct_from_camera,
                             const ShadeMap& shade,
                             Image<float>& depth_mm) const;
  void draw_pixel(
      const Seen& seen, int x, int y, const Eigen::Vector3f& at_ct, ScenePicture& picture) const;
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
  void draw_room_row(const RoomRow& room,
                     const Eigen::Vector3f& eye_ct,
                     const Eigen::Vector3f& row_ray,
                     const Eigen::Vector3f& step_x,
                     int y,
                     const Image<std::uint8_t>& surface,
                     ScenePicture& picture) const;
  [[nodiscard]] Rgb8 floor_color(const Eigen::Vector3f& at_ct, float cosine) const;
  void soften_outline(const Image<std::uint8_t>& surface, Image<Rgb8>& color) const;

  PinholeCamera camera_;
  std::uint64_t seed_;
  bool is_marked_;
  Table table_;
  PaintedMesh skin_;
  std::vector<float> pores_;  ///< A cube of kPoreSide^3 brightness factors.
  Image<float> inverse_ray_length_;
};

}  // namespace mor::internal
