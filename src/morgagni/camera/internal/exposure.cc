// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "morgagni/camera/internal/random.h"

namespace mor::internal {

Eigen::Vector3f exposure_gains(double swing,
                               std::uint64_t seed,
                               std::uint64_t frame_id,
                               double time_s) {
  if (swing <= 0.0) return Eigen::Vector3f::Ones();
  constexpr double kTurnRad = 2.0 * std::numbers::pi;
  constexpr double kJumpPeriodS = 5.3;
  // Shares of the swing; they and the mean sum to 1, so that no gain exceeds 1.
  constexpr double kSlow = 0.20, kJump = 0.12, kFlicker = 0.06, kBalance = 0.12;
  const auto unit = [&](std::uint64_t counter) { return to_unit(scramble(seed + counter)); };
  const double slow = std::sin(kTurnRad * (time_s / 7.3 + unit(5001)));
  const double jump = 2.0 * unit(6000 + static_cast<std::uint64_t>(time_s / kJumpPeriodS)) - 1.0;
  const double flicker = 2.0 * to_unit(scramble(scramble(seed + 5002) ^ frame_id)) - 1.0;
  Eigen::Vector3f gains;
  for (int channel = 0; channel < 3; ++channel) {
    const double phase = unit(5003 + static_cast<std::uint64_t>(channel));
    const double balance = std::sin(kTurnRad * (time_s / 11.7 + phase));
    gains[channel] = static_cast<float>(1.0 + swing * (-0.5 + kSlow * slow + kJump * jump +
                                                       kFlicker * flicker + kBalance * balance));
  }
  return gains;
}

void expose(Image<Rgb8>& color, const Eigen::Vector3f& gains) {
  if (gains == Eigen::Vector3f::Ones()) return;
  std::array<std::array<std::uint8_t, 256>, 3> tables{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    for (std::size_t value = 0; value < 256; ++value) {
      const float exposed = gains[static_cast<Eigen::Index>(channel)] * static_cast<float>(value);
      tables[channel][value] = static_cast<std::uint8_t>(std::min(exposed + 0.5F, 255.0F));
    }
  }
  for (std::size_t i = 0; i < color.size(); ++i) {
    auto& [r, g, b] = color.data()[i];
    color.data()[i] = {tables[0][r], tables[1][g], tables[2][b]};
  }
}

}  // namespace mor::internal
