// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace mor {

/// What of the CT's volume is to be seen, and in which colours.
enum class VolumePreset : std::uint8_t { kNone, kBone, kSoftTissue, kLung, kVessels, kSkin };

inline constexpr std::array<VolumePreset, 6> kVolumePresets = {VolumePreset::kNone,
                                                               VolumePreset::kBone,
                                                               VolumePreset::kSoftTissue,
                                                               VolumePreset::kLung,
                                                               VolumePreset::kVessels,
                                                               VolumePreset::kSkin};

/// "none", "bone", "soft-tissue", "lung", "vessels", "skin".
[[nodiscard]] std::string_view to_string(VolumePreset preset);
[[nodiscard]] std::optional<VolumePreset> parse_volume_preset(std::string_view name);

struct VolumeWindow {
  float level_hu = 0.0F;
  float window_hu = 1.0F;
};

/// Where a preset's colours lie by themselves.
[[nodiscard]] VolumeWindow volume_window(VolumePreset preset);

/// One point of a transfer function; between two of them it is linear.
struct TransferPoint {
  float hu;
  float opacity_per_mm;  ///< Of light that is held back on a millimetre.
  std::array<float, 3> color;
};

/// The preset at its own window, by rising HU; nothing is seen outside of its ends but what its
/// last point says.
[[nodiscard]] std::span<const TransferPoint> transfer_points(VolumePreset preset);

}  // namespace mor
