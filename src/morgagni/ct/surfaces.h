// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "morgagni/core/image.h"
#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/cut_part.h"
#include "morgagni/ct/skin_doubt.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor {

/// How the skin is taken from a CT (paper, section 2, "CT skin segmentation").
struct SkinOptions {
  double threshold_hu = -300.0;  ///< Body is at or above this.
  double upper_hu = 3071.0;  ///< ... and at or below this: metal and clipping stay out above it.
  double closing_mm = 3.0;   ///< Radius of the closing. >= 0.
  int num_vertices = 20000;  ///< After remeshing. 100..1,000,000.
  /// Input vertices wanted per remeshed vertex's cluster, by subdivision of the input. The paper
  /// takes 300. A full-size CT brings 27 by itself, and meets every figure with them; 100 and more
  /// lift the share of valences 5-7 by a percent, leave the distances and cost up to a minute.
  int sub_sampling = 20;
  double gradation = 0.0;  ///< 0: uniform; larger: more vertices where the surface bends.
  /// Marks (CutPart::marks_mm) in what is kept though it would be cut off: an arm beside the trunk.
  std::vector<Eigen::Vector3d> keep_mm = {};
  /// Marks in what stands out from the body and is cut off all the same: a tube in the mouth.
  std::vector<Eigen::Vector3d> cut_mm = {};
  /// Places of the skin where a thin layer may go on (SkinDoubt::Why::kLayerLeft): there it is
  /// taken off, as thick as it is where it is seen.
  std::vector<Eigen::Vector3d> take_off_mm = {};

  [[nodiscard]] Result<void> check() const;
};

/// What was taken for the body and what for its surroundings, for people to check.
struct BodyPreview {
  std::vector<CutPart> cut;       ///< What is not the body, the largest first.
  std::vector<SkinDoubt> doubts;  ///< Where the skin is not certain, the largest first.
  Image<Rgb8> picture;            ///< Slices and views; what was cut is red, doubtful skin orange.
};

struct SkinSurfaces {
  TriangleMesh full;  ///< Marching cubes on the closed body mask's grey values, frame ct, LPS mm.
  TriangleMesh remeshed;  ///< About `num_vertices`, with normals pointing out of the body.
  BodyPreview preview;
  Volume body;  ///< The CT's box around the body, air and tables beside it kOutsideHu, the rest
                ///< within [-1024, 3071] HU.
};

/// Threshold, closing, largest body without the table, marching cubes, ACVD remeshing.
/// @errors kInvalidArgument: bad options, no voxel in the thresholds, no air around the body.
/// kCancelled never.
/// @cost <= 20 s for 512x512x275 on two cores. Peak about twice the volume.
[[nodiscard]] Result<SkinSurfaces> extract_skin(const Volume& volume,
                                                const SkinOptions& options,
                                                const Progress& progress);

/// All of it but `remeshed`. @errors The same.
[[nodiscard]] Result<SkinSurfaces> find_skin(const Volume& volume,
                                             const SkinOptions& options,
                                             const Progress& progress);
/// SkinSurfaces::remeshed. @errors kInvalidArgument: `full` has fewer vertices than asked for.
[[nodiscard]] Result<TriangleMesh> remesh_skin(const TriangleMesh& full,
                                               const SkinOptions& options,
                                               const Progress& progress);

/// Only the first steps of it: to check the thresholds before a case is made. @errors The same.
[[nodiscard]] Result<BodyPreview> preview_body(const Volume& volume,
                                               const SkinOptions& options,
                                               const Progress& progress);

struct BoneOptions {
  double threshold_hu = 250.0;       ///< Bone is at or above this.
  double min_component_mm3 = 500.0;  ///< Smaller islands are noise.
  int num_triangles = 40000;         ///< After decimation; what the renderer draws each frame.

  [[nodiscard]] Result<void> check() const;
};

/// The bones as one closed, smooth mesh with normals, frame ct. An empty mesh where the CT has
/// none.
/// @param body  SkinSurfaces::body: beside the body kOutsideHu.
[[nodiscard]] Result<TriangleMesh> extract_bone(const Volume& body,
                                                const BoneOptions& options,
                                                const Progress& progress);

}  // namespace mor
