// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/cover_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include <tbb/parallel_for.h>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/triangle_grid.h"
#include "morgagni/ct/internal/uncovering.h"

namespace mor::testing_covers {
namespace {

using internal::BitMask;

constexpr double kThresholdHu = -300.0;
constexpr double kAirHu = -1000.0;
constexpr float kFarMm2 = 1e12F;
constexpr double kHullMm = 40.0;  ///< A sheet bridges hollows narrower than about twice this.

template <class Visit>
void for_each(const Volume& volume, const Visit& visit) {
  tbb::parallel_for(0, volume.size[2], [&](int z) {
    for (int y = 0; y < volume.size[1]; ++y)
      for (int x = 0; x < volume.size[0]; ++x) visit(x, y, z);
  });
}

/// Squared distances along one line (Felzenszwalb & Huttenlocher 2012), in place.
void transform_line(float* line, std::size_t stride, int num, double spacing_mm) {
  std::vector<double> value(static_cast<std::size_t>(num));
  for (int i = 0; i < num; ++i) value[i] = line[i * stride];
  std::vector<int> site(static_cast<std::size_t>(num));
  std::vector<double> from(static_cast<std::size_t>(num) + 1);
  const double step2 = spacing_mm * spacing_mm;
  int last = -1;
  for (int i = 0; i < num; ++i) {
    if (value[i] >= kFarMm2) continue;
    double meets = -1e30;
    while (last >= 0) {
      const int k = site[last];
      meets = ((value[i] + step2 * i * i) - (value[k] + step2 * k * k)) / (2.0 * step2 * (i - k));
      if (meets > from[last]) break;
      --last;
    }
    if (last < 0) meets = -1e30;
    site[++last] = i;
    from[last] = meets;
  }
  if (last < 0) return;
  for (int i = 0, k = 0; i < num; ++i) {
    while (k < last && from[k + 1] < i) ++k;
    line[i * stride] = static_cast<float>(value[site[k]] + step2 * (i - site[k]) * (i - site[k]));
  }
}

/// From each voxel to the nearest one of the mask, between their middles.
std::vector<float> distance_mm(const BitMask& mask, const Eigen::Vector3d& spacing_mm) {
  const auto [nx, ny, nz] = mask.size();
  const auto row = static_cast<std::size_t>(nx);
  const std::size_t slice = row * static_cast<std::size_t>(ny);
  std::vector<float> field(slice * static_cast<std::size_t>(nz), kFarMm2);
  for_each_voxel(mask, [&](const std::array<int, 3>& voxel) {
    field[slice * static_cast<std::size_t>(voxel[2]) + row * static_cast<std::size_t>(voxel[1]) +
          static_cast<std::size_t>(voxel[0])] = 0.0F;
  });
  tbb::parallel_for(0, nz, [&, nx = nx, ny = ny](int z) {
    float* first = field.data() + slice * static_cast<std::size_t>(z);
    for (int y = 0; y < ny; ++y) transform_line(first + row * y, 1, nx, spacing_mm.x());
    for (int x = 0; x < nx; ++x) transform_line(first + x, row, ny, spacing_mm.y());
  });
  tbb::parallel_for(0, ny, [&, nx = nx, nz = nz](int y) {
    for (int x = 0; x < nx; ++x)
      transform_line(field.data() + row * y + x, slice, nz, spacing_mm.z());
  });
  tbb::parallel_for(
      std::size_t{0}, field.size(), [&](std::size_t i) { field[i] = std::sqrt(field[i]); });
  return field;
}

/// Where a voxel lies: LPS mm from the body's middle, mm from the skin and from the taut sheet.
struct Place {
  Eigen::Vector3d mm;
  double skin_mm;
  double hull_mm;
};

/// How deep a place lies in the cover (negative: outside, mm), and its HU there without noise.
struct Matter {
  double depth_mm = -1e9;
  double hu = 0.0;
};

struct Cover {
  double noise_hu = 20.0;
  std::function<Matter(const Place&)> at;
};

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }
  /// Across the body axis, by the angle from straight ahead (the front).
  Eigen::Vector3d direction(double most_rad) {
    const double angle = (*this)(-most_rad, most_rad);
    return {std::sin(angle), -std::cos(angle), 0.0};
  }

 private:
  std::mt19937 random_;
};

/// Cloth on one side of a slanted plane, in layers with pockets of air between them.
Cover blanket(double hu, bool is_flat, Dice& dice) {
  const Eigen::Vector3d towards =
      (dice.direction(1.2) + Eigen::Vector3d(0, 0, dice(-0.5, 0.5))).normalized();
  const double beyond_mm = dice(-10.0, 30.0);
  const double thick_mm = dice(18.0, 32.0);
  const double layer_mm = dice(5.0, 9.0);
  const double phase = dice(0.0, 6.0);
  return {40.0, [=](const Place& place) {
            const double from_mm = is_flat ? place.hull_mm + 1.0 : place.skin_mm;
            const double wave =
                std::sin(0.11 * place.mm.x() + phase) * std::sin(0.09 * place.mm.z() + 2.0 * phase);
            const double layer = std::sin(2.0 * std::numbers::pi * from_mm / layer_mm + 2.0 * wave);
            const bool is_pocket = layer > 0.9 && wave > 0.35 && from_mm > 4.0;
            return Matter{std::min({from_mm + 1.0,
                                    thick_mm + 3.0 * wave - from_mm,
                                    place.mm.dot(towards) - beyond_mm}),
                          is_pocket ? -950.0 : hu + 0.12 * std::abs(hu) * layer};
          }};
}

/// Around the body between two slanted planes.
Cover plaster(double least_mm, double most_mm, Dice& dice) {
  const double hu = dice(250.0, 700.0);
  const double thick_mm = dice(least_mm, most_mm);
  const double half_mm = dice(25.0, 45.0);
  const double middle_mm = dice(-20.0, 20.0);
  const Eigen::Vector3d along = Eigen::Vector3d(dice(-0.3, 0.3), dice(-0.3, 0.3), 1.0).normalized();
  return {60.0, [=](const Place& place) {
            return Matter{std::min({place.skin_mm + 1.0,
                                    thick_mm - place.skin_mm,
                                    half_mm - std::abs(place.mm.dot(along) - middle_mm)}),
                          hu};
          }};
}

/// A pad that the body's back, or its side, lies in.
Cover silicone(double back_mm, Dice& dice) {
  const double hu = dice(130.0, 260.0);
  const double half_mm = dice(45.0, 80.0);
  const double into_mm = dice(8.0, 22.0);
  const double thick_mm = dice(30.0, 55.0);
  const Eigen::Vector3d middle(dice(-25.0, 25.0), 0.0, dice(-20.0, 20.0));
  return {15.0, [=](const Place& place) {
            const Eigen::Vector3d from = place.mm - middle;
            const double below_mm = from.y() - (back_mm - into_mm);
            return Matter{std::min({half_mm - std::abs(from.x()),
                                    half_mm - std::abs(from.z()),
                                    below_mm,
                                    thick_mm - below_mm}),
                          hu};
          }};
}

/// One or two millimetres of cloth around the body that lies close here and in folds there.
Cover clothing(Dice& dice) {
  const double hu = dice(-350.0, -120.0);
  const double thick_mm = dice(1.5, 3.0);
  const double height_mm = dice(4.0, 10.0);
  const double phase = dice(0.0, 6.0);
  const double above_mm = dice(-30.0, 20.0);
  return {40.0, [=](const Place& place) {
            const double angle = std::atan2(place.mm.y(), place.mm.x());
            const double fold = std::sin(9.0 * angle + 0.05 * place.mm.z() + phase) *
                                std::sin(0.06 * place.mm.z() + 2.0 * angle);
            const double lifted_mm = std::max(0.0, height_mm * (fold - 0.1));
            return Matter{std::min({place.skin_mm - lifted_mm + (lifted_mm < 0.5 ? 1.0 : 0.0),
                                    lifted_mm + thick_mm - place.skin_mm,
                                    above_mm - place.mm.z()}),
                          hu};
          }};
}

/// From the skin to a place, LPS mm from the body's middle.
using SkinDistance = std::function<double(const Eigen::Vector3d&)>;

/// Along the skin in a slanted plane, on one side of the body.
class Course {
 public:
  explicit Course(Dice& dice)
      : across_(Eigen::Vector3d(dice(-0.5, 0.5), dice(-0.5, 0.5), dice(0.4, 1.0)).normalized()),
        towards_(dice.direction(3.0)),
        off_mm_(dice(-25.0, 25.0)) {}

  /// Each place of it as high over the skin as is asked for there, or higher: it is stiff, and
  /// lies over hollows that it would have to bend sharply for.
  [[nodiscard]] std::vector<Eigen::Vector3d> axis_mm(
      const SkinDistance& skin_mm,
      const std::function<double(const Eigen::Vector3d&)>& over_skin_mm) const {
    constexpr int kNumRounds = 40;
    auto axis = around(skin_mm, over_skin_mm);
    for (int round = 0; round < kNumRounds; ++round) {
      const auto before = axis;
      for (std::size_t i = 1; i + 1 < axis.size(); ++i)
        axis[i] = 0.25 * before[i - 1] + 0.5 * before[i] + 0.25 * before[i + 1];
      for (auto& place : axis) place += lift_mm(place, skin_mm, over_skin_mm(place));
    }
    return axis;
  }

 private:
  /// As it is met from outside, at even steps.
  [[nodiscard]] std::vector<Eigen::Vector3d> around(
      const SkinDistance& skin_mm,
      const std::function<double(const Eigen::Vector3d&)>& over_skin_mm) const {
    constexpr int kNumRays = 720;
    constexpr double kFarMm = 400.0;
    constexpr double kLeastStepMm = 0.2;
    constexpr double kBetweenMm = 2.0;
    const Eigen::Vector3d e1 = across_.cross(towards_).normalized();
    const Eigen::Vector3d e2 = across_.cross(e1);
    std::vector<Eigen::Vector3d> axis;
    // e2 is the way from `towards_`: the rays begin and end on the body's other side.
    for (int ray = 0; ray < kNumRays; ++ray) {
      const double angle = 2.0 * std::numbers::pi * ray / kNumRays;
      const Eigen::Vector3d away = std::sin(angle) * e1 + std::cos(angle) * e2;
      double from_mm = kFarMm;
      Eigen::Vector3d place;
      for (double above_mm = 1.0; above_mm > 0.0 && from_mm > 0.0;
           from_mm -= std::max(kLeastStepMm, above_mm)) {
        place = off_mm_ * across_ + from_mm * away;
        above_mm = skin_mm(place) - over_skin_mm(place);
      }
      if (place.dot(towards_) <= 0.0) continue;
      while (!axis.empty() && (place - axis.back()).norm() > kBetweenMm)
        axis.push_back(axis.back() + kBetweenMm * (place - axis.back()).normalized());
      if (axis.empty()) axis.push_back(place);
    }
    return axis;
  }

  /// The way out to so far over the skin.
  [[nodiscard]] static Eigen::Vector3d lift_mm(const Eigen::Vector3d& place,
                                               const SkinDistance& skin_mm,
                                               double over_mm) {
    constexpr double kBesideMm = 1.5;
    const double beneath_mm = over_mm - skin_mm(place);
    if (beneath_mm <= 0.0) return Eigen::Vector3d::Zero();
    Eigen::Vector3d outwards;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kBesideMm * Eigen::Vector3d::Unit(i);
      outwards[i] = skin_mm(place + step) - skin_mm(place - step);
    }
    return beneath_mm * outwards.stableNormalized();
  }

  Eigen::Vector3d across_;
  Eigen::Vector3d towards_;
  double off_mm_;
};

double from_line_mm(const Eigen::Vector3d& place, const std::vector<Eigen::Vector3d>& axis) {
  double least_sq_mm2 = 1e12;
  for (std::size_t i = 1; i < axis.size(); ++i) {
    const Eigen::Vector3d step = axis[i] - axis[i - 1];
    const Eigen::Vector3d from = place - axis[i - 1];
    const double share = std::clamp(from.dot(step) / step.squaredNorm(), 0.0, 1.0);
    least_sq_mm2 = std::min(least_sq_mm2, (from - share * step).squaredNorm());
  }
  return std::sqrt(least_sq_mm2);
}

Cover tube(const SkinDistance& skin_mm, Dice& dice) {
  const double radius_mm = dice(3.5, 7.0);
  const double wall_mm = dice(1.5, 2.5);
  const auto axis =
      Course(dice).axis_mm(skin_mm, [=](const Eigen::Vector3d&) { return radius_mm; });
  return {15.0, [=](const Place& place) {
            const double from_mm = from_line_mm(place.mm, axis);
            return Matter{std::min(radius_mm - from_mm, from_mm - (radius_mm - wall_mm)), 120.0};
          }};
}

/// Solid, or full of fluid; it touches the skin here and hangs over it there.
Cover line(const SkinDistance& skin_mm, Dice& dice) {
  const double hu = dice(20.0, 400.0);
  const double radius_mm = dice(1.5, 3.5);
  const double height_mm = dice(3.0, 12.0);
  const double phase = dice(0.0, 6.0);
  const auto axis = Course(dice).axis_mm(skin_mm, [=](const Eigen::Vector3d& mm) {
    const double angle = std::atan2(mm.y(), mm.x());
    return radius_mm + std::max(0.0, height_mm * std::sin(4.0 * angle + phase));
  });
  return {15.0, [=](const Place& place) {
            return Matter{radius_mm - from_line_mm(place.mm, axis), hu};
          }};
}

/// A shell behind the body that bridges its hollows; foam around it where the shell is thin.
Cover bed(double shell_hu, double shell_mm, double foam_hu, double reach_mm, Dice& dice) {
  const double behind_mm = dice(0.0, 30.0);
  const double slant = dice(-0.3, 0.3);
  return {15.0, [=](const Place& place) {
            const double beneath_mm = place.mm.y() + slant * place.mm.x() - behind_mm;
            const bool is_shell = place.hull_mm < shell_mm;
            // It fills the voxels that it shares with the skin, and is no thicker where it bridges.
            const double over_mm = place.skin_mm < 1.0 ? 1.0 : 0.0;
            return Matter{std::min({place.hull_mm + over_mm,
                                    (foam_hu > kAirHu ? reach_mm : shell_mm) - place.hull_mm,
                                    beneath_mm}),
                          is_shell ? shell_hu : foam_hu};
          }};
}

Cover cover_of(const std::string& kind,
               double back_mm,
               const SkinDistance& skin_mm,
               unsigned seed) {
  Dice dice(seed);
  const std::map<std::string, std::function<Cover()>> kinds = {
      {"blanket-400", [&] { return blanket(-400.0, false, dice); }},
      {"blanket-300", [&] { return blanket(-300.0, false, dice); }},
      {"blanket-200", [&] { return blanket(-200.0, false, dice); }},
      {"blanket-150", [&] { return blanket(-150.0, false, dice); }},
      {"flat-300", [&] { return blanket(-300.0, true, dice); }},
      {"flat-150", [&] { return blanket(-150.0, true, dice); }},
      {"clothing", [&] { return clothing(dice); }},
      {"plaster", [&] { return plaster(6.0, 10.0, dice); }},
      {"plaster-thin", [&] { return plaster(4.0, 6.0, dice); }},
      {"silicone", [&] { return silicone(back_mm, dice); }},
      {"tube", [&] { return tube(skin_mm, dice); }},
      {"line", [&] { return line(skin_mm, dice); }},
      {"headrest", [&] { return bed(90.0, 3.0, kAirHu, 0.0, dice); }},
      {"mattress", [&] { return bed(20.0, 1.2, -880.0, 40.0, dice); }}};
  return kinds.at(kind)();
}

/// What the voxel would be without air in it: the densest of the body around it, skin at most.
double flesh_hu(const BareBody& bare, int x, int y, int z) {
  constexpr double kMostHu = 60.0;
  double most_hu = -1e9;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::array<int, 3> at = {x + dx, y + dy, z + dz};
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
          is_in = is_in && at[axis] >= 0 && at[axis] < bare.volume.size[axis];
        if (is_in && bare.body.test(at[0], at[1], at[2]))
          most_hu =
              std::max<double>(most_hu, bare.volume.hu[bare.volume.index(at[0], at[1], at[2])]);
      }
    }
  }
  return most_hu < -500.0 ? 40.0 : std::min(most_hu, kMostHu);
}

/// Between the voxels; beyond the scan the body goes on as it ends.
double over_skin_mm(const BareBody& bare, const Eigen::Vector3d& grid_mm) {
  const Volume& ct = bare.volume;
  const Eigen::Vector3d at = grid_mm.cwiseQuotient(ct.spacing_mm);
  std::array<int, 3> low{};
  std::array<double, 3> share{};
  Eigen::Vector3d beyond_mm = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double inside = std::clamp(at[axis], 0.0, ct.size[i] - 1.0);
    if (axis < 2) beyond_mm[axis] = (at[axis] - inside) * ct.spacing_mm[axis];
    low[i] = std::min(static_cast<int>(inside), ct.size[i] - 2);
    share[i] = inside - low[i];
  }
  double sum_mm = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> up = {corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = 1.0;
    for (std::size_t i = 0; i < 3; ++i) weight *= up[i] != 0 ? share[i] : 1.0 - share[i];
    sum_mm += weight * bare.from_body_mm[ct.index(low[0] + up[0], low[1] + up[1], low[2] + up[2])];
  }
  return std::hypot(sum_mm, beyond_mm.norm());  // At least so much.
}

BitMask farther_than(double least_mm, const BitMask& from, const Eigen::Vector3d& spacing_mm) {
  const auto mm = distance_mm(from, spacing_mm);
  BitMask far(from.size());
  std::size_t i = 0;
  for (int z = 0; z < far.size()[2]; ++z)
    for (int y = 0; y < far.size()[1]; ++y)
      for (int x = 0; x < far.size()[0]; ++x)
        if (mm[i++] > least_mm) far.set_run(y, z, x, x + 1);
  return far;
}

/// Beyond the scan's sides there is room for a sheet's bends: it must not be drawn through an ear
/// that lies near to one.
std::vector<float> from_hull_mm(const BareBody& bare) {
  const Volume& ct = bare.volume;
  const auto margin = [&](int axis) {
    return static_cast<int>(std::ceil((kHullMm + 1.0) / ct.spacing_mm[axis]));
  };
  const int margin_x = margin(0);
  const int margin_y = margin(1);
  BitMask body({ct.size[0] + 2 * margin_x, ct.size[1] + 2 * margin_y, ct.size[2]});
  for_each_voxel(bare.body, [&](const std::array<int, 3>& voxel) {
    const int x = voxel[0] + margin_x;
    body.set_run(voxel[1] + margin_y, voxel[2], x, x + 1);
  });
  const auto far_mm = distance_mm(farther_than(kHullMm, body, ct.spacing_mm), ct.spacing_mm);
  std::vector<float> hull_mm(ct.num_voxels());
  for_each(ct, [&](int x, int y, int z) {
    const std::size_t row = static_cast<std::size_t>(z) * body.size()[1] + (y + margin_y);
    hull_mm[ct.index(x, y, z)] =
        static_cast<float>(kHullMm) - far_mm[row * body.size()[0] + (x + margin_x)];
  });
  return hull_mm;
}

}  // namespace

BareBody bare_body(const Volume& ct) {
  BareBody bare;
  const auto without = internal::bare_ct(ct);
  bare.volume = without.volume ? *without.volume : ct;
  const BitMask near =
      dilated(internal::body_mask(ct, without, {}, {}).value().body, 2.5, ct.spacing_mm);
  for_each(ct, [&](int x, int y, int z) {
    if (!near.test(x, y, z)) bare.volume.hu[ct.index(x, y, z)] = static_cast<std::int16_t>(kAirHu);
  });
  bare.body = internal::body_mask(bare.volume, internal::bare_ct(bare.volume), {}, {}).value().body;
  bare.skin = internal::marching_cubes(bare.volume, bare.body, kThresholdHu);
  bare.from_body_mm = distance_mm(bare.body, ct.spacing_mm);
  bare.from_hull_mm = from_hull_mm(bare);
  return bare;
}

std::vector<std::string> cover_kinds() {
  return {"blanket-400",
          "blanket-300",
          "blanket-200",
          "blanket-150",
          "flat-300",
          "flat-150",
          "clothing",
          "plaster",
          "plaster-thin",
          "silicone",
          "tube",
          "line",
          "headrest",
          "mattress"};
}

Covered covered(const BareBody& bare, const std::string& kind, unsigned seed) {
  Covered scene{bare.volume, BitMask(bare.volume.size)};
  const internal::Components parts(bare.body);
  const auto& box = parts.parts()[parts.largest()];
  const auto ct_from_voxel = [&](const Eigen::Vector3d& voxel) -> Eigen::Vector3d {
    return bare.volume.ct_from_grid * voxel.cwiseProduct(bare.volume.spacing_mm);
  };
  const Eigen::Vector3d low = ct_from_voxel(Eigen::Vector3d(box.low_x, box.low_y, box.low_z));
  const Eigen::Vector3d high = ct_from_voxel(Eigen::Vector3d(box.high_x, box.high_y, box.high_z));
  const Eigen::Vector3d middle = 0.5 * (low + high);
  const Eigen::Isometry3d grid_from_ct = bare.volume.ct_from_grid.inverse();
  const auto from_skin_mm = [&](const Eigen::Vector3d& mm) {
    return over_skin_mm(bare, grid_from_ct * (mm + middle));
  };
  const Cover cover = cover_of(kind, std::abs(high.y() - middle.y()), from_skin_mm, seed);
  constexpr double kReachMm = 70.0;
  for_each(bare.volume, [&](int x, int y, int z) {
    const std::size_t i = bare.volume.index(x, y, z);
    // The body's outermost voxels hold some air, deeper ones none.
    const double skin_mm = bare.from_body_mm[i];
    if (skin_mm > kReachMm) return;
    const auto is_beside = [&](int dx, int dy, int dz) {
      const std::array<int, 3> at = {x + dx, y + dy, z + dz};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (at[axis] < 0 || at[axis] >= bare.volume.size[axis]) return false;
      return !bare.body.test(at[0], at[1], at[2]);
    };
    if (skin_mm == 0.0 && !is_beside(1, 0, 0) && !is_beside(-1, 0, 0) && !is_beside(0, 1, 0) &&
        !is_beside(0, -1, 0) && !is_beside(0, 0, 1) && !is_beside(0, 0, -1))
      return;
    const Place place = {ct_from_voxel(Eigen::Vector3d(x, y, z)) - middle,
                         skin_mm,
                         std::min<double>(skin_mm, bare.from_hull_mm[i])};
    const Matter matter = cover.at(place);
    const double share = std::clamp(matter.depth_mm / bare.volume.spacing_mm.x() + 0.5, 0.0, 1.0);
    if (share == 0.0) return;
    auto& hu = scene.volume.hu[i];
    const double flesh = flesh_hu(bare, x, y, z);
    const double air = std::clamp((flesh - hu) / (flesh - kAirHu), 0.0, 1.0);
    std::minstd_rand random(static_cast<unsigned>(i) * 2654435761U + seed + 1U);
    random.discard(3);
    const double noise = std::normal_distribution(0.0, cover.noise_hu)(random);
    hu = static_cast<std::int16_t>(std::lround(hu + air * share * (matter.hu + noise - kAirHu)));
    if (share >= 0.5 && air >= 0.5 && matter.hu > -900.0) scene.cover.set_run(y, z, x, x + 1);
  });
  return scene;
}

Distances distances_at(const TriangleMesh& from, const TriangleMesh& to, const Covered& scene) {
  constexpr double kNearMm = 2.5;
  constexpr std::size_t kMost = 4000;
  const BitMask near = dilated(scene.cover, kNearMm, scene.volume.spacing_mm);
  const Eigen::Isometry3d grid_from_ct = scene.volume.ct_from_grid.inverse();
  std::vector<Eigen::Vector3f> places;
  for (const auto& vertex : from.vertices) {
    const Eigen::Vector3i at = scene.volume.nearest_voxel(grid_from_ct * vertex.cast<double>());
    if (near.test(at.x(), at.y(), at.z())) places.push_back(vertex);
  }
  if (places.empty()) return {};
  std::mt19937 random(1);
  std::shuffle(places.begin(), places.end(), random);
  places.resize(std::min(places.size(), kMost));
  std::vector<double> all(places.size());
  const internal::TriangleGrid grid(to);
  tbb::parallel_for(
      std::size_t{0}, places.size(), [&](std::size_t i) { all[i] = grid.distance_mm(places[i]); });
  std::sort(all.begin(), all.end());
  const auto num_above = all.end() - std::upper_bound(all.begin(), all.end(), 1.0);
  const auto at = [&](std::size_t percent) { return all[(all.size() - 1) * percent / 100]; };
  return {all.size(),
          at(50),
          at(95),
          at(99),
          all.back(),
          static_cast<double>(num_above) / static_cast<double>(all.size())};
}

}  // namespace mor::testing_covers
