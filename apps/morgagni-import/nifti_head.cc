// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <string_view>

#include <zlib.h>

#include "head_checks.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

using GzipFile = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

/// zlib reads files that are not compressed as they are.
GzipFile open_gzip(const fs::path& path) {
  return {::gzopen(path.c_str(), "rb"), ::gzclose};
}

/// The first bytes of a NIfTI-1 file in either byte order.
class NiftiHead {
 public:
  explicit NiftiHead(const fs::path& path) : bytes_(kNumBytes, '\0') {
    const auto file = open_gzip(path);
    const int got = file ? ::gzread(file.get(), bytes_.data(), kNumBytes) : 0;
    bytes_.resize(static_cast<std::size_t>(std::max(got, 0)));
    const auto size = number<std::int32_t>(0);
    is_swapped_ = size != kNumBytes && size != kNumBytesOfVersion2;
  }

  /// Without the magic it would be an ANALYZE file, which says nothing about left and right.
  [[nodiscard]] bool is_sound() const {
    return number<std::int32_t>(0) == kNumBytes && (says(344, "n+1") || says(344, "ni1"));
  }
  [[nodiscard]] bool is_version_2() const { return number<std::int32_t>(0) == kNumBytesOfVersion2; }
  /// dim[0]. nifticlib takes the byte order from it, not from the head's size.
  [[nodiscard]] int num_dimensions() const { return number<std::int16_t>(40); }
  [[nodiscard]] std::vector<std::int64_t> sides() const {
    std::vector<std::int64_t> sides;
    for (std::size_t axis = 1; axis <= static_cast<std::size_t>(num_dimensions()); ++axis)
      sides.push_back(number<std::int16_t>(40 + 2 * axis));
    return sides;
  }
  [[nodiscard]] std::uintmax_t bits_per_voxel() const {
    return static_cast<std::uintmax_t>(std::max<std::int16_t>(number<std::int16_t>(72), 0));
  }
  [[nodiscard]] std::uintmax_t voxels_start() const {
    constexpr float kFarthest = 1e9F;
    const auto start = number<float>(108);
    return start >= 0.0F && start < kFarthest ? static_cast<std::uintmax_t>(start) : 0;
  }
  /// Of the two ways to say where the grid lies those that are in use.
  [[nodiscard]] bool has_possible_place() const {
    return (number<std::int16_t>(252) <= 0 || are_possible(256, 6)) &&
           (number<std::int16_t>(254) <= 0 || are_possible(280, 12));
  }

 private:
  static constexpr int kNumBytes = 348;
  static constexpr int kNumBytesOfVersion2 = 540;
  static constexpr float kFarthestMm = 1e7F;

  template <class T>
  [[nodiscard]] T number(std::size_t at) const {
    std::array<char, sizeof(T)> stored{};
    if (at + sizeof(T) > bytes_.size()) return T{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), stored.begin());
    if (is_swapped_) std::reverse(stored.begin(), stored.end());
    return std::bit_cast<T>(stored);
  }
  [[nodiscard]] bool are_possible(std::size_t at, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i)
      if (!(std::abs(number<float>(at + i * sizeof(float))) < kFarthestMm)) return false;
    return true;
  }
  [[nodiscard]] bool says(std::size_t at, std::string_view magic) const {
    return at + magic.size() <= bytes_.size() &&
           std::string_view(bytes_).substr(at, magic.size()) == magic;
  }

  std::string bytes_;
  bool is_swapped_ = false;
};

}  // namespace

Result<void> check_nifti_head(const fs::path& path) {
  const NiftiHead head(path);
  // ITK 5.2 takes it for version 1 where it can, and reads numbers that nobody looked at.
  if (head.is_version_2()) {
    return make_error(
        ErrorCode::kUnsupported,
        path.filename().string() + " is a NIfTI-2 file, which is not read: save it as NIfTI-1");
  }
  if (!head.is_sound()) {
    return make_error(ErrorCode::kIo,
                      path.filename().string() +
                          " is no NIfTI file: its head is damaged, or of an older "
                          "format that does not tell left from right");
  }
  if (head.num_dimensions() < 1 || head.num_dimensions() > 7) {
    return make_error(ErrorCode::kIo,
                      path.filename().string() + " is damaged: its head says " +
                          std::to_string(head.num_dimensions()) +
                          " dimensions, 1 to 7 are possible");
  }
  if (head.num_dimensions() >= 3) MOR_CHECK(check_sides(path.filename().string(), head.sides()));
  // VNL never ends with some of these, and ends the whole process over others.
  if (head.has_possible_place()) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() +
                        " is damaged: its qform or sform, which says where the voxels lie, has a "
                        "number that is not below 1e7");
}

Result<void> check_nifti_length(const fs::path& path, std::uintmax_t num_voxels) {
  const NiftiHead head(path);
  const auto num_wanted = num_voxels * head.bits_per_voxel() / 8 + head.voxels_start();
  const auto file = open_gzip(path);
  std::vector<char> bytes(std::size_t{1} << 16);
  std::uintmax_t num_bytes = 0;
  while (file) {
    const int got = ::gzread(file.get(), bytes.data(), static_cast<unsigned>(bytes.size()));
    if (got <= 0) break;
    num_bytes += static_cast<std::uintmax_t>(got);
  }
  int failure = Z_OK;
  if (file) ::gzerror(file.get(), &failure);
  if (file && failure == Z_OK && num_bytes >= num_wanted) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() +
                        " is cut short or damaged: " + std::to_string(num_wanted) +
                        " bytes are announced, " + std::to_string(num_bytes) + " can be read");
}

}  // namespace mor::import
