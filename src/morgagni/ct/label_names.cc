// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <string_view>

#include "morgagni/ct/label_map.h"

namespace mor {
namespace {

/// In the order of their numbers, from 1.
constexpr std::array<std::string_view, 117> kNames = {"spleen",
                                                      "kidney_right",
                                                      "kidney_left",
                                                      "gallbladder",
                                                      "liver",
                                                      "stomach",
                                                      "pancreas",
                                                      "adrenal_gland_right",
                                                      "adrenal_gland_left",
                                                      "lung_upper_lobe_left",
                                                      "lung_lower_lobe_left",
                                                      "lung_upper_lobe_right",
                                                      "lung_middle_lobe_right",
                                                      "lung_lower_lobe_right",
                                                      "esophagus",
                                                      "trachea",
                                                      "thyroid_gland",
                                                      "small_bowel",
                                                      "duodenum",
                                                      "colon",
                                                      "urinary_bladder",
                                                      "prostate",
                                                      "kidney_cyst_left",
                                                      "kidney_cyst_right",
                                                      "sacrum",
                                                      "vertebrae_S1",
                                                      "vertebrae_L5",
                                                      "vertebrae_L4",
                                                      "vertebrae_L3",
                                                      "vertebrae_L2",
                                                      "vertebrae_L1",
                                                      "vertebrae_T12",
                                                      "vertebrae_T11",
                                                      "vertebrae_T10",
                                                      "vertebrae_T9",
                                                      "vertebrae_T8",
                                                      "vertebrae_T7",
                                                      "vertebrae_T6",
                                                      "vertebrae_T5",
                                                      "vertebrae_T4",
                                                      "vertebrae_T3",
                                                      "vertebrae_T2",
                                                      "vertebrae_T1",
                                                      "vertebrae_C7",
                                                      "vertebrae_C6",
                                                      "vertebrae_C5",
                                                      "vertebrae_C4",
                                                      "vertebrae_C3",
                                                      "vertebrae_C2",
                                                      "vertebrae_C1",
                                                      "heart",
                                                      "aorta",
                                                      "pulmonary_vein",
                                                      "brachiocephalic_trunk",
                                                      "subclavian_artery_right",
                                                      "subclavian_artery_left",
                                                      "common_carotid_artery_right",
                                                      "common_carotid_artery_left",
                                                      "brachiocephalic_vein_left",
                                                      "brachiocephalic_vein_right",
                                                      "atrial_appendage_left",
                                                      "superior_vena_cava",
                                                      "inferior_vena_cava",
                                                      "portal_vein_and_splenic_vein",
                                                      "iliac_artery_left",
                                                      "iliac_artery_right",
                                                      "iliac_vena_left",
                                                      "iliac_vena_right",
                                                      "humerus_left",
                                                      "humerus_right",
                                                      "scapula_left",
                                                      "scapula_right",
                                                      "clavicula_left",
                                                      "clavicula_right",
                                                      "femur_left",
                                                      "femur_right",
                                                      "hip_left",
                                                      "hip_right",
                                                      "spinal_cord",
                                                      "gluteus_maximus_left",
                                                      "gluteus_maximus_right",
                                                      "gluteus_medius_left",
                                                      "gluteus_medius_right",
                                                      "gluteus_minimus_left",
                                                      "gluteus_minimus_right",
                                                      "autochthon_left",
                                                      "autochthon_right",
                                                      "iliopsoas_left",
                                                      "iliopsoas_right",
                                                      "brain",
                                                      "skull",
                                                      "rib_left_1",
                                                      "rib_left_2",
                                                      "rib_left_3",
                                                      "rib_left_4",
                                                      "rib_left_5",
                                                      "rib_left_6",
                                                      "rib_left_7",
                                                      "rib_left_8",
                                                      "rib_left_9",
                                                      "rib_left_10",
                                                      "rib_left_11",
                                                      "rib_left_12",
                                                      "rib_right_1",
                                                      "rib_right_2",
                                                      "rib_right_3",
                                                      "rib_right_4",
                                                      "rib_right_5",
                                                      "rib_right_6",
                                                      "rib_right_7",
                                                      "rib_right_8",
                                                      "rib_right_9",
                                                      "rib_right_10",
                                                      "rib_right_11",
                                                      "rib_right_12",
                                                      "sternum",
                                                      "costal_cartilages"};

struct KindColor {
  std::string_view part;  ///< Of the name.
  std::array<float, 3> color;
};

/// As an atlas paints them; the first that fits.
constexpr std::array kColors = {KindColor{"artery", {0.84F, 0.15F, 0.13F}},
                                KindColor{"aorta", {0.84F, 0.15F, 0.13F}},
                                KindColor{"trunk", {0.84F, 0.15F, 0.13F}},
                                KindColor{"pulmonary_vein", {0.80F, 0.27F, 0.30F}},
                                KindColor{"vein", {0.20F, 0.36F, 0.75F}},
                                KindColor{"vena", {0.20F, 0.36F, 0.75F}},
                                KindColor{"heart", {0.72F, 0.22F, 0.20F}},
                                KindColor{"atrial", {0.72F, 0.22F, 0.20F}},
                                KindColor{"lung", {0.89F, 0.65F, 0.65F}},
                                KindColor{"trachea", {0.71F, 0.86F, 0.90F}},
                                KindColor{"liver", {0.55F, 0.26F, 0.20F}},
                                KindColor{"gallbladder", {0.40F, 0.62F, 0.25F}},
                                KindColor{"spleen", {0.60F, 0.27F, 0.42F}},
                                KindColor{"kidney", {0.66F, 0.33F, 0.24F}},
                                KindColor{"stomach", {0.87F, 0.62F, 0.52F}},
                                KindColor{"pancreas", {0.93F, 0.77F, 0.47F}},
                                KindColor{"adrenal", {0.96F, 0.80F, 0.31F}},
                                KindColor{"bowel", {0.86F, 0.67F, 0.49F}},
                                KindColor{"duodenum", {0.82F, 0.60F, 0.43F}},
                                KindColor{"colon", {0.75F, 0.56F, 0.42F}},
                                KindColor{"esophagus", {0.80F, 0.55F, 0.45F}},
                                KindColor{"bladder", {0.90F, 0.83F, 0.45F}},
                                KindColor{"thyroid", {0.80F, 0.40F, 0.50F}},
                                KindColor{"prostate", {0.85F, 0.60F, 0.60F}},
                                KindColor{"spinal_cord", {0.95F, 0.93F, 0.60F}},
                                KindColor{"brain", {0.88F, 0.74F, 0.70F}},
                                KindColor{"gluteus", {0.70F, 0.30F, 0.28F}},
                                KindColor{"autochthon", {0.70F, 0.30F, 0.28F}},
                                KindColor{"iliopsoas", {0.70F, 0.30F, 0.28F}},
                                KindColor{"cartilage", {0.65F, 0.80F, 0.85F}}};

Eigen::Vector3f color_of(std::string_view name) {
  constexpr std::array<float, 3> kBone = {0.93F, 0.89F, 0.78F};
  const auto found = std::find_if(kColors.begin(), kColors.end(), [&](const KindColor& kind) {
    return name.find(kind.part) != std::string_view::npos;
  });
  return Eigen::Vector3f(found == kColors.end() ? kBone.data() : found->color.data());
}

}  // namespace

std::vector<LabelName> total_segmentator_names() {
  std::vector<LabelName> names;
  for (const auto& name : kNames)
    names.push_back({static_cast<int>(names.size()) + 1, std::string(name), color_of(name)});
  return names;
}

}  // namespace mor
