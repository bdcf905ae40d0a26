// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/volume_preset.h"

#include <cstddef>

namespace mor {
namespace {

using Color = std::array<float, 3>;

constexpr Color kMarrow = {0.72F, 0.40F, 0.30F};
constexpr Color kIvory = {0.96F, 0.91F, 0.80F};
constexpr Color kFat = {0.95F, 0.80F, 0.50F};
constexpr Color kMuscle = {0.72F, 0.28F, 0.24F};
constexpr Color kOrgan = {0.80F, 0.42F, 0.34F};
constexpr Color kBlood = {0.85F, 0.12F, 0.10F};
constexpr Color kAirway = {0.55F, 0.70F, 0.85F};
constexpr Color kLungVessel = {0.93F, 0.62F, 0.55F};
constexpr Color kSkinTone = {0.90F, 0.70F, 0.58F};

constexpr std::array kBonePoints = {TransferPoint{130, 0.0F, kMarrow},
                                    TransferPoint{230, 0.10F, kMarrow},
                                    TransferPoint{380, 0.60F, kIvory},
                                    TransferPoint{1600, 0.95F, kIvory}};
constexpr std::array kSoftTissuePoints = {TransferPoint{-150, 0.0F, kFat},
                                          TransferPoint{-90, 0.004F, kFat},
                                          TransferPoint{-20, 0.006F, kFat},
                                          TransferPoint{20, 0.035F, kMuscle},
                                          TransferPoint{70, 0.07F, kOrgan},
                                          TransferPoint{160, 0.14F, kBlood},
                                          TransferPoint{280, 0.5F, kIvory},
                                          TransferPoint{1200, 0.9F, kIvory}};
constexpr std::array kLungPoints = {TransferPoint{-960, 0.0F, kAirway},
                                    TransferPoint{-900, 0.006F, kAirway},
                                    TransferPoint{-780, 0.010F, kAirway},
                                    TransferPoint{-650, 0.030F, kLungVessel},
                                    TransferPoint{-420, 0.22F, kLungVessel},
                                    TransferPoint{-250, 0.0F, kLungVessel}};
constexpr std::array kVesselPoints = {TransferPoint{110, 0.0F, kBlood},
                                      TransferPoint{160, 0.08F, kBlood},
                                      TransferPoint{240, 0.45F, kBlood},
                                      TransferPoint{360, 0.30F, kIvory},
                                      TransferPoint{1500, 0.80F, kIvory}};
constexpr std::array kSkinPoints = {TransferPoint{-500, 0.0F, kSkinTone},
                                    TransferPoint{-380, 0.15F, kSkinTone},
                                    TransferPoint{-200, 0.95F, kSkinTone},
                                    TransferPoint{3071, 0.95F, kSkinTone}};

struct Entry {
  VolumePreset preset;
  std::string_view name;
  VolumeWindow window;
  std::span<const TransferPoint> points;
};

constexpr std::array<Entry, 6> kEntries = {
    Entry{VolumePreset::kNone, "none", {0.0F, 1.0F}, {}},
    Entry{VolumePreset::kBone, "bone", {400.0F, 1000.0F}, kBonePoints},
    Entry{VolumePreset::kSoftTissue, "soft-tissue", {40.0F, 400.0F}, kSoftTissuePoints},
    Entry{VolumePreset::kLung, "lung", {-600.0F, 1200.0F}, kLungPoints},
    Entry{VolumePreset::kVessels, "vessels", {200.0F, 500.0F}, kVesselPoints},
    Entry{VolumePreset::kSkin, "skin", {-300.0F, 600.0F}, kSkinPoints}};

constexpr const Entry& entry_of(VolumePreset preset) {
  return kEntries[static_cast<std::size_t>(preset)];
}

}  // namespace

std::string_view to_string(VolumePreset preset) {
  return entry_of(preset).name;
}

std::optional<VolumePreset> parse_volume_preset(std::string_view name) {
  for (const Entry& entry : kEntries) {
    if (entry.name == name) return entry.preset;
  }
  return std::nullopt;
}

VolumeWindow volume_window(VolumePreset preset) {
  return entry_of(preset).window;
}

std::span<const TransferPoint> transfer_points(VolumePreset preset) {
  return entry_of(preset).points;
}

}  // namespace mor
