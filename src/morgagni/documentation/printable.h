// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "morgagni/core/result.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor {

/// Whether a surface encloses a solid, and what is missing for that.
struct SolidCheck {
  std::size_t num_open_edges = 0;        ///< With one triangle only.
  std::size_t num_crowded_edges = 0;     ///< With three or more.
  std::size_t num_turned_edges = 0;      ///< Between two triangles that face opposite ways.
  std::size_t num_pinched_vertices = 0;  ///< Where surfaces touch in a point.
  std::size_t num_empty_triangles = 0;   ///< With a corner twice.
  double volume_mm3 = 0.0;               ///< Enclosed; negative: inside out.

  /// Closed, two triangles an edge, the right side out: what printers call manifold.
  [[nodiscard]] bool is_solid() const {
    return num_open_edges + num_crowded_edges + num_turned_edges + num_pinched_vertices +
                   num_empty_triangles ==
               0 &&
           volume_mm3 > 0.0;
  }
};

[[nodiscard]] SolidCheck check_solid(const TriangleMesh& mesh);

enum class PrintForm : std::uint8_t {
  kFilled,  ///< The open ends, where the CT ends, are closed by lids.
  kShell,   ///< A wall of given thickness inwards, its ends open.
};

struct PrintOptions {
  PrintForm form = PrintForm::kFilled;
  double wall_mm = 3.0;  ///< kShell: thickness. 0.5..20.

  [[nodiscard]] Result<void> check() const;
};

/// The skin made a solid. Frame ct, mm.
struct PrintableSolid {
  TriangleMesh mesh;                   ///< First the skin's triangles in their order.
  std::size_t num_skin_triangles = 0;  ///< What follows closes it.
  std::size_t num_open_ends = 0;       ///< Of the skin as it was.
  double thinnest_mm = 0.0;            ///< 1 % of the skin has less material than this under it.
  double thin_share = 0.0;             ///< kShell: of the wall, what had to be thinner than asked
                                       ///< for, where the body itself is thin or folded.
};

/// Closes the skin for printing. Where the skin touches itself in a vertex it is cut apart there.
/// Whether the surface cuts through itself is not looked at.
///
/// @param skin  With normals pointing out.
/// @errors kInvalidArgument: options; a surface that cannot be closed (says what is wrong with it).
[[nodiscard]] Result<PrintableSolid> make_printable(const TriangleMesh& skin,
                                                    const PrintOptions& options);

/// Diameter of the largest ball inside of the body that touches the skin there (Ma, Bae & Choi
/// 2012), at each vertex, mm; at most `most_mm`.
[[nodiscard]] std::vector<float> local_thickness_mm(const TriangleMesh& skin, double most_mm);

}  // namespace mor
