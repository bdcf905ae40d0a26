// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "morgagni/documentation/internal/frame_look.h"
#include "morgagni/geometry/triangle_mesh.h"

namespace mor::internal {

/// The skin's colour without its details, a vertex, from all frames that show it.
///
/// Each vertex keeps what a few frames, apart in time, have seen of it, and shows the brighter half
/// of them: a hand's shadow that wanders over it is outvoted, a highlight too.
class SoftLayer {
 public:
  explicit SoftLayer(const TriangleMesh& skin);

  /// A vertex as a frame shows it.
  struct Sample {
    std::uint32_t vertex = 0;
    Eigen::Vector3f color;
    float cosine = 0.0F;  ///< At which it is seen.
    float weight = 0.0F;
  };
  [[nodiscard]] std::vector<Sample> look(const FrameLook& frame) const;

  /// What the frame's red, green and blue must be multiplied by to agree with the layer: the middle
  /// of the ratios of those vertices that it sees at about the angle at which the layer has them. A
  /// lamp at the camera lights what it sees squarely more: with all vertices the texture would grow
  /// darker on the way around the body. None: too little in common. @pre samples of this layer.
  [[nodiscard]] std::optional<Eigen::Vector3f> gains(const std::vector<Sample>& samples) const;

  /// @param second  When, s; samples within a second of each other count as one.
  void add(const std::vector<Sample>& samples, const Eigen::Vector3f& gains, double second);

  /// Sets a vertex's colour as if seen before, at this cosine.
  void restore(std::uint32_t vertex, const Eigen::Vector3f& color, float cosine);

  /// Of a place within a triangle; none where no corner has been seen.
  [[nodiscard]] std::optional<Eigen::Vector3f> color(const Triangle& corners,
                                                     const Eigen::Vector3f& share) const;

  void clear();

 private:
  static constexpr std::size_t kKept = 12;
  struct Seen {
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    float cosine = 0.0F;
    float weight = 0.0F;  ///< 0: empty.
    double second = 0.0;
  };
  struct Vertex {
    std::array<Seen, kKept> seen;
    Eigen::Vector3f shown = Eigen::Vector3f::Zero();
    float shown_cosine = 0.0F;
    bool is_seen = false;
  };
  [[nodiscard]] std::optional<Eigen::Vector3f> gains_within(const std::vector<Sample>& samples,
                                                            float cosine_apart) const;
  static void keep(Vertex& vertex, const Seen& sample);
  static void decide(Vertex& vertex);

  const TriangleMesh& skin_;
  std::vector<Vertex> vertices_;
};

}  // namespace mor::internal
