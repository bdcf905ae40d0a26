// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor::testing_covers {

/// A real body with nothing around it, and how far each voxel lies from it.
struct BareBody {
  Volume volume;
  internal::BitMask body;
  TriangleMesh skin;
  std::vector<float> from_body_mm;  ///< 0 in the body.
  /// The same from the body with its hollows bridged as a taut sheet would; negative beneath it.
  std::vector<float> from_hull_mm;
};

[[nodiscard]] BareBody bare_body(const Volume& ct);

/// "blanket-400", "flat-150", "plaster", ... in the order of the tables.
[[nodiscard]] std::vector<std::string> cover_kinds();

struct Covered {
  Volume volume;
  internal::BitMask cover;
};

/// The kind of cover laid over the body: where, how thick and how dense comes of the seed. Voxels
/// that skin and air share become skin and cover in the same shares.
[[nodiscard]] Covered covered(const BareBody& bare, const std::string& kind, unsigned seed);

struct Distances {
  std::size_t num = 0;
  double median_mm = 0.0;
  double p95_mm = 0.0;
  double p99_mm = 0.0;
  double max_mm = 0.0;
  double share_above_1mm = 0.0;
};

/// From the vertices of one skin near the cover to the surface of the other.
[[nodiscard]] Distances distances_at(const TriangleMesh& from,
                                     const TriangleMesh& to,
                                     const Covered& scene);

}  // namespace mor::testing_covers
