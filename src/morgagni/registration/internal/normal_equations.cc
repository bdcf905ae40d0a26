// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/normal_equations.h"

#include <algorithm>
#include <array>

namespace mor::internal {
namespace {

constexpr float kNearMm = 5.0F;
/// What an unknown node says of itself: below any distance of a field.
constexpr float kUnknownMm = static_cast<float>(FieldNode::kNoSurface) / FieldNode::kUnitsPerMm;
/// Groups whose nodes are asked of memory together, ahead of their use.
constexpr std::size_t kBatch = 8;
/// Groups that are summed in float before they go into the sums in double.
constexpr std::size_t kFloatGroups = 32;

/// A level's grid with what finding nodes in it needs.
class NodeFinder {
 public:
  explicit NodeFinder(const FieldLevel& level)
      : level_(level), origin_mm_(level.origin_mm), per_spacing_(1.0F / level.spacing_mm) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last_[axis] = static_cast<float>((level.bricks[axis] << FieldLevel::kBrickShift) - 1);
    }
  }

  /// The node's coordinate along an axis that is nearest to `p`, cut to the grid; `offset_mm` is
  /// set to p minus it.
  [[nodiscard]] IntLanes nearest(const Lanes& p, int axis, Lanes& offset_mm) const {
    const Lanes grid = (p - origin_mm_[axis]) * per_spacing_ + 0.5F;
    const Lanes last = Lanes{} + last_[static_cast<std::size_t>(axis)];
    const IntLanes node = __builtin_convertvector(min_of(max_of(grid, Lanes{}), last), IntLanes);
    offset_mm = p - origin_mm_[axis] - level_.spacing_mm * __builtin_convertvector(node, Lanes);
    return node;
  }

  /// Sets `nodes` to those of a group, and asks memory for them.
  void find(const IntLanes& x,
            const IntLanes& y,
            const IntLanes& z,
            const FieldNode** nodes) const {
    constexpr int kShift = FieldLevel::kBrickShift;
    constexpr int kMask = FieldLevel::kBrickSide - 1;
    const IntLanes brick =
        ((z >> kShift) * level_.bricks[1] + (y >> kShift)) * level_.bricks[0] + (x >> kShift);
    const IntLanes inside = ((((z & kMask) << kShift) | (y & kMask)) << kShift) | (x & kMask);
    for (int i = 0; i < kLanes; ++i) {
      nodes[i] = level_.nodes.data() +
                 level_.index[static_cast<std::size_t>(brick[i])] * FieldLevel::kBrickNodes +
                 static_cast<std::size_t>(inside[i]);
      __builtin_prefetch(nodes[i]);
    }
  }

 private:
  const FieldLevel& level_;
  Eigen::Vector3f origin_mm_;
  float per_spacing_;
  std::array<float, 3> last_{};
};

/// Tukey's biweight (Beaton & Tukey, Technometrics 16, 1974): (1 - (d / scale)^2)^2, 0 beyond.
[[nodiscard]] Lanes tukey_weight(const Lanes& distance_mm, const Lanes& per_scale) {
  const Lanes ratio = distance_mm * per_scale;
  const Lanes rest = max_of(1.0F - ratio * ratio, Lanes{});
  return rest * rest;
}

/// The sums of a linearisation, lane by lane, in a fixed order.
class Sums {
 public:
  void add(const Lanes& x,
           const Lanes& y,
           const Lanes& z,
           const Lanes& normal_x,
           const Lanes& normal_y,
           const Lanes& normal_z,
           const Lanes& distance_mm,
           const Lanes& weight) {
    const std::array<Lanes, 8> row = {y * normal_z - z * normal_y,
                                      z * normal_x - x * normal_z,
                                      x * normal_y - y * normal_x,
                                      normal_x,
                                      normal_y,
                                      normal_z,
                                      distance_mm,
                                      Lanes{} + 1.0F};
    std::size_t k = 0;
    for (std::size_t a = 0; a < row.size(); ++a) {
      const Lanes weighted = weight * row[a];
      for (std::size_t b = a; b < row.size(); ++b) products_[k++] += weighted * row[b];
    }
    if (++count_ == kFloatGroups) flush();
  }

  [[nodiscard]] Eigen::Matrix<double, 8, 8> finish() {
    flush();
    Eigen::Matrix<double, 8, 8> sums;
    std::size_t k = 0;
    for (int a = 0; a < 8; ++a) {
      for (int b = a; b < 8; ++b) sums(a, b) = sums(b, a) = sums_[k++];
    }
    return sums;
  }

 private:
  static constexpr std::size_t kProducts = 36;

  void flush() {
    for (std::size_t k = 0; k < kProducts; ++k) sums_[k] += sum_of(products_[k]);
    products_ = {};
    count_ = 0;
  }

  std::array<Lanes, kProducts> products_{};
  std::array<double, kProducts> sums_{};
  std::size_t count_ = 0;
};

}  // namespace

void Linearizer::find_pairs(const FieldLevel& level,
                            const SensorPoints& points,
                            const Eigen::Isometry3f& fixed_from_moving,
                            const PairingRule& rule) {
  const Eigen::Matrix3f r = fixed_from_moving.linear();
  const Eigen::Vector3f camera = fixed_from_moving.translation();
  const NodeFinder finder(level);
  const Lanes per_above = Lanes{} + 1.0F / rule.above_scale_mm;
  const Lanes per_below = Lanes{} + 1.0F / rule.below_scale_mm;
  const float reach_mm = 0.51F * level.spacing_mm;
  pairs_.resize(points.groups.size());
  std::array<const FieldNode*, kBatch * kLanes> nodes{};
  for (std::size_t first = 0; first < pairs_.size(); first += kBatch) {
    const std::size_t end = std::min(first + kBatch, pairs_.size());
    for (std::size_t g = first; g < end; ++g) {
      const PointLanes& moving = points.groups[g];
      PairLanes& pair = pairs_[g];
      pair.x = r(0, 0) * moving.x + r(0, 1) * moving.y + r(0, 2) * moving.z + camera.x();
      pair.y = r(1, 0) * moving.x + r(1, 1) * moving.y + r(1, 2) * moving.z + camera.y();
      pair.z = r(2, 0) * moving.x + r(2, 1) * moving.y + r(2, 2) * moving.z + camera.z();
      finder.find(finder.nearest(pair.x, 0, pair.normal_x),
                  finder.nearest(pair.y, 1, pair.normal_y),
                  finder.nearest(pair.z, 2, pair.normal_z),
                  &nodes[(g - first) * kLanes]);
    }
    for (std::size_t g = first; g < end; ++g) {
      const PointLanes& moving = points.groups[g];
      PairLanes& pair = pairs_[g];
      Lanes distance = {}, x = {}, y = {}, z = {};
      for (int i = 0; i < kLanes; ++i) {
        const FieldNode& node = *nodes[(g - first) * kLanes + static_cast<std::size_t>(i)];
        distance[i] = static_cast<float>(node.distance);
        x[i] = static_cast<float>(node.normal[0]);
        y[i] = static_cast<float>(node.normal[1]);
        z[i] = static_cast<float>(node.normal[2]);
      }
      constexpr float kPerNormal = 1.0F / FieldNode::kUnitsPerNormal;
      x *= kPerNormal;
      y *= kPerNormal;
      z *= kPerNormal;
      // Outside the grid the nearest node is farther than half a step.
      const auto outside = max_of(max_of(pair.normal_x, -pair.normal_x),
                                  max_of(max_of(pair.normal_y, -pair.normal_y),
                                         max_of(pair.normal_z, -pair.normal_z))) > reach_mm;
      distance = distance * (1.0F / FieldNode::kUnitsPerMm) + x * pair.normal_x +
                 y * pair.normal_y + z * pair.normal_z;
      distance = outside ? Lanes{} + kUnknownMm : distance;
      // The camera sees only what faces it: not the far side of a hand or head.
      const Lanes facing =
          x * (pair.x - camera.x()) + y * (pair.y - camera.y()) + z * (pair.z - camera.z());
      const Lanes along =
          x * (r(0, 0) * moving.normal_x + r(0, 1) * moving.normal_y + r(0, 2) * moving.normal_z) +
          y * (r(1, 0) * moving.normal_x + r(1, 1) * moving.normal_y + r(1, 2) * moving.normal_z) +
          z * (r(2, 0) * moving.normal_x + r(2, 1) * moving.normal_y + r(2, 2) * moving.normal_z);
      const Lanes kernel = tukey_weight(distance, distance > 0.0F ? per_above : per_below);
      const auto compatible = (facing < 0.0F) & (along >= rule.min_normal_cosine);
      pair.weight = compatible ? moving.weight * kernel : Lanes{};
      const auto near = (distance <= kNearMm) & (distance >= -kNearMm);
      pair.near_weight = (facing < 0.0F) & near ? moving.weight : Lanes{};
      pair.distance_mm = distance;
      pair.normal_x = x;
      pair.normal_y = y;
      pair.normal_z = z;
    }
  }
}

void Linearizer::weigh_by_rows(const SensorPoints& points, const PairingRule& rule) {
  row_sums_mm_.resize(pairs_.size() * kLanes + 1);
  const Lanes above = Lanes{} + rule.above_scale_mm;
  const Lanes below = Lanes{} - rule.below_scale_mm;
  std::size_t i = 0;
  double sum_mm = 0.0;
  for (const PairLanes& pair : pairs_) {
    const Lanes known = pair.distance_mm <= kUnknownMm ? above : pair.distance_mm;
    const Lanes cut = min_of(max_of(known, below), above);
    for (int lane = 0; lane < kLanes; ++lane) {
      row_sums_mm_[i++] = sum_mm;
      sum_mm += static_cast<double>(cut[lane]);
    }
  }
  row_sums_mm_[i] = sum_mm;
  i = 0;
  const Lanes per_above = Lanes{} + 1.0F / rule.row_above_scale;
  const Lanes per_below = Lanes{} + 1.0F / rule.row_below_scale;
  for (std::size_t g = 0; g < pairs_.size(); ++g) {
    Lanes mean_mm = {};
    for (int lane = 0; lane < kLanes && i < points.size; ++lane, ++i) {
      const RowReach& row = points.rows[i];
      const double sum_of_row = row_sums_mm_[i + row.after + 1] - row_sums_mm_[i - row.before];
      mean_mm[lane] =
          static_cast<float>(sum_of_row) / static_cast<float>(row.before + row.after + 1);
    }
    const Lanes ratio = mean_mm * (mean_mm > 0.0F ? per_above : per_below);
    // A point's weight is 1 / its variance.
    const Lanes rest = max_of(1.0F - ratio * ratio * points.groups[g].weight, Lanes{});
    pairs_[g].weight *= rest * rest;
  }
}

double Linearizer::mean_sq_between_rows(const SensorPoints& points) const {
  constexpr std::size_t kRow = 2 * kRowReach + 1;
  // Of the pairs before each: the sum of their distances, and their number.
  std::vector<double> sums_mm(pairs_.size() * kLanes + 1);
  std::vector<std::uint32_t> counts(sums_mm.size());
  double sum_mm = 0.0;
  std::uint32_t num_pairs = 0;
  std::size_t before = 0;
  for (const PairLanes& pair : pairs_) {
    const auto is_pair = pair.weight > 0.0F;
    const Lanes distance_mm = is_pair ? pair.distance_mm : Lanes{};
    for (int lane = 0; lane < kLanes; ++lane) {
      sum_mm += static_cast<double>(distance_mm[lane]);
      num_pairs += is_pair[lane] != 0 ? 1 : 0;
      sums_mm[++before] = sum_mm;
      counts[before] = num_pairs;
    }
  }
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = kRowReach; i + kRowReach + kRow < points.size; ++i) {
    const std::size_t begin = i - kRowReach;
    const bool is_one_surface =
        points.rows[i].before == kRowReach && points.rows[i].after == kRowReach &&
        points.rows[i + kRowReach].after > 0 && points.rows[i + kRow].before == kRowReach &&
        points.rows[i + kRow].after == kRowReach;
    if (!is_one_surface || counts[begin + 2 * kRow] - counts[begin] < 2 * kRow) continue;
    const double apart_mm =
        (sums_mm[begin + 2 * kRow] - 2.0 * sums_mm[begin + kRow] + sums_mm[begin]) / kRow;
    // A point's weight is 1 / its variance.
    const auto lane = static_cast<int>(i % kLanes);
    sum += static_cast<double>(points.groups[i / kLanes].weight[lane]) * apart_mm * apart_mm;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

std::vector<Eigen::Vector3f> Linearizer::some_pairs(std::size_t count) const {
  const std::size_t stride = std::max<std::size_t>(1, pairs_.size() * kLanes / count);
  std::vector<Eigen::Vector3f> points;
  points.reserve(count + kLanes);
  for (std::size_t i = 0; i < pairs_.size() * kLanes; i += stride) {
    const PairLanes& pair = pairs_[i / kLanes];
    const auto lane = static_cast<int>(i % kLanes);
    if (pair.weight[lane] > 0.0F) points.emplace_back(pair.x[lane], pair.y[lane], pair.z[lane]);
  }
  return points;
}

NormalEquations Linearizer::linearize(const FieldLevel& level,
                                      const SensorPoints& points,
                                      const Eigen::Isometry3d& fixed_from_moving,
                                      const Eigen::Vector3d& pivot,
                                      const PairingRule& rule) {
  find_pairs(level, points, fixed_from_moving.cast<float>(), rule);
  if (rule.row_above_scale > 0.0F) weigh_by_rows(points, rule);
  const Eigen::Vector3f pivot_mm = pivot.cast<float>();
  Sums sums;
  Lanes near_weight = {};
  IntLanes num_pairs = {};
  IntLanes num_near = {};
  IntLanes num_below = {};
  for (const PairLanes& pair : pairs_) {
    sums.add(pair.x - pivot_mm.x(),
             pair.y - pivot_mm.y(),
             pair.z - pivot_mm.z(),
             pair.normal_x,
             pair.normal_y,
             pair.normal_z,
             pair.distance_mm,
             pair.weight);
    near_weight += pair.near_weight;
    // A mask's lanes are -1 where it holds.
    num_pairs -= pair.weight > 0.0F;
    num_near -= (pair.distance_mm <= kNearMm) & (pair.distance_mm >= -kNearMm);
    num_below -= (pair.distance_mm < -kNearMm) & (pair.distance_mm > kUnknownMm);
  }
  const Eigen::Matrix<double, 8, 8> all = sums.finish();
  NormalEquations equations;
  equations.information = all.topLeftCorner<6, 6>();
  equations.gradient = all.block<6, 1>(0, 6);
  equations.sum_weighted_sq = all(6, 6);
  equations.sum_weights = all(7, 7);
  equations.sum_near_weights = sum_of(near_weight);
  for (int i = 0; i < kLanes; ++i) {
    equations.num_pairs += num_pairs[i];
    equations.num_near += num_near[i];
    equations.num_below += num_below[i];
  }
  return equations;
}

}  // namespace mor::internal
