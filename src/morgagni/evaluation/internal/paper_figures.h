// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

/// What Kilgus et al. 2015 printed: real phantom, real corpse, real Kinect, a GeForce GTX 560.
namespace mor::paper {

inline constexpr std::array<double, 5> kPhantomFreMm = {1.3, 2.5, 1.7, 0.9, 1.9};
inline constexpr std::array<double, 5> kPhantomIcpTreMm = {5.3, 3.9, 3.7, 4.1, 4.2};
inline constexpr std::array<double, 5> kPhantomIcpMs = {177.5, 232.1, 173.5, 297.9, 215.8};
inline constexpr std::array<double, 5> kPhantomTrimmedTreMm = {5.7, 4.4, 3.7, 5.6, 4.1};
inline constexpr std::array<double, 5> kPhantomTrimmedMs = {543.6, 637.3, 534.0, 810.5, 608.5};

inline constexpr std::array<double, 5> kPostMortemFreMm = {1.6, 2.7, 3.5, 3.8, 3.6};
inline constexpr std::array<double, 5> kPostMortemTrimmedTreMm = {2.4, 4.2, 4.2, 5.5, 5.6};
inline constexpr std::array<double, 5> kPostMortemTrimmedMs = {
    1808.6, 1566.5, 1379.4, 1489.0, 901.1};

/// Means and standard deviations as printed.
inline constexpr const char* kPhantomFre = "1.7 ± 0.6";
inline constexpr const char* kPhantomIcpTre = "4.2 ± 0.6";
inline constexpr const char* kPhantomIcpTime = "219.3 ± 50.5";
inline constexpr const char* kPhantomTrimmedTre = "4.7 ± 0.9";
inline constexpr const char* kPhantomTrimmedTime = "626.8 ± 111.5";
inline constexpr const char* kPostMortemFre = "3.0 ± 0.9";
inline constexpr const char* kPostMortemTrimmedTre = "4.4 ± 1.3";
inline constexpr const char* kPostMortemTrimmedTime = "1428.9 ± 334.6";

/// Table 3, trimmed ICP: mean and standard deviation.
struct DownSampled {
  double factor;
  double tre_mm;
  double tre_sd_mm;
  double ms;
  double ms_sd;
};
inline constexpr std::array<DownSampled, 7> kDownSampled = {{{1.0, 4.4, 1.3, 1428.9, 334.6},
                                                             {1.5, 4.3, 1.2, 836.7, 247.3},
                                                             {2.0, 4.3, 1.2, 543.8, 201.1},
                                                             {2.5, 4.2, 1.1, 371.1, 106.0},
                                                             {3.0, 4.7, 1.3, 292.5, 107.2},
                                                             {3.5, 4.9, 1.9, 241.8, 74.7},
                                                             {4.0, 6.9, 4.2, 194.6, 82.4}}};

}  // namespace mor::paper
