// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

struct AcvdOptions {
  int num_vertices = 20000;  ///< Clusters, hence vertices of the result. >= 4.
  int sub_sampling = 300;  ///< The input is subdivided until it has this many vertices per cluster,
                           ///< or is left as is when it has enough triangles already.
  double gradation = 0.0;  ///< Exponent of curvature in the density; 0 is uniform.

  [[nodiscard]] Result<void> check() const;
};

/// Remeshes a triangle surface: Valette, Chassery, Prost, "Generic remeshing of 3D triangular
/// meshes with metric-dependent discrete Voronoi diagrams", IEEE TVCG 2008. The input's vertices
/// (or triangles) are clustered by minimising the discrete energy over boundary edges; each cluster
/// gives one vertex, placed by its quadric; clusters that touch are joined by the dual
/// triangulation.
///
/// @return Vertices, triangles and normals; same orientation as the input.
/// @errors kInvalidArgument: bad options or fewer input vertices than clusters.
[[nodiscard]] Result<TriangleMesh> remesh_acvd(const TriangleMesh& mesh,
                                               const AcvdOptions& options,
                                               const Progress& progress);

}  // namespace mor
