// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace mor::internal {

/// What marks leave of the skin's red, green and blue at a place: freckles some 4 mm wide, fine
/// dark lines as of scratches and veins, 2 mm wide, and bruises of some centimetres. Wide enough to
/// be seen at 0.75 px/mm, which the pores are not; sharp enough that a millimetre out of place
/// shows.
[[nodiscard]] Eigen::Vector3f skin_mark_at(const Eigen::Vector3f& at_ct, std::uint64_t seed);

}  // namespace mor::internal
