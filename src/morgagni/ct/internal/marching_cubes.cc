// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/marching_cubes.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/cube_cases.h"

namespace mor::internal {
namespace {

using Word = BitMask::Word;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// A vertex keeps this share of an edge away from its ends: slivers would help nobody.
constexpr float kMinShare = 0.02F;

/// The vertices on the x and y edges of one slice, by voxel; kNone where there is none yet.
struct SliceEdges {
  std::vector<std::uint32_t> x, y;

  void clear(std::size_t num_voxels) {
    x.assign(num_voxels, kNone);
    y.assign(num_voxels, kNone);
  }
};

/// The same of few, by their number: x and y edges in turn.
struct EdgeVertex {
  std::size_t edge;
  std::uint32_t vertex;
};

std::vector<EdgeVertex> listed(const SliceEdges& edges) {
  std::vector<EdgeVertex> list;
  for (std::size_t i = 0; i < edges.x.size(); ++i) {
    if (edges.x[i] != kNone) list.push_back({2 * i, edges.x[i]});
    if (edges.y[i] != kNone) list.push_back({2 * i + 1, edges.y[i]});
  }
  return list;
}

struct Slab {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<EdgeVertex> first, last;  ///< Of its outermost slices.
};

class SlabMarcher {
 public:
  SlabMarcher(const Volume& volume, const BitMask& inside, double threshold_hu)
      : volume_(volume),
        inside_(inside),
        threshold_hu_(static_cast<float>(threshold_hu)),
        slice_voxels_(static_cast<std::size_t>(volume.size[0]) *
                      static_cast<std::size_t>(volume.size[1])),
        ct_from_voxel_((volume.ct_from_grid * Eigen::Scaling(volume.spacing_mm)).cast<float>()) {}

  /// The cubes between slices begin and end.
  Slab run(int begin, int end) {
    lower_.clear(slice_voxels_);
    for (int z = begin; z < end; ++z) {
      upper_.clear(slice_voxels_);
      between_.assign(slice_voxels_, kNone);
      for (int y = 0; y + 1 < volume_.size[1]; ++y) march_row(y, z);
      if (z == begin) slab_.first = listed(lower_);
      std::swap(lower_, upper_);
    }
    slab_.last = listed(lower_);
    return std::move(slab_);
  }

 private:
  /// Visits the cubes of a row that are not all inside or all outside, 64 at a glance.
  void march_row(int y, int z) {
    const std::array rows = {
        inside_.row(y, z), inside_.row(y + 1, z), inside_.row(y, z + 1), inside_.row(y + 1, z + 1)};
    const int num_cubes = volume_.size[0] - 1;
    for (std::size_t i = 0; i < rows[0].size(); ++i) {
      Word any = 0;
      Word all = ~Word{0};
      for (const auto& row : rows) {
        const Word next = i + 1 < row.size() ? row[i + 1] : 0;
        const Word shifted = row[i] >> 1 | next << (BitMask::kWordBits - 1);
        any |= row[i] | shifted;
        all &= row[i] & shifted;
      }
      for (Word mixed = any & ~all; mixed != 0; mixed &= mixed - 1) {
        const int x = static_cast<int>(i) * BitMask::kWordBits + std::countr_zero(mixed);
        if (x < num_cubes) march_cube(x, y, z);
      }
    }
  }

  void march_cube(int x, int y, int z) {
    unsigned inside = 0;
    for (int corner = 0; corner < 8; ++corner) {
      if (inside_.test(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1)))
        inside |= 1U << corner;
    }
    for (const auto& [a, b, c] : cases_[inside])
      slab_.triangles.push_back({vertex(a, x, y, z), vertex(b, x, y, z), vertex(c, x, y, z)});
  }

  std::uint32_t vertex(int edge, int x, int y, int z) {
    const auto [low, high] = kCubeEdges[static_cast<std::size_t>(edge)];
    const std::array<int, 3> from = {x + (low & 1), y + (low >> 1 & 1), z + (low >> 2 & 1)};
    const std::size_t voxel =
        static_cast<std::size_t>(from[1]) * volume_.size[0] + static_cast<std::size_t>(from[0]);
    SliceEdges& slice = from[2] == z ? lower_ : upper_;
    const int axis = edge / 4;
    std::uint32_t& known = (axis == 0 ? slice.x : axis == 1 ? slice.y : between_)[voxel];
    if (known == kNone) known = add_vertex(from, axis);
    return known;
  }

  std::uint32_t add_vertex(const std::array<int, 3>& from, int axis) {
    auto to = from;
    ++to[static_cast<std::size_t>(axis)];
    const float low_hu = volume_.hu[volume_.index(from[0], from[1], from[2])];
    const float high_hu = volume_.hu[volume_.index(to[0], to[1], to[2])];
    float share = 0.5F;
    const bool crosses = (low_hu < threshold_hu_) != (high_hu < threshold_hu_);
    const bool low_inside = inside_.test(from[0], from[1], from[2]);
    if (crosses && low_inside == (low_hu > high_hu))
      share = std::clamp((threshold_hu_ - low_hu) / (high_hu - low_hu), kMinShare, 1 - kMinShare);
    Eigen::Vector3f voxel(
        static_cast<float>(from[0]), static_cast<float>(from[1]), static_cast<float>(from[2]));
    voxel[axis] += share;
    slab_.vertices.push_back(ct_from_voxel_ * voxel);
    return static_cast<std::uint32_t>(slab_.vertices.size() - 1);
  }

  const Volume& volume_;
  const BitMask& inside_;
  const float threshold_hu_;
  const std::size_t slice_voxels_;
  const Eigen::Affine3f ct_from_voxel_;
  const CubeCases& cases_ = cube_cases();
  SliceEdges lower_, upper_;
  std::vector<std::uint32_t> between_;
  Slab slab_;
};

/// Puts `slab` on top of `mesh`, whose last slice's vertices it shares.
void append(TriangleMesh& mesh, const Slab& slab, std::vector<EdgeVertex>& top) {
  std::vector<std::uint32_t> renamed(slab.vertices.size(), kNone);
  auto shared = top.begin();
  for (const auto& [edge, vertex] : slab.first) {
    while (shared != top.end() && shared->edge < edge) ++shared;
    if (shared != top.end() && shared->edge == edge) renamed[vertex] = shared->vertex;
  }
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    if (renamed[i] != kNone) continue;
    renamed[i] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(slab.vertices[i]);
  }
  for (const auto& [a, b, c] : slab.triangles)
    mesh.triangles.push_back({renamed[a], renamed[b], renamed[c]});
  top = slab.last;
  for (auto& shared_next : top) shared_next.vertex = renamed[shared_next.vertex];
}

}  // namespace

TriangleMesh marching_cubes(const Volume& volume, const BitMask& inside, double threshold_hu) {
  constexpr int kCubesPerSlab = 16;
  const int num_cubes = volume.size[2] - 1;
  const int num_slabs = (num_cubes + kCubesPerSlab - 1) / kCubesPerSlab;
  std::vector<Slab> slabs(static_cast<std::size_t>(num_slabs));
  tbb::parallel_for(0, num_slabs, [&](int i) {
    const int begin = i * kCubesPerSlab;
    slabs[static_cast<std::size_t>(i)] =
        SlabMarcher(volume, inside, threshold_hu)
            .run(begin, std::min(num_cubes, begin + kCubesPerSlab));
  });
  TriangleMesh mesh;
  std::vector<EdgeVertex> top;
  for (auto& slab : slabs) {
    append(mesh, slab, top);
    slab = {};
  }
  return mesh;
}

}  // namespace mor::internal
