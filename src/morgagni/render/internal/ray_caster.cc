// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/parallel_for.h>

#include "morgagni/render/internal/fragments.h"
#include "morgagni/render/internal/lanes.h"
#include "morgagni/render/internal/volume_pyramid.h"

namespace mor::internal {
namespace {

constexpr int kMostLevels = 4;           ///< The volume and three coarser copies.
constexpr double kCoarsest = 1.15;       ///< Times the rays' distance: voxels may be so far apart,
constexpr double kLiveCoarsest = 1.55;   ///< and while the picture moves.
constexpr float kEnough = 0.98F;         ///< Opacity at which a ray ends.
constexpr float kLeastOpacity = 0.002F;  ///< Of a sample that is seen,
constexpr float kLeastLit = 0.01F;  ///< and of what it adds to its ray where it is worth lighting.
constexpr float kFlatHuPerMm = 15.0F;   ///< Weaker gradients are noise: lit from all sides,
constexpr float kSteepHuPerMm = 80.0F;  ///< stronger ones are surfaces.
constexpr float kFlatLight = 0.80F;
constexpr float kAmbient = 0.16F;
constexpr float kFacing = 0.56F;
constexpr float kKey = 0.45F;
constexpr float kEdgeLight = 0.45F;  ///< Of the light, where a surface turns away.
constexpr float kEdgeFacing = 0.4F;  ///< From here on it is no edge.
constexpr std::array<float, 3> kKeyLight = {-0.40F, -0.66F, -0.64F};  ///< As structure.frag.glsl.
constexpr float kFarLight = 0.62F;  ///< Of the light, at the far end of the body.

struct Point {
  Floats x, y, z;
};

/// Everything that all rays of a picture share.
struct Scene : RayGeometry {
  const std::int16_t* voxels;
  std::array<int, 3> bricks;
  const std::uint8_t* distances;
  const float* opacity;
  const float* opacity_sum;
  const float* moment_sum;
  float surface_entry;
  const std::uint32_t* colors;
  float step_mm;
};

struct Rays {
  Point voxels_per_mm;
  Point mm_per_voxel;
  Point towards;               ///< x/z, y/z, 1 over its length: unit vector, colour frame.
  Floats first_mm;             ///< z of the first sample,
  Floats last_mm;              ///< and where the ray leaves the volume.
  Floats step_mm;              ///< Between two samples, in z.
  Ints next{};                 ///< Number of the sample to come.
  Ints last_entry{};           ///< Of the sample before, in the transfer table; of no use
  Ints is_stale = Ints{} - 1;  ///< where a ray comes from a leap.
  Floats light{};              ///< Of the surface that a ray went in by,
  Ints is_inside{};            ///< as long as it is inside.
  Floats red{}, green{}, blue{}, opacity{};
};

Floats interpolated(const Scene& scene, const Point& at) {
  const Floats x = clamped(at.x, Floats{}, all(static_cast<float>(scene.size[0]) - 1.001F));
  const Floats y = clamped(at.y, Floats{}, all(static_cast<float>(scene.size[1]) - 1.001F));
  const Floats z = clamped(at.z, Floats{}, all(static_cast<float>(scene.size[2]) - 1.001F));
  const Ints left = whole(x);
  const Ints front = whole(y);
  const Ints below = whole(z);
  const Floats u = x - real(left);
  const Floats v = y - real(front);
  const Floats w = z - real(below);
  const int row = scene.size[0];
  const int slice = scene.size[0] * scene.size[1];
  const Ints corner = below * slice + front * row + left;
  // Two voxels of a row in each read.
  const auto pair = [&](int offset) {
    const Ints both = gather<2>(scene.voxels, corner + offset);
    // Beside the body is air: what stands there for "outside" would bend every gradient at the
    // skin.
    const Floats first = most(real((both << 16) >> 16), all(TransferTable::kLeastHu));
    const Floats second = most(real(both >> 16), all(TransferTable::kLeastHu));
    return first + (second - first) * u;
  };
  const Floats near = pair(0) + (pair(row) - pair(0)) * v;
  const Floats lower_back = pair(slice);
  const Floats far = lower_back + (pair(slice + row) - lower_back) * v;
  return near + (far - near) * w;
}

/// What is far in the body is darker.
Floats darkening(const Scene& scene, Floats depth_mm) {
  const Floats far = clamped(
      (depth_mm - scene.nearest_mm) / (scene.farthest_mm - scene.nearest_mm), Floats{}, all(1.0F));
  return 1.0F + (kFarLight - 1.0F) * far;
}

/// How bright a sample is from where it faces.
Floats light_of(const Scene& scene, const Rays& rays, const Point& at, Floats depth_mm) {
  // Four corners of a cube around it, not six faces: two thirds of the reads.
  const auto [rx, ry, rz] = scene.gradient_voxels;
  const auto beside = [&, rx = rx, ry = ry, rz = rz](float dx, float dy, float dz) {
    return interpolated(scene, {at.x + dx * rx, at.y + dy * ry, at.z + dz * rz});
  };
  const Floats a = beside(1, -1, -1);
  const Floats b = beside(-1, -1, 1);
  const Floats c = beside(-1, 1, -1);
  const Floats d = beside(1, 1, 1);
  const Floats gx = (a - b - c + d) * (0.25F / rx);
  const Floats gy = (c + d - a - b) * (0.25F / ry);
  const Floats gz = (b + d - a - c) * (0.25F / rz);
  const Eigen::Matrix3f& m = scene.color_from_gradient;
  const Floats x = m(0, 0) * gx + m(0, 1) * gy + m(0, 2) * gz;
  const Floats y = m(1, 0) * gx + m(1, 1) * gy + m(1, 2) * gz;
  const Floats z = m(2, 0) * gx + m(2, 1) * gy + m(2, 2) * gz;
  const Floats length = square_root(x * x + y * y + z * z) + 1e-3F;
  // The gradient points into what is denser; its surface faces the other way.
  const Floats to_viewer = (x * rays.towards.x + y * rays.towards.y + z * rays.towards.z) / length;
  const Floats key = -(x * kKeyLight[0] + y * kKeyLight[1] + z * kKeyLight[2]) / length;
  const Floats side = to_viewer < 0.0F ? all(-1.0F) : all(1.0F);
  const Floats facing = magnitude(to_viewer);
  const Floats edge = least(kEdgeLight + ((1.0F - kEdgeLight) / kEdgeFacing) * facing, all(1.0F));
  const Floats lit = (kAmbient + kFacing * facing + kKey * most(key * side, Floats{})) * edge;
  const Floats steep =
      clamped((length - kFlatHuPerMm) / (kSteepHuPerMm - kFlatHuPerMm), Floats{}, all(1.0F));
  return (kFlatLight + (lit - kFlatLight) * steep) * darkening(scene, depth_mm);
}

/// z at which each ray leaves the cube of transparent bricks around its own.
Floats end_of_leap(const Rays& rays,
                   const Scene& scene,
                   const std::array<Ints, 3>& brick,
                   Ints distance) {
  constexpr float kSide = VolumeBricks::kCells;
  const auto exit = [&](Ints own, Floats per_mm, Floats mm_per_voxel, float eye) {
    const Ints border = per_mm > 0.0F ? own + distance : own - distance + 1;
    const Floats at_mm = (real(border) * kSide - eye) * mm_per_voxel;
    return magnitude(per_mm) < 1e-6F ? all(kNoDepth) : at_mm;
  };
  return least(exit(brick[0], rays.voxels_per_mm.x, rays.mm_per_voxel.x, scene.eye[0]),
               least(exit(brick[1], rays.voxels_per_mm.y, rays.mm_per_voxel.y, scene.eye[1]),
                     exit(brick[2], rays.voxels_per_mm.z, rays.mm_per_voxel.z, scene.eye[2])));
}

Ints entry_at(const Scene& scene, const Point& at) {
  const Floats hu =
      clamped(interpolated(scene, at), all(TransferTable::kLeastHu), all(TransferTable::kMostHu));
  return whole(hu - static_cast<float>(TransferTable::kLeastHu) + 0.5F);
}

Point place_at(const Scene& scene, const Rays& rays, Floats depth_mm) {
  return {scene.eye[0] + depth_mm * rays.voxels_per_mm.x,
          scene.eye[1] + depth_mm * rays.voxels_per_mm.y,
          scene.eye[2] + depth_mm * rays.voxels_per_mm.z};
}

/// Where between two samples most of the opacity lies: that is the colour which is seen.
Ints middle_entry(const Scene& scene, Ints before, Ints entry, Floats opacity_sum) {
  const Floats moment =
      gather_floats(scene.moment_sum, entry) - gather_floats(scene.moment_sum, before);
  const Floats a = real(before);
  const Floats b = real(entry);
  const Floats middle = moment / (opacity_sum == 0.0F ? all(1.0F) : opacity_sum);
  return whole(clamped(middle, least(a, b), most(a, b)) + 0.5F);
}

void add_samples(const Scene& scene, Rays& rays, const Point& at, Floats depth_mm, Ints taken) {
  const Ints entry = entry_at(scene, at);
  Ints before = rays.last_entry;
  if (any(taken & rays.is_stale)) {
    const Ints missed = entry_at(scene, place_at(scene, rays, depth_mm - rays.step_mm));
    before = rays.is_stale ? missed : before;
  }
  rays.last_entry = taken ? entry : rays.last_entry;
  rays.is_stale = rays.is_stale & ~taken;
  const Floats here = gather_floats(scene.opacity, entry);
  const Ints between = entry - before;
  const Floats sum =
      gather_floats(scene.opacity_sum, entry) - gather_floats(scene.opacity_sum, before);
  const Floats mean = sum / real(between == 0 ? Ints{} + 1 : between);
  Floats opacity = between == 0 ? here : mean;
  opacity = taken & (opacity > kLeastOpacity) ? opacity : Floats{};
  if (!any(opacity > 0.0F)) {
    rays.is_inside = taken ? Ints{} : rays.is_inside;
    return;
  }
  const Ints is_dense = real(entry) > all(scene.surface_entry);
  const Ints goes_on = is_dense & rays.is_inside;
  const Floats share = opacity * (1.0F - rays.opacity);
  Floats light = goes_on ? rays.light : kFlatLight * darkening(scene, depth_mm);
  const Ints is_lit = (share > kLeastLit) & ~goes_on;
  if (any(is_lit)) {
    // Lit where the surface is, not where the sample happens to be behind it: else there are rings.
    const Floats own = real(entry);
    const Floats last = real(before);
    const Ints comes_in = (last < scene.surface_entry) & (own > scene.surface_entry);
    const Floats back = (own - scene.surface_entry) / (comes_in ? own - last : all(1.0F));
    const Floats lit_mm = comes_in ? depth_mm - back * rays.step_mm : depth_mm;
    const Floats fresh = light_of(scene, rays, place_at(scene, rays, lit_mm), lit_mm);
    light = is_lit ? fresh : light;
  }
  rays.light = light;
  rays.is_inside = taken ? is_dense : rays.is_inside;
  const Ints color = gather<4>(scene.colors, middle_entry(scene, before, entry, sum));
  const Floats weight = share * light;
  rays.red += weight * real(color & 255);
  rays.green += weight * real((color >> 8) & 255);
  rays.blue += weight * real((color >> 16) & 255);
  rays.opacity += share;
}

/// Goes on until each ray has come to its limit or lets nothing through.
void march(const Scene& scene, Rays& rays, Floats limit_mm) {
  for (;;) {
    const Floats depth_mm = rays.first_mm + real(rays.next) * rays.step_mm;
    const Ints active = (depth_mm < limit_mm) & (rays.opacity < kEnough);
    if (!any(active)) return;
    const Point at = place_at(scene, rays, depth_mm);
    const auto brick_of = [](Floats place, int count) {
      const Floats brick = place * (1.0F / VolumeBricks::kCells);
      return whole(clamped(brick, Floats{}, all(static_cast<float>(count) - 1.0F)));
    };
    const std::array<Ints, 3> brick = {brick_of(at.x, scene.bricks[0]),
                                       brick_of(at.y, scene.bricks[1]),
                                       brick_of(at.z, scene.bricks[2])};
    const Ints index = (brick[2] * scene.bricks[1] + brick[1]) * scene.bricks[0] + brick[0];
    const Ints distance = gather<1>(scene.distances, index) & 255;
    const Ints seen = active & (distance == 0);
    if (any(seen)) add_samples(scene, rays, at, depth_mm, seen);
    Ints next = rays.next + 1;
    const Ints leaps = active & (distance > 0);
    if (any(leaps)) {
      const Floats end_mm = least(end_of_leap(rays, scene, brick, distance), limit_mm);
      const Ints landing = whole((end_mm - rays.first_mm) / rays.step_mm - 1e-3F) + 1;
      next = leaps & (landing > next) ? landing : next;
      rays.is_stale |= leaps;
    }
    rays.next = active ? next : rays.next;
  }
}

void add_fragment(Rays& rays, int lane, const Fragment& fragment) {
  const float left = 1.0F - rays.opacity[lane];
  rays.red[lane] += left * fragment.color.r;
  rays.green[lane] += left * fragment.color.g;
  rays.blue[lane] += left * fragment.color.b;
  rays.opacity[lane] += left * fragment.color.a / 255.0F;
}

Rgba8 color_of(const Rays& rays, int lane) {
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
  };
  return {byte(rays.red[lane]),
          byte(rays.green[lane]),
          byte(rays.blue[lane]),
          byte(rays.opacity[lane] * 255.0F)};
}

/// The part of each ray that is within the volume. @param x, y  Of (x/z, y/z).
Rays enter(const Scene& scene, Floats x, Floats y) {
  Rays rays;
  const Eigen::Matrix3f& m = scene.voxels_from_ray;
  rays.voxels_per_mm = {m(0, 0) * x + m(0, 1) * y + m(0, 2),
                        m(1, 0) * x + m(1, 1) * y + m(1, 2),
                        m(2, 0) * x + m(2, 1) * y + m(2, 2)};
  const Floats length = square_root(x * x + y * y + 1.0F);
  rays.towards = {x / length, y / length, 1.0F / length};
  rays.step_mm = scene.step_mm / length;
  rays.first_mm = all(1.0F);
  rays.last_mm = all(kNoDepth);
  const auto clip = [&](Floats per_mm, float eye, int count) {
    const Floats safe = magnitude(per_mm) < 1e-6F ? all(1e-6F) : per_mm;
    const Floats inverse = 1.0F / safe;
    const Floats a = -eye * inverse;
    const Floats b = (static_cast<float>(count - 1) - eye) * inverse;
    rays.first_mm = most(rays.first_mm, least(a, b));
    rays.last_mm = least(rays.last_mm, most(a, b));
    return inverse;
  };
  rays.mm_per_voxel.x = clip(rays.voxels_per_mm.x, scene.eye[0], scene.size[0]);
  rays.mm_per_voxel.y = clip(rays.voxels_per_mm.y, scene.eye[1], scene.size[1]);
  rays.mm_per_voxel.z = clip(rays.voxels_per_mm.z, scene.eye[2], scene.size[2]);
  return rays;
}

void limit(const RayBundle& bundle, Floats x, Floats y, Rays& rays) {
  for (int lane = 0; lane < kNumLanes; ++lane) {
    const RayLimits limits = ray_limits(bundle, {x[lane], y[lane]});
    rays.first_mm[lane] = std::max(rays.first_mm[lane], limits.first_mm);
    rays.last_mm[lane] = std::min(rays.last_mm[lane], limits.last_mm);
  }
}

/// Eight pixels of a row, `stride_px` apart.
std::array<Rgba8, kNumLanes> cast_packet(const Scene& scene,
                                         const RayBundle& bundle,
                                         const std::array<int, kNumLanes>& columns,
                                         int row) {
  Floats x{};
  Floats y{};
  Ints open{};
  std::array<Fragments, kNumLanes> fragments;
  for (int lane = 0; lane < kNumLanes; ++lane) {
    const int column = columns[static_cast<std::size_t>(lane)];
    const Eigen::Vector2f& ray = bundle.rays->row(row)[column];
    x[lane] = ray.x();
    y[lane] = ray.y();
    open[lane] = !bundle.is_open || bundle.is_open(column, row) ? -1 : 0;
    if (open[lane] != 0) {
      fragments[static_cast<std::size_t>(lane)].gather(bundle.layers, column, row);
    }
  }
  if (!any(open)) return {};
  Rays rays = enter(scene, x, y);
  limit(bundle, x, y, rays);
  rays.first_mm = open ? rays.first_mm + 0.5F * rays.step_mm : all(kNoDepth);
  std::array<int, kNumLanes> next{};
  for (bool is_more = true; is_more;) {
    Floats limit_mm = rays.last_mm;
    for (int lane = 0; lane < kNumLanes; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      if (next[i] < fragments[i].size()) {
        limit_mm[lane] = std::min(limit_mm[lane], fragments[i][next[i]].depth_mm);
      }
    }
    march(scene, rays, limit_mm);
    is_more = false;
    for (int lane = 0; lane < kNumLanes; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      if (next[i] >= fragments[i].size()) continue;
      add_fragment(rays, lane, fragments[i][next[i]++]);
      is_more = true;
    }
  }
  std::array<Rgba8, kNumLanes> result;
  for (int lane = 0; lane < kNumLanes; ++lane) {
    result[static_cast<std::size_t>(lane)] = color_of(rays, lane);
  }
  return result;
}

}  // namespace

RayCaster::Level::Level(std::shared_ptr<const Volume> voxels)
    : volume(std::move(voxels)),
      bricks(*volume),
      step_mm(static_cast<float>(volume->spacing_mm.minCoeff())) {}

RayCaster::RayCaster(std::shared_ptr<const Volume> volume) {
  for (auto& level : make_volume_pyramid(std::move(volume), kMostLevels)) {
    levels_.emplace_back(std::move(level));
  }
}

void RayCaster::set(const VolumeView& view) {
  if (view_ && view_->preset == view.preset && view_->level_hu == view.level_hu &&
      view_->window_hu == view.window_hu) {
    return;
  }
  view_ = view;
  ++revision_;
  for (Level& level : levels_) {
    level.table = make_transfer_table(view, level.step_mm);
    level.distances = level.bricks.distances_to_seen(level.table);
    level.distances.resize(level.distances.size() + sizeof(std::int32_t));  // Read four at a time.
  }
}

std::size_t RayCaster::level_for(const RayBundle& bundle) const {
  const Volume& volume = *levels_.front().volume;
  const Eigen::Vector3d last =
      Eigen::Vector3i(volume.size[0] - 1, volume.size[1] - 1, volume.size[2] - 1).cast<double>();
  const Eigen::Vector3d middle = 0.5 * last.cwiseProduct(volume.spacing_mm);
  const double away_mm = (bundle.color_from_ct * (volume.ct_from_grid * middle)).norm();
  const double apart_mm = away_mm * static_cast<double>(bundle.ray_spacing);
  const double coarsest = bundle.is_still ? kCoarsest : kLiveCoarsest;
  std::size_t level = 0;
  while (level + 1 < levels_.size() &&
         static_cast<double>(levels_[level + 1].step_mm) <= coarsest * apart_mm) {
    ++level;
  }
  return level;
}

void RayCaster::cast(const RayBundle& bundle, Layer& seen) const {
  const Level& level = levels_[level_for(bundle)];
  Scene scene{ray_geometry(*level.volume, bundle.color_from_ct)};
  scene.voxels = level.volume->hu.data();
  scene.bricks = level.bricks.size();
  scene.distances = level.distances.data();
  scene.opacity = level.table.opacity.data();
  scene.opacity_sum = level.table.opacity_sum.data();
  scene.moment_sum = level.table.moment_sum.data();
  scene.surface_entry = level.table.surface_entry;
  scene.colors = level.table.colors.data();
  scene.step_mm = level.step_mm;
  const RayRaster raster(seen.box, bundle.stride_px);
  std::vector<Rgba8> colors(static_cast<std::size_t>(raster.width) * raster.height);
  tbb::parallel_for(0, raster.height, [&](int y) {
    for (int first = 0; first < raster.width; first += kNumLanes) {
      std::array<int, kNumLanes> columns{};
      for (int lane = 0; lane < kNumLanes; ++lane) {
        columns[static_cast<std::size_t>(lane)] = raster.column(first + lane);
      }
      const auto packet = cast_packet(scene, bundle, columns, raster.row(y));
      std::copy_n(packet.begin(),
                  std::min(kNumLanes, raster.width - first),
                  colors.begin() + static_cast<std::ptrdiff_t>(y) * raster.width + first);
    }
  });
  raster.spread(std::move(colors), seen);
}

}  // namespace mor::internal
