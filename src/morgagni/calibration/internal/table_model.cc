// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/internal/table_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include <Eigen/Eigenvalues>

namespace mor::internal {
namespace {

/// A table's unevenness: standard deviation and reach.
constexpr double kUnevenMm = 1.5;
constexpr double kReachMm = 150.0;
constexpr double kSpacingMm = 0.8 * kReachMm;
/// How far off the plane as first found may be.
constexpr double kHeightMm = 10.0;
constexpr double kTiltRad = 0.03;

constexpr std::size_t kMostSamples = 4000;
constexpr std::size_t kLeastSamples = 500;
constexpr int kTrials = 400;
/// Three places span a plane where they lie well apart: their triangle's area, twice.
constexpr double kLeastAcrossMm2 = 5000.0;
constexpr double kOnPlaneMm = 12.0;
/// Of what is seen beside the body, so much must lie on it.
constexpr double kLeastShare = 0.3;
/// The plane lies this far under the body's middle at least: beside it, it is a wall.
constexpr double kLeastBelowMm = 20.0;

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_mm = 0.0;

  [[nodiscard]] bool holds(const Eigen::Vector3d& p) const {
    return std::abs(normal.dot(p) - offset_mm) < kOnPlaneMm;
  }
};

std::vector<Eigen::Vector3d> places_beside(const std::vector<SensedSkin>& views,
                                           const PinholeCamera& camera) {
  std::size_t count = 0;
  for (const auto& view : views) count += view.beside.size();
  const std::size_t step = std::max<std::size_t>(1, count / kMostSamples);
  std::vector<Eigen::Vector3d> places_mm;
  std::size_t at = 0;
  for (const auto& view : views) {
    for (const auto& reading : view.beside) {
      if (at++ % step != 0) continue;
      const Eigen::Vector2d ray = camera.ray(reading.pixel.cast<double>());
      places_mm.emplace_back(view.ct_from_depth * (static_cast<double>(reading.z_mm) *
                                                   Eigen::Vector3d(ray.x(), ray.y(), 1.0)));
    }
  }
  return places_mm;
}

/// Random sample consensus (Fischler & Bolles 1981), with a fixed seed.
Plane fullest_plane(const std::vector<Eigen::Vector3d>& places_mm) {
  std::mt19937 random(1);
  Plane best;
  std::ptrdiff_t most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto& a = places_mm[random() % places_mm.size()];
    const auto& b = places_mm[random() % places_mm.size()];
    const auto& c = places_mm[random() % places_mm.size()];
    const Eigen::Vector3d across = (b - a).cross(c - a);
    if (across.norm() < kLeastAcrossMm2) continue;
    const Eigen::Vector3d normal = across.normalized();
    const Plane plane{normal, normal.dot(a)};
    const auto count =
        std::ranges::count_if(places_mm, [&](const auto& p) { return plane.holds(p); });
    if (count > most) {
      most = count;
      best = plane;
    }
  }
  return best;
}

Plane fitted(const std::vector<Eigen::Vector3d>& on_it_mm) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : on_it_mm) mean += p / static_cast<double>(on_it_mm.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : on_it_mm) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return {normal, normal.dot(mean)};
}

std::vector<Eigen::Vector3d> those_on(const Plane& plane,
                                      const std::vector<Eigen::Vector3d>& places_mm) {
  std::vector<Eigen::Vector3d> on_it_mm;
  std::ranges::copy_if(
      places_mm, std::back_inserter(on_it_mm), [&](const auto& p) { return plane.holds(p); });
  return on_it_mm;
}

}  // namespace

std::optional<TableModel> TableModel::find(const std::vector<SensedSkin>& views,
                                           const PinholeCamera& camera,
                                           const Eigen::Vector3d& body_mm) {
  const auto places_mm = places_beside(views, camera);
  if (places_mm.size() < kLeastSamples) return std::nullopt;
  Plane plane = fullest_plane(places_mm);
  auto on_it_mm = those_on(plane, places_mm);
  if (on_it_mm.size() < kLeastSamples) return std::nullopt;
  plane = fitted(on_it_mm);
  on_it_mm = those_on(plane, places_mm);
  if (static_cast<double>(on_it_mm.size()) < kLeastShare * static_cast<double>(places_mm.size())) {
    return std::nullopt;
  }
  if (plane.normal.dot(body_mm) < plane.offset_mm) {
    plane = {-plane.normal, -plane.offset_mm};
  }
  const bool is_under_all = std::ranges::all_of(views, [&](const auto& view) {
    return plane.normal.dot(view.ct_from_depth.translation()) > plane.offset_mm;
  });
  if (!is_under_all || plane.normal.dot(body_mm) - plane.offset_mm < kLeastBelowMm) {
    return std::nullopt;
  }
  TableModel table;
  table.set_plane(plane.normal, plane.offset_mm);
  table.touch(on_it_mm);
  return table;
}

void TableModel::set_plane(const Eigen::Vector3d& normal, double offset_mm) {
  normal_ = normal;
  offset_mm_ = offset_mm;
  axes_.row(0) = normal.unitOrthogonal().transpose();
  axes_.row(1) = normal.cross(axes_.row(0).transpose()).transpose();
}

Eigen::Vector2d TableModel::on_plane(const Eigen::Vector3d& ct_mm) const {
  return axes_ * ct_mm / kSpacingMm;
}

void TableModel::touch(const std::vector<Eigen::Vector3d>& places_mm) {
  for (const auto& place : places_mm) {
    const Eigen::Vector2d at = on_plane(place).array().floor();
    for (int corner = 0; corner < 4; ++corner) {
      nodes_[{static_cast<int>(at.y()) + corner / 2, static_cast<int>(at.x()) + corner % 2}] = 0;
    }
  }
  std::uint16_t number = 0;
  for (auto& [node, index] : nodes_) {
    index = number++;
    middle_ += Eigen::Vector2d(node.second, node.first) / static_cast<double>(nodes_.size());
  }
}

ExpectedReading TableModel::expected(const SkinReading& reading,
                                     const PinholeCamera& camera,
                                     const Eigen::Isometry3d& ct_from_depth) const {
  const Eigen::Vector3d normal = ct_from_depth.linear().transpose() * normal_;
  const double distance_mm = offset_mm_ - normal_.dot(ct_from_depth.translation());
  const auto z_at = [&](double x, double y) {
    const Eigen::Vector2d ray = camera.ray(Eigen::Vector2d(x, y));
    return distance_mm / (normal.x() * ray.x() + normal.y() * ray.y() + normal.z());
  };
  double sum_mm = 0.0;
  for (int i = 0; i < SkinReading::kBlockPx * SkinReading::kBlockPx; ++i) {
    if (((reading.used >> i) & 1U) == 0) continue;
    const double z_mm = z_at(SkinReading::kBlockPx * reading.column + i % SkinReading::kBlockPx,
                             SkinReading::kBlockPx * reading.row + i / SkinReading::kBlockPx);
    if (!(z_mm > 0.0)) return {};
    sum_mm += z_mm;
  }
  const double mean_mm = sum_mm / std::popcount(reading.used);
  // 1 / z of a plane is linear over the picture, so z bends by 2 slope^2 / z, which a blur lifts.
  const double x = static_cast<double>(reading.pixel.x());
  const double y = static_cast<double>(reading.pixel.y());
  const double slope_x = z_at(x + 0.5, y) - z_at(x - 0.5, y);
  const double slope_y = z_at(x, y + 0.5) - z_at(x, y - 0.5);
  const double lift_mm =
      kReadingBlurPx * kReadingBlurPx * (slope_x * slope_x + slope_y * slope_y) / mean_mm;
  ExpectedReading result;
  result.z_mm = static_cast<float>(mean_mm + lift_mm);
  result.normal = normal.cast<float>();
  return result;
}

Eigen::MatrixXd TableModel::prior_covariance() const {
  std::vector<Eigen::Vector2d> places_mm;
  for (const auto& [node, index] : nodes_) {
    places_mm.emplace_back(kSpacingMm * (Eigen::Vector2d(node.second, node.first) - middle_));
  }
  const auto count = static_cast<Eigen::Index>(places_mm.size());
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& a = places_mm[static_cast<std::size_t>(i)];
      const auto& b = places_mm[static_cast<std::size_t>(k)];
      covariance(i, k) =
          kHeightMm * kHeightMm + kTiltRad * kTiltRad * a.dot(b) +
          kUnevenMm * kUnevenMm * std::exp(-0.5 * (a - b).squaredNorm() / (kReachMm * kReachMm));
    }
  }
  covariance.diagonal().array() += 1e-3 * kUnevenMm * kUnevenMm;
  return covariance;
}

bool TableModel::weights(const Eigen::Vector3d& ct_mm,
                         std::span<std::uint16_t, kNumTouched> index,
                         std::span<float, kNumTouched> share) const {
  const Eigen::Vector2d at = on_plane(ct_mm);
  const Eigen::Vector2d cell = at.array().floor();
  const Eigen::Vector2d in_cell = at - cell;
  for (int corner = 0; corner < 4; ++corner) {
    const auto node = nodes_.find(
        {static_cast<int>(cell.y()) + corner / 2, static_cast<int>(cell.x()) + corner % 2});
    if (node == nodes_.end()) return false;
    const auto i = static_cast<std::size_t>(corner);
    index[i] = node->second;
    share[i] = static_cast<float>((corner / 2 == 1 ? in_cell.y() : 1.0 - in_cell.y()) *
                                  (corner % 2 == 1 ? in_cell.x() : 1.0 - in_cell.x()));
  }
  return true;
}

}  // namespace mor::internal
