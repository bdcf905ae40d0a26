// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/target_sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

using Eigen::Vector3f;

constexpr float kUpward = 0.35F;      ///< Cosine to the vertical of skin that counts as upper.
constexpr float kThinnestMm = 40.0F;  ///< Through less body there is no inside to speak of.
constexpr int kTriesPerTarget = 50;

std::vector<std::size_t> upper_vertices(const TriangleMesh& skin) {
  std::vector<std::size_t> upper;
  for (std::size_t i = 0; i < skin.normals.size(); ++i) {
    if (-skin.normals[i].y() > kUpward) upper.push_back(i);
  }
  return upper;
}

/// How far straight down (+y) from a place the next triangle lies, beyond a first few millimetres.
std::optional<float> depth_below_mm(const TriangleMesh& skin, const Vector3f& from) {
  constexpr float kBeyondMm = 3.0F;
  float nearest_mm = std::numeric_limits<float>::infinity();
  for (const auto& [ia, ib, ic] : skin.triangles) {
    const Vector3f a = skin.vertices[ia] - from;
    const Vector3f to_b = skin.vertices[ib] - skin.vertices[ia];
    const Vector3f to_c = skin.vertices[ic] - skin.vertices[ia];
    const float area = to_b.x() * to_c.z() - to_b.z() * to_c.x();
    if (std::abs(area) < 1e-9F) continue;
    const float u = (-a.x() * to_c.z() + a.z() * to_c.x()) / area;
    const float v = (-to_b.x() * a.z() + to_b.z() * a.x()) / area;
    if (u < 0.0F || v < 0.0F || u + v > 1.0F) continue;
    const float below_mm = a.y() + u * to_b.y() + v * to_c.y();
    if (below_mm > kBeyondMm) nearest_mm = std::min(nearest_mm, below_mm);
  }
  if (!std::isfinite(nearest_mm)) return std::nullopt;
  return nearest_mm;
}

tl::unexpected<Error> too_few(const char* what, int wanted, std::size_t found) {
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the skin has room for {} {}, got {}", found, what, wanted));
}

}  // namespace

Result<std::vector<Target>> sample_skin_targets(const TriangleMesh& skin,
                                                int num_targets,
                                                std::uint64_t seed) {
  const auto upper = upper_vertices(skin);
  if (num_targets < 0 || upper.size() < static_cast<std::size_t>(num_targets)) {
    return too_few("skin targets", num_targets, upper.size());
  }
  std::mt19937_64 random(seed);
  std::vector<float> apart_mm2(upper.size(), std::numeric_limits<float>::infinity());
  std::size_t next = upper.empty() ? 0 : random() % upper.size();
  std::vector<Target> targets;
  for (int i = 0; i < num_targets; ++i) {
    const Vector3f& at = skin.vertices[upper[next]];
    targets.push_back({fmt::format("F{:02}", i + 1), true, at.cast<double>()});
    for (std::size_t k = 0; k < upper.size(); ++k) {
      apart_mm2[k] = std::min(apart_mm2[k], (skin.vertices[upper[k]] - at).squaredNorm());
    }
    next = static_cast<std::size_t>(std::max_element(apart_mm2.begin(), apart_mm2.end()) -
                                    apart_mm2.begin());
  }
  return targets;
}

Result<std::vector<Target>> sample_internal_targets(const TriangleMesh& skin,
                                                    int num_targets,
                                                    std::uint64_t seed) {
  const auto upper = upper_vertices(skin);
  if (upper.empty()) return too_few("internal targets", num_targets, 0);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> share(0.25F, 0.75F);
  std::vector<Target> targets;
  for (int i = 0; i < kTriesPerTarget * num_targets; ++i) {
    if (targets.size() == static_cast<std::size_t>(num_targets)) break;
    const Vector3f& top = skin.vertices[upper[random() % upper.size()]];
    const auto below_mm = depth_below_mm(skin, top);
    if (!below_mm || *below_mm < kThinnestMm) continue;
    const Vector3f at = top + share(random) * *below_mm * Vector3f::UnitY();
    targets.push_back({fmt::format("T{:02}", targets.size() + 1), false, at.cast<double>()});
  }
  if (targets.size() < static_cast<std::size_t>(std::max(num_targets, 0))) {
    return too_few("internal targets", num_targets, targets.size());
  }
  return targets;
}

std::string targets_csv(const std::vector<Target>& targets) {
  std::string text = "name,kind,x_mm,y_mm,z_mm\n";
  for (const auto& [name, on_skin, ct] : targets) {
    // LPS becomes RAS by turning x and y around.
    text += fmt::format("{},{},{:.3f},{:.3f},{:.3f}\n",
                        name,
                        on_skin ? "skin" : "internal",
                        -ct.x(),
                        -ct.y(),
                        ct.z());
  }
  return text;
}

}  // namespace mor
