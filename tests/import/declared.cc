// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "declared.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <set>

#include <zlib.h>

namespace mor {
namespace {

std::string inflated(const std::string& bytes) {
  if (!bytes.starts_with("\x1f\x8b")) return bytes;
  std::string whole(1U << 20U, '\0');
  z_stream stream{};
  if (::inflateInit2(&stream, 31) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(whole.data());
  stream.avail_out = static_cast<uInt>(whole.size());
  (void)::inflate(&stream, Z_FINISH);
  whole.resize(stream.total_out);
  ::inflateEnd(&stream);
  return whole;
}

template <class T>
T number_at(const std::string& bytes, std::size_t at, bool is_swapped) {
  std::string stored = bytes.substr(std::min(at, bytes.size()), sizeof(T));
  stored.resize(sizeof(T));
  if (is_swapped) std::reverse(stored.begin(), stored.end());
  T value{};
  std::memcpy(&value, stored.data(), sizeof(T));
  return value;
}

/// The numbers of voxels that the file may mean: more than one where a key is there twice.
using Counts = std::set<std::int64_t>;

Counts nifti_counts(const std::string& packed) {
  const std::string bytes = inflated(packed);
  for (const bool is_swapped : {false, true}) {
    if (number_at<std::int32_t>(bytes, 0, is_swapped) != 348) continue;
    std::int64_t count = 1;
    for (std::size_t axis = 1; axis <= 3; ++axis)
      count *= number_at<std::int16_t>(bytes, 40 + 2 * axis, is_swapped);
    return {count};
  }
  return {};
}

/// The products of the numbers behind each `key`, of the first `most` of them.
Counts text_counts(const std::string& bytes, std::string_view key, int most) {
  Counts counts;
  for (auto at = bytes.find(key); at != std::string::npos; at = bytes.find(key, at + 1)) {
    const std::size_t begin = bytes.find_first_not_of(" =:\"", at + key.size());
    if (begin == std::string::npos) continue;
    const std::string line = bytes.substr(begin, bytes.find('\n', begin) - begin);
    const char* next = line.c_str();
    std::int64_t count = 1;
    for (int i = 0; i < most; ++i) {
      char* end = nullptr;
      const double number = std::strtod(next, &end);
      if (end == next) break;
      count *= static_cast<std::int64_t>(number);
      next = end;
    }
    counts.insert(count);
  }
  return counts;
}

std::size_t occurrences(const std::string& bytes, std::string_view word) {
  std::size_t count = 0;
  for (auto at = bytes.find(word); at != std::string::npos; at = bytes.find(word, at + 1)) ++count;
  return count;
}

std::string says(const char* what, std::size_t answered, const Counts& declared) {
  std::string text = std::to_string(answered) + " " + what + ", declared";
  for (const auto count : declared) text.append(1, ' ').append(std::to_string(count));
  return text;
}

/// A mutant is one slice of three: the others still are 6 x 5 and 0.5 x 1 mm.
std::string dicom_contradiction(const Volume& volume) {
  constexpr double kLongestStackMm = 2 * 15.0;  // Wider gaps are not bridged.
  const double length_mm = (volume.size[2] - 1) * volume.spacing_mm.z();
  if (volume.size[0] < 6 || volume.size[1] < 5 || volume.size[2] < 2)
    return "smaller than one of its slices";
  if (length_mm > kLongestStackMm) return "longer than its slices reach";
  return {};
}

}  // namespace

std::string contradiction(std::string_view format, const std::string& bytes, const Volume& volume) {
  const std::int64_t answered =
      std::int64_t{volume.size[0]} * volume.size[1] * std::int64_t{volume.size[2]};
  if (answered != static_cast<std::int64_t>(volume.hu.size())) return "voxels without a grid";
  if (format == "dicom") return dicom_contradiction(volume);
  Counts declared;
  if (format == "nifti") declared = nifti_counts(bytes);
  if (format == "nrrd") declared = text_counts(bytes, "sizes", 16);
  if (format == "mha") declared = text_counts(bytes, "DimSize", 3);
  if (declared.contains(answered)) return {};
  return says("voxels", volume.hu.size(), declared);
}

std::string contradiction(std::string_view format,
                          const std::string& bytes,
                          const TriangleMesh& mesh) {
  if (format == "ply") {
    const Counts vertices = text_counts(bytes, "element vertex", 1);
    const Counts faces = text_counts(bytes, "element face", 1);
    if (!vertices.contains(static_cast<std::int64_t>(mesh.vertices.size())))
      return says("vertices", mesh.vertices.size(), vertices);
    if (!faces.contains(static_cast<std::int64_t>(mesh.triangles.size())))
      return says("triangles", mesh.triangles.size(), faces);
    return {};
  }
  if (format == "vtp") {
    const Counts vertices = text_counts(bytes, "NumberOfPoints", 1);
    if (vertices.contains(static_cast<std::int64_t>(mesh.vertices.size()))) return {};
    return says("vertices", mesh.vertices.size(), vertices);
  }
  // At most one triangle for each that is written down: 50 bytes or a "facet", a corner or two.
  std::size_t most = occurrences(bytes, "facet") + bytes.size() / 50;
  if (format == "obj") most = occurrences(bytes, " ") + occurrences(bytes, "\t");
  if (mesh.triangles.size() <= most) return {};
  return says("triangles", mesh.triangles.size(), {static_cast<std::int64_t>(most)});
}

}  // namespace mor
