// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <string>
#include <type_traits>

#include <Eigen/Core>

namespace mor::internal {

static_assert(std::endian::native == std::endian::little,
              "glTF, PLY and STL are written as memory holds them");

/// Numbers one after the other, little-endian.
template <class T>
void put(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

inline void put(std::string& bytes, const Eigen::Vector3f& v) {
  bytes.append(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
}

}  // namespace mor::internal
