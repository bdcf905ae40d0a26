// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

/// Eight rays at a time, in GCC's and Clang's portable vectors. Only reading from eight places at
/// once needs the machine's own words; where it has none, eight reads do.
namespace mor::internal {

inline constexpr int kNumLanes = 8;
using Floats = float __attribute__((vector_size(4 * kNumLanes)));
using Ints = std::int32_t __attribute__((vector_size(4 * kNumLanes)));

/// Of `value`, in every lane.
inline Floats all(float value) {
  return Floats{} + value;
}
inline Floats least(Floats a, Floats b) {
  return a < b ? a : b;
}
inline Floats most(Floats a, Floats b) {
  return a > b ? a : b;
}
inline Floats clamped(Floats value, Floats low, Floats high) {
  return least(most(value, low), high);
}
inline Floats magnitude(Floats value) {
  return value < 0.0F ? -value : value;
}
/// Towards zero.
inline Ints whole(Floats value) {
  return __builtin_convertvector(value, Ints);
}
inline Floats real(Ints value) {
  return __builtin_convertvector(value, Floats);
}

/// Whether a lane of a comparison's result is true.
inline bool any(Ints mask) {
#if defined(__AVX2__)
  __m256i bits;
  std::memcpy(&bits, &mask, sizeof bits);
  return _mm256_testz_si256(bits, bits) == 0;
#else
  std::int32_t bits = 0;
  for (int i = 0; i < kNumLanes; ++i) bits |= mask[i];
  return bits != 0;
#endif
}

/// Four bytes from `base + indices[i] * kScale`, for each lane.
template <int kScale>
Ints gather(const void* base, Ints indices) {
  Ints result;
#if defined(__AVX2__)
  __m256i places;
  std::memcpy(&places, &indices, sizeof places);
  const __m256i read = _mm256_i32gather_epi32(static_cast<const int*>(base), places, kScale);
  std::memcpy(&result, &read, sizeof result);
#else
  for (int i = 0; i < kNumLanes; ++i) {
    const auto offset = static_cast<std::ptrdiff_t>(indices[i]) * kScale;
    std::int32_t value;
    std::memcpy(&value, static_cast<const char*>(base) + offset, sizeof value);
    result[i] = value;
  }
#endif
  return result;
}

inline Floats gather_floats(const float* base, Ints indices) {
  const Ints bits = gather<4>(base, indices);
  Floats result;
  std::memcpy(&result, &bits, sizeof result);
  return result;
}

inline Floats square_root(Floats value) {
#if defined(__AVX2__)
  __m256 lanes;
  std::memcpy(&lanes, &value, sizeof lanes);
  lanes = _mm256_sqrt_ps(lanes);
  std::memcpy(&value, &lanes, sizeof value);
#else
  for (int i = 0; i < kNumLanes; ++i) value[i] = __builtin_sqrtf(value[i]);
#endif
  return value;
}

}  // namespace mor::internal
