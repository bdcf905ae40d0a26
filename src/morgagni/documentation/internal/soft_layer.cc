// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/soft_layer.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

using Eigen::Vector3f;

constexpr float kLeastShare = 0.35F;  ///< Of the surroundings that must be skin.
constexpr double kApartS = 1.0;
constexpr std::size_t kFewVertices = 40;
constexpr float kDark = 12.0F;     ///< Ratios of what is darker say little.
constexpr float kBright = 250.0F;  ///< What is brighter may be cut off.
/// The shown colour is the mean around this quantile of brightness: of two, the brighter.
constexpr float kQuantile = 0.6F;
constexpr float kAlike = 0.08F;
constexpr float kSameAngle = 0.06F;  ///< Of cosines.

float brightness(const Vector3f& color) {
  return 0.3F * color.x() + 0.59F * color.y() + 0.11F * color.z();
}

/// Of (value, weight), which it sorts. @pre Not empty.
float weighted_median(std::vector<std::pair<float, float>>& values) {
  std::sort(values.begin(), values.end());
  float total = 0.0F;
  for (const auto& [value, weight] : values) total += weight;
  float below = 0.0F;
  for (const auto& [value, weight] : values) {
    below += weight;
    if (below >= 0.5F * total) return value;
  }
  return values.back().first;
}

}  // namespace

SoftLayer::SoftLayer(const TriangleMesh& skin) : skin_(skin), vertices_(skin.vertices.size()) {}

void SoftLayer::clear() {
  vertices_.assign(skin_.vertices.size(), {});
}

std::vector<SoftLayer::Sample> SoftLayer::look(const FrameLook& frame) const {
  std::vector<Sample> samples;
  for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
    const auto sight = frame.sight(skin_.vertices[i], skin_.normals[i]);
    if (!sight) continue;
    const Eigen::Vector4f soft = frame.soft_color(*sight);
    if (soft.w() < kLeastShare || soft.head<3>().maxCoeff() > kBright) continue;
    // Squarely seen places are lit as in the best picture of them.
    samples.push_back({i, soft.head<3>(), sight->cosine, soft.w() * std::pow(sight->cosine, 6.0F)});
  }
  return samples;
}

std::optional<Vector3f> SoftLayer::gains(const std::vector<Sample>& samples) const {
  const auto alike = gains_within(samples, kSameAngle);
  return alike ? alike : gains_within(samples, 1.0F);
}

std::optional<Vector3f> SoftLayer::gains_within(const std::vector<Sample>& samples,
                                                float cosine_apart) const {
  std::array<std::vector<std::pair<float, float>>, 3> ratios;
  for (const auto& sample : samples) {
    const Vertex& vertex = vertices_[sample.vertex];
    if (!vertex.is_seen || sample.color.minCoeff() < kDark ||
        std::abs(vertex.shown_cosine - sample.cosine) > cosine_apart) {
      continue;
    }
    for (int channel = 0; channel < 3; ++channel) {
      ratios[static_cast<std::size_t>(channel)].emplace_back(
          vertex.shown[channel] / sample.color[channel], sample.weight);
    }
  }
  if (ratios[0].size() < kFewVertices) return std::nullopt;
  Vector3f gains;
  for (int channel = 0; channel < 3; ++channel) {
    gains[channel] = weighted_median(ratios[static_cast<std::size_t>(channel)]);
  }
  return gains;
}

void SoftLayer::keep(Vertex& vertex, const Seen& sample) {
  Seen* place = &vertex.seen[0];
  for (auto& seen : vertex.seen) {
    const bool is_near = seen.weight > 0.0F && std::abs(seen.second - sample.second) < kApartS;
    if (is_near) {
      if (sample.weight > seen.weight) seen = sample;
      return;
    }
    if (seen.weight < place->weight) place = &seen;
  }
  // Full: the least worth goes; what is worth about the same makes room for what is newer.
  if (sample.weight > 0.8F * place->weight) *place = sample;
}

void SoftLayer::decide(Vertex& vertex) {
  std::array<const Seen*, kKept> order{};
  std::size_t count = 0;
  float total = 0.0F;
  for (const auto& seen : vertex.seen) {
    if (seen.weight <= 0.0F) continue;
    order[count++] = &seen;
    total += seen.weight;
  }
  vertex.is_seen = count > 0;
  if (count == 0) return;
  std::sort(
      order.begin(),
      order.begin() + static_cast<std::ptrdiff_t>(count),
      [](const Seen* a, const Seen* b) { return brightness(a->color) < brightness(b->color); });
  float below = 0.0F;
  float middle = 0.0F;
  for (std::size_t i = 0; i < count; ++i) {
    below += order[i]->weight;
    middle = brightness(order[i]->color);
    if (below >= kQuantile * total) break;
  }
  Vector3f sum = Vector3f::Zero();
  float cosine = 0.0F;
  float weight = 0.0F;
  for (std::size_t i = 0; i < count; ++i) {
    const float apart = std::abs(brightness(order[i]->color) - middle) / std::max(middle, 1.0F);
    if (apart > kAlike) continue;
    sum += order[i]->weight * order[i]->color;
    cosine += order[i]->weight * order[i]->cosine;
    weight += order[i]->weight;
  }
  vertex.shown = sum / weight;
  vertex.shown_cosine = cosine / weight;
}

void SoftLayer::add(const std::vector<Sample>& samples, const Vector3f& gains, double second) {
  for (const auto& sample : samples) {
    Vertex& vertex = vertices_[sample.vertex];
    keep(vertex, {sample.color.cwiseProduct(gains), sample.cosine, sample.weight, second});
    decide(vertex);
  }
}

void SoftLayer::restore(std::uint32_t vertex, const Vector3f& color, float cosine) {
  vertices_[vertex].seen[0] = {color, cosine, std::pow(cosine, 6.0F), -1e6};
  decide(vertices_[vertex]);
}

std::optional<Vector3f> SoftLayer::color(const Triangle& corners, const Vector3f& share) const {
  Vector3f sum = Vector3f::Zero();
  float weight = 0.0F;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vertex& vertex = vertices_[corners[i]];
    if (!vertex.is_seen) continue;
    const float part = std::max(share[static_cast<Eigen::Index>(i)], 1e-3F);
    sum += part * vertex.shown;
    weight += part;
  }
  if (weight <= 0.0F) return std::nullopt;
  return Vector3f(sum / weight);
}

}  // namespace mor::internal
