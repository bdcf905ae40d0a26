// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/skin_glance.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_set>

namespace mor::internal {
namespace {

constexpr float kLeastFacing = 0.3F;  ///< Cosine.

std::uint64_t cell_key(const Eigen::Vector3f& cell) {
  const auto key = [](float v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)) + 0x10000) &
           0x1FFFFF;
  };
  return key(cell.x()) << 42U | key(cell.y()) << 21U | key(cell.z());
}

}  // namespace

SkinGlance::SkinGlance(const TriangleMesh& skin, float spacing_mm) {
  std::unordered_set<std::uint64_t> taken;
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const Eigen::Vector3f& vertex = skin.vertices[i];
    if (!taken.insert(cell_key(vertex / spacing_mm)).second) continue;
    const std::size_t lane = (taken.size() - 1) % kLanes;
    if (lane == 0) groups_.emplace_back();
    SkinLanes& group = groups_.back();
    group.x[lane] = vertex.x();
    group.y[lane] = vertex.y();
    group.z[lane] = vertex.z();
    group.normal_x[lane] = skin.normals[i].x();
    group.normal_y[lane] = skin.normals[i].y();
    group.normal_z[lane] = skin.normals[i].z();
  }
}

SkinAgreement SkinGlance::at(const StartPicture& picture,
                             const Eigen::Isometry3d& ct_from_depth,
                             float tolerance_mm) const {
  const Eigen::Matrix4f to = ct_from_depth.inverse().cast<float>().matrix();
  const Eigen::Vector3f camera = ct_from_depth.translation().cast<float>();
  const auto fx = static_cast<float>(picture.camera.focal_x_px);
  const auto fy = static_cast<float>(picture.camera.focal_y_px);
  const auto cx = static_cast<float>(picture.camera.center_x_px);
  const auto cy = static_cast<float>(picture.camera.center_y_px);
  const int width = picture.z_mm.width();
  const auto columns = static_cast<float>(width);
  const auto rows = static_cast<float>(picture.z_mm.height());
  const float* readings = picture.z_mm.data();

  IntLanes num_seen{};
  IntLanes num_floating{};
  IntLanes num_hidden{};
  Lanes agree{};
  for (const SkinLanes& skin : groups_) {
    const Lanes to_x = camera.x() - skin.x;
    const Lanes to_y = camera.y() - skin.y;
    const Lanes to_z = camera.z() - skin.z;
    const Lanes along = skin.normal_x * to_x + skin.normal_y * to_y + skin.normal_z * to_z;
    const Lanes square = to_x * to_x + to_y * to_y + to_z * to_z;
    const Lanes z = to(2, 0) * skin.x + to(2, 1) * skin.y + to(2, 2) * skin.z + to(2, 3);
    const Lanes x =
        fx * (to(0, 0) * skin.x + to(0, 1) * skin.y + to(0, 2) * skin.z + to(0, 3)) / z + cx + 0.5F;
    const Lanes y =
        fy * (to(1, 0) * skin.x + to(1, 1) * skin.y + to(1, 2) * skin.z + to(1, 3)) / z + cy + 0.5F;
    const IntLanes is_in_view =
        (along > 0.0F) & (along * along >= kLeastFacing * kLeastFacing * square) & (z >= 1.0F) &
        (x >= 0.0F) & (y >= 0.0F) & (x < columns) & (y < rows);
    const IntLanes column = __builtin_convertvector(is_in_view ? x : Lanes{}, IntLanes);
    const IntLanes row = __builtin_convertvector(is_in_view ? y : Lanes{}, IntLanes);
    const IntLanes pixel = row * width + column;
    Lanes reading;
    for (int lane = 0; lane < kLanes; ++lane) reading[lane] = readings[pixel[lane]];

    const IntLanes is_seen = is_in_view & (reading > 0.0F);
    const IntLanes is_floating = is_seen & (reading > z + kFloatingTolerances * tolerance_mm);
    const IntLanes is_hidden = is_seen & (reading < z - tolerance_mm);
    const Lanes ratio = (reading - z) / tolerance_mm;
    const Lanes rest = max_of(1.0F - ratio * ratio, Lanes{});
    agree += (is_seen & ~is_floating & ~is_hidden) ? rest * rest : Lanes{};
    // A mask's lanes are -1.
    num_seen -= is_seen;
    num_floating -= is_floating;
    num_hidden -= is_hidden;
  }
  const auto total = [](const IntLanes& counts) {
    return sum_of(__builtin_convertvector(counts, Lanes));
  };
  SkinAgreement agreement;
  agreement.num_seen = total(num_seen);
  agreement.num_agree = sum_of(agree);
  agreement.num_floating = total(num_floating);
  agreement.num_hidden = total(num_hidden);
  agreement.noise_share = picture.noise_share;
  return agreement;
}

}  // namespace mor::internal
