// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/label_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "morgagni/ct/internal/bit_mask.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/surface_finish.h"

namespace mor {
namespace {

constexpr std::size_t kMaxLabels = 200;

/// Where a label's voxels lie, and how many they are.
struct LabelBox {
  std::array<int, 3> low = {INT32_MAX, INT32_MAX, INT32_MAX};
  std::array<int, 3> high = {-1, -1, -1};
  std::size_t num_voxels = 0;

  void add_run(int y, int z, int begin, int end) {
    low = {std::min(low[0], begin), std::min(low[1], y), std::min(low[2], z)};
    high = {std::max(high[0], end - 1), std::max(high[1], y), std::max(high[2], z)};
    num_voxels += static_cast<std::size_t>(end - begin);
  }
};

std::map<int, LabelBox> find_labels(const Volume& voxels) {
  std::vector<LabelBox> boxes(32768);
  for (int z = 0; z < voxels.size[2]; ++z) {
    for (int y = 0; y < voxels.size[1]; ++y) {
      const std::int16_t* row = voxels.hu.data() + voxels.index(0, y, z);
      for (int x = 0; x < voxels.size[0];) {
        const int begin = x;
        while (x < voxels.size[0] && row[x] == row[begin]) ++x;
        if (row[begin] > 0) boxes[static_cast<std::size_t>(row[begin])].add_run(y, z, begin, x);
      }
    }
  }
  std::map<int, LabelBox> found;
  for (std::size_t label = 1; label < boxes.size(); ++label)
    if (boxes[label].num_voxels > 0) found[static_cast<int>(label)] = boxes[label];
  return found;
}

/// The box with two empty voxels around it, so that the surface closes; 1000 inside, 0 outside.
Volume cut_out(const Volume& voxels, int label, const LabelBox& box) {
  constexpr int kMargin = 2;
  constexpr std::int16_t kInside = 1000;
  Volume part;
  Eigen::Vector3d low_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    part.size[i] = box.high[i] - box.low[i] + 1 + 2 * kMargin;
    low_mm[axis] = (box.low[i] - kMargin) * voxels.spacing_mm[axis];
  }
  part.spacing_mm = voxels.spacing_mm;
  part.ct_from_grid = voxels.ct_from_grid * Eigen::Translation3d(low_mm);
  part.hu.assign(static_cast<std::size_t>(part.size[0]) * static_cast<std::size_t>(part.size[1]) *
                     static_cast<std::size_t>(part.size[2]),
                 0);
  for (int z = box.low[2]; z <= box.high[2]; ++z)
    for (int y = box.low[1]; y <= box.high[1]; ++y)
      for (int x = box.low[0]; x <= box.high[0]; ++x)
        if (voxels.hu[voxels.index(x, y, z)] == label)
          part.hu[part.index(
              x - box.low[0] + kMargin, y - box.low[1] + kMargin, z - box.low[2] + kMargin)] =
              kInside;
  return part;
}

/// Mean with the two neighbours along one axis, in place: grey values for marching cubes to place
/// the surface by.
void blur_along(Volume& part, int axis) {
  const std::size_t step = axis == 0 ? 1 : axis == 1 ? part.index(0, 1, 0) : part.index(0, 0, 1);
  HuArray blurred = part.hu;
  for (std::size_t i = step; i + step < part.hu.size(); ++i)
    blurred[i] =
        static_cast<std::int16_t>((part.hu[i - step] + 2 * part.hu[i] + part.hu[i + step]) / 4);
  part.hu = std::move(blurred);
}

/// No voxel of the label blurs away: what is a voxel thin would lie in a plane.
void keep_sides(Volume& part, const internal::BitMask& inside) {
  constexpr std::int16_t kLeastInside = 750;
  constexpr std::int16_t kMostOutside = 250;
  for (int z = 0; z < part.size[2]; ++z) {
    for (int y = 0; y < part.size[1]; ++y) {
      for (int x = 0; x < part.size[0]; ++x) {
        auto& share = part.hu[part.index(x, y, z)];
        share =
            inside.test(x, y, z) ? std::max(share, kLeastInside) : std::min(share, kMostOutside);
      }
    }
  }
}

TriangleMesh surface_of(Volume part, int num_triangles) {
  constexpr double kHalf = 500.0;
  const auto inside = internal::threshold(part, kHalf, 32767.0);
  for (int axis = 0; axis < 3; ++axis) blur_along(part, axis);
  keep_sides(part, inside);
  TriangleMesh mesh = internal::marching_cubes(part, inside, kHalf);
  const double volume_mm3 = static_cast<double>(inside.count()) * part.spacing_mm.prod();
  internal::finish_surface(mesh, part, {.num_triangles = num_triangles, .volume_mm3 = volume_mm3});
  return mesh;
}

/// Colours far apart for labels that nobody coloured: steps of the golden angle around the wheel.
Eigen::Vector3f color_for(int label) {
  const double hue = std::fmod(label * 0.618034, 1.0) * 6.0;
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + hue, 6.0);
    return static_cast<float>(0.9 - 0.55 * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

LabelName name_for(const LabelMap& labels, int label) {
  const auto found = std::find_if(labels.names.begin(), labels.names.end(), [&](const auto& name) {
    return name.value == label;
  });
  if (found != labels.names.end()) return *found;
  return {label, "label " + std::to_string(label), color_for(label)};
}

}  // namespace

Result<void> LabelSurfaceOptions::check() const {
  if (num_triangles < 100 || num_triangles > 1000000)
    return make_error(
        ErrorCode::kInvalidArgument,
        "num_triangles must be in [100, 1000000], got " + std::to_string(num_triangles));
  if (!(min_volume_mm3 >= 0.0))
    return make_error(ErrorCode::kInvalidArgument,
                      "min_volume_mm3 must be 0 or more, got " + std::to_string(min_volume_mm3));
  return {};
}

Result<std::vector<StructureSurface>> extract_labels(const LabelMap& labels,
                                                     const LabelSurfaceOptions& options,
                                                     const Progress& progress) {
  constexpr const char* kStage = "labels";
  MOR_CHECK(options.check());
  if (progress) progress(kStage, 0.0);
  const auto boxes = find_labels(labels.voxels);
  if (boxes.empty())
    return make_error(ErrorCode::kInvalidArgument, "the label map holds no label above 0");
  if (boxes.size() > kMaxLabels) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the label map holds " + std::to_string(boxes.size()) + " labels, at most " +
                          std::to_string(kMaxLabels) + " are drawn: is it a CT?");
  }
  const double voxel_mm3 = labels.voxels.spacing_mm.prod();
  std::vector<StructureSurface> surfaces;
  std::size_t num_done = 0;
  for (const auto& [label, box] : boxes) {
    if (static_cast<double>(box.num_voxels) * voxel_mm3 >= options.min_volume_mm3) {
      auto mesh = surface_of(cut_out(labels.voxels, label, box), options.num_triangles);
      const auto name = name_for(labels, label);
      if (!mesh.empty()) surfaces.push_back({name.name, name.color, std::move(mesh)});
    }
    if (progress)
      progress(kStage, static_cast<double>(++num_done) / static_cast<double>(boxes.size()));
  }
  return surfaces;
}

}  // namespace mor
