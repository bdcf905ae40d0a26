// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace mor {

/// `morgagni-import TASK PATH SERIES` reads PATH for the process that started it. The voxels go
/// through a memory file on `kImportVoxelsFd`: an ImportHeader, then size[0] * size[1] * size[2]
/// int16 HU values. Everything that is said goes through a pipe on `kImportMessagesFd`, a line
/// each, the first character telling which:
///   p FRACTION        progress, 0 to 1
///   f NAME            the file that is read now, so that a crash can be blamed on it
///   n SENTENCE        a note: something was skipped or changed
///   w SENTENCE        a limit of the process that does not hold on this machine
///   s FIELDS          a series: the fields of CtSeries in their order, each ended by a tab
///   l VALUE RED GREEN BLUE NAME   what a label means
///   k COUNT           how many label maps the file holds; SERIES asks for one by its number
///   c FRAME           the frame that a mesh says it is in, LPS or RAS
///   e CODE SENTENCE   why there is no volume; CODE is an ErrorCode as a number
inline constexpr const char* kReadVolumeTask = "volume";
inline constexpr const char* kReadLabelsTask = "labels";  ///< As a volume; voxels are labels.
inline constexpr const char* kReadMeshTask = "mesh";      ///< An ImportMeshHeader, then the mesh.
inline constexpr const char* kListSeriesTask = "list-series";
inline constexpr const char* kTryLimitsTask = "try-limits";  ///< Gives up its rights, then ends.
inline constexpr int kImportMessagesFd = 3;
inline constexpr int kImportVoxelsFd = 4;
inline constexpr std::array<char, 8> kImportMagic = {'M', 'O', 'R', 'V', 'O', 'L', '0', '1'};

inline constexpr int kMaxVolumeSide = 2048;                 ///< Voxels.
inline constexpr std::int64_t kMaxVolumeBytes = 2LL << 30;  ///< Of int16 voxels.

struct ImportHeader {
  std::array<char, 8> magic{};
  std::array<std::int32_t, 4> size{};  ///< x, y, z; the fourth is zero.
  std::array<double, 3> spacing_mm{};
  std::array<double, 3> origin_mm{};    ///< Centre of the first voxel, LPS.
  std::array<double, 9> axes{};         ///< LPS unit vectors of grid x, then y, then z.
  std::array<char, 256> description{};  ///< One line, ends with zero.
};
static_assert(sizeof(ImportHeader) == 8 + 16 + 24 + 24 + 72 + 256);

inline constexpr std::array<char, 8> kImportMeshMagic = {'M', 'O', 'R', 'M', 'S', 'H', '0', '1'};
inline constexpr std::uint64_t kMaxMeshTriangles = 10'000'000;

/// Behind it 3 floats a vertex, then 3 uint32 indices a triangle.
struct ImportMeshHeader {
  std::array<char, 8> magic{};
  std::uint64_t num_vertices = 0;
  std::uint64_t num_triangles = 0;
};
static_assert(sizeof(ImportMeshHeader) == 24);

}  // namespace mor
