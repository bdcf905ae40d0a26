// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/thin_sheet.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Dense>

namespace mor::internal {
namespace {

/// A column through a sheet is at most so long: 3 mm of shell, seen at 45 degrees, and its blur.
constexpr double kThinMm = 6.0;
/// From column to column a sheet rises at most by this share of the step.
constexpr double kSteepest = 1.3;
/// A sheet is larger than an ear.
constexpr double kLeastSheetMm2 = 2500.0;
/// So near to something thicker the sheet's own inner side is not seen.
constexpr double kFilletMm = 3.0;
/// Sheet within this distance says how it goes on; farther on nobody knows.
constexpr double kReachMm = 18.0;
constexpr int kLeastNeighbours = 12;

/// Outermost stretch of the part in one column, in mm along the outward direction.
struct Column {
  bool is_there = false;
  bool is_sheet = false;
  double outer_mm = 0.0;
  double length_mm = 0.0;
};

/// The sheet as a height over a plane of the grid, looking inwards along x or y.
class SheetMap {
 public:
  SheetMap(const BitMask& part,
           const Eigen::Vector3d& middle,
           const Eigen::Vector3d& spacing_mm,
           int axis,
           int sign)
      : part_(part),
        middle_(middle),
        axis_(axis),
        sign_(sign),
        width_(part.size()[static_cast<std::size_t>(1 - axis)]),
        height_(part.size()[2]),
        step_mm_(spacing_mm[1 - axis], spacing_mm.z()),
        depth_step_mm_(spacing_mm[axis]),
        columns_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {
    for (int z = 0; z < height_; ++z)
      for (int u = 0; u < width_; ++u) at(u, z) = measured(u, z);
  }

  /// Adds what of the part is sheet to `sheet`.
  void mark(BitMask& sheet) {
    if (!find_sheet()) return;
    step_back_from_thicker_places();
    for (int z = 0; z < height_; ++z) {
      for (int u = 0; u < width_; ++u) {
        if (!at(u, z).is_there) continue;
        if (const auto inner_mm = inner_side_mm(u, z)) mark_column(u, z, *inner_mm, sheet);
      }
    }
  }

 private:
  Column& at(int u, int z) { return columns_[static_cast<std::size_t>(z) * width_ + u]; }
  [[nodiscard]] const Column& at(int u, int z) const {
    return columns_[static_cast<std::size_t>(z) * width_ + u];
  }
  [[nodiscard]] bool is_in(int u, int z) const {
    return u >= 0 && z >= 0 && u < width_ && z < height_;
  }
  [[nodiscard]] bool is_part(int u, int z, int depth) const {
    return axis_ == 0 ? part_.test(depth, u, z) : part_.test(u, depth, z);
  }
  [[nodiscard]] int num_deep() const { return part_.size()[static_cast<std::size_t>(axis_)]; }
  [[nodiscard]] double outward_mm(int depth) const { return sign_ * depth * depth_step_mm_; }

  /// From outside up to the middle of the body: what lies beyond is the other side's.
  [[nodiscard]] Column measured(int u, int z) const {
    const int from = sign_ > 0 ? num_deep() - 1 : 0;
    const int last = static_cast<int>(middle_[axis_]);
    Column column;
    int num_voxels = 0;
    for (int depth = from; depth != last; depth -= sign_) {
      if (depth < 0 || depth >= num_deep()) break;
      if (!is_part(u, z, depth)) {
        if (num_voxels > 0) break;
        continue;
      }
      if (num_voxels++ == 0) column.outer_mm = outward_mm(depth);
    }
    column.is_there = num_voxels > 0;
    column.length_mm = num_voxels * depth_step_mm_;
    return column;
  }

  [[nodiscard]] bool is_thin(const Column& column) const {
    return column.is_there && column.length_mm <= kThinMm;
  }

  /// The largest smooth patch of thin columns; false where it is no larger than an ear.
  bool find_sheet() {
    std::vector<char> seen(columns_.size());
    std::vector<std::size_t> largest;
    for (std::size_t start = 0; start < columns_.size(); ++start) {
      if (seen[start] != 0 || !is_thin(columns_[start])) continue;
      auto patch = patch_from(start, seen);
      if (patch.size() > largest.size()) largest = std::move(patch);
    }
    for (const std::size_t i : largest) columns_[i].is_sheet = true;
    return static_cast<double>(largest.size()) * step_mm_.prod() >= kLeastSheetMm2;
  }

  std::vector<std::size_t> patch_from(std::size_t start, std::vector<char>& seen) const {
    std::vector<std::size_t> patch = {start};
    seen[start] = 1;
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const int u = static_cast<int>(patch[next] % static_cast<std::size_t>(width_));
      const int z = static_cast<int>(patch[next] / static_cast<std::size_t>(width_));
      for (const auto& [du, dz] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        if (!is_in(u + du, z + dz)) continue;
        const Column& beside = at(u + du, z + dz);
        const double rise_mm = std::abs(beside.outer_mm - at(u, z).outer_mm);
        const double most_mm =
            std::max(kSteepest * (du != 0 ? step_mm_.x() : step_mm_.y()), 1.01 * depth_step_mm_);
        auto& mark = seen[static_cast<std::size_t>(z + dz) * width_ + (u + du)];
        if (mark != 0 || !is_thin(beside) || rise_mm > most_mm) continue;
        mark = 1;
        patch.push_back(static_cast<std::size_t>(z + dz) * width_ + (u + du));
      }
    }
    return patch;
  }

  void step_back_from_thicker_places() {
    const int reach_u = static_cast<int>(std::ceil(kFilletMm / step_mm_.x()));
    const int reach_z = static_cast<int>(std::ceil(kFilletMm / step_mm_.y()));
    for (int z = 0; z < height_; ++z) {
      for (int u = 0; u < width_; ++u) {
        if (!at(u, z).is_there || is_thin(at(u, z))) continue;
        for (int dz = -reach_z; dz <= reach_z; ++dz)
          for (int du = -reach_u; du <= reach_u; ++du)
            if (is_in(u + du, z + dz)) at(u + du, z + dz).is_sheet = false;
      }
    }
  }

  /// Where the sheet's inner side lies here, as its neighbourhood bends; none far from the sheet.
  [[nodiscard]] std::optional<double> inner_side_mm(int u, int z) const {
    if (at(u, z).is_sheet) return at(u, z).outer_mm - at(u, z).length_mm;
    const int reach_u = static_cast<int>(kReachMm / step_mm_.x());
    const int reach_z = static_cast<int>(kReachMm / step_mm_.y());
    const int stride_u = std::max(1, reach_u / 9);
    Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    int num_neighbours = 0;
    for (int dz = -reach_z; dz <= reach_z; ++dz) {
      for (int du = -reach_u; du <= reach_u; du += stride_u) {
        if (!is_in(u + du, z + dz) || !at(u + du, z + dz).is_sheet) continue;
        const double a = du * step_mm_.x() / kReachMm;
        const double b = dz * step_mm_.y() / kReachMm;
        const double weight = 1.0 - (a * a + b * b);
        if (weight <= 0.0) continue;
        const Column& column = at(u + du, z + dz);
        Eigen::Matrix<double, 6, 1> terms;
        terms << 1.0, a, b, a * a, a * b, b * b;
        gram += weight * terms * terms.transpose();
        right += weight * (column.outer_mm - column.length_mm) * terms;
        ++num_neighbours;
      }
    }
    if (num_neighbours < kLeastNeighbours) return std::nullopt;
    // Where the sheet is seen on one side only, its bend is not known: it is held flat.
    for (int term = 3; term < 6; ++term) gram(term, term) += 0.05 * num_neighbours;
    gram.diagonal().array() += 1e-6 * num_neighbours;
    return gram.ldlt().solve(right)[0];
  }

  void mark_column(int u, int z, double inner_mm, BitMask& sheet) const {
    const int from = sign_ > 0 ? num_deep() - 1 : 0;
    for (int depth = from; depth >= 0 && depth < num_deep(); depth -= sign_) {
      if (outward_mm(depth) <= inner_mm) break;
      if (!is_part(u, z, depth)) continue;
      if (axis_ == 0) {
        sheet.set_run(u, z, depth, depth + 1);
      } else {
        sheet.set_run(depth, z, u, u + 1);
      }
    }
  }

  const BitMask& part_;
  Eigen::Vector3d middle_;
  int axis_;
  int sign_;
  int width_;
  int height_;
  Eigen::Array2d step_mm_;
  double depth_step_mm_;
  std::vector<Column> columns_;
};

}  // namespace

BitMask thin_sheet(const BitMask& part,
                   const Eigen::Vector3d& middle,
                   const Eigen::Vector3d& spacing_mm) {
  BitMask sheet(part.size());
  for (const int axis : {0, 1})
    for (const int sign : {-1, 1}) SheetMap(part, middle, spacing_mm, axis, sign).mark(sheet);
  return sheet;
}

}  // namespace mor::internal
