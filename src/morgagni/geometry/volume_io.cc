// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/volume_io.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include "morgagni/core/files.h"

// The file: "MORVOLUM", Header, the packed size of each slice, the packed slices. A slice is the
// steps from voxel to voxel, their low bytes first, then their high ones, as zlib packs them.
// Little-endian, as every machine we build for.

namespace mor {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::array<char, 8> kMagic = {'M', 'O', 'R', 'V', 'O', 'L', 'U', 'M'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uintmax_t kMaxFileBytes = 4ULL << 30U;
constexpr std::int32_t kMaxSide = 4096;
constexpr std::uint64_t kMaxVoxels = 1ULL << 30U;
/// zlib cannot pack better: nothing is allocated that a file cannot fill.
constexpr std::uint64_t kMostPacking = 1040;

struct Header {
  std::uint32_t version = kVersion;
  std::array<std::int32_t, 3> size{};
  std::array<double, 3> spacing_mm{};
  std::array<double, 12> ct_from_grid{};  ///< Three rows of four.
};
static_assert(sizeof(Header) == 16 + 15 * sizeof(double));

std::vector<unsigned char> packed(std::span<const std::int16_t> slice) {
  std::vector<unsigned char> bytes(slice.size() * 2);
  std::uint16_t last = 0;
  for (std::size_t i = 0; i < slice.size(); ++i) {
    const auto value = static_cast<std::uint16_t>(slice[i]);
    const auto step = static_cast<std::uint16_t>(value - last);
    bytes[i] = static_cast<unsigned char>(step & 255U);
    bytes[slice.size() + i] = static_cast<unsigned char>(step >> 8U);
    last = value;
  }
  uLongf packed_size = compressBound(bytes.size());
  std::vector<unsigned char> result(packed_size);
  compress2(result.data(), &packed_size, bytes.data(), bytes.size(), Z_BEST_SPEED);
  result.resize(packed_size);
  return result;
}

bool unpack(std::span<const std::byte> from, std::span<std::int16_t> slice) {
  std::vector<unsigned char> bytes(slice.size() * 2);
  uLongf size = bytes.size();
  const auto* packed_bytes = reinterpret_cast<const unsigned char*>(from.data());
  if (uncompress(bytes.data(), &size, packed_bytes, from.size()) != Z_OK || size != bytes.size()) {
    return false;
  }
  std::uint16_t value = 0;
  for (std::size_t i = 0; i < slice.size(); ++i) {
    value = static_cast<std::uint16_t>(value + bytes[i] + (bytes[slice.size() + i] << 8U));
    slice[i] = static_cast<std::int16_t>(value);
  }
  return true;
}

bool is_sound(const Header& header) {
  const auto good_side = [](std::int32_t side) { return side >= 1 && side <= kMaxSide; };
  const auto good_step = [](double mm) { return std::isfinite(mm) && mm > 0.0; };
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::all_of(header.size.begin(), header.size.end(), good_side) &&
         std::all_of(header.spacing_mm.begin(), header.spacing_mm.end(), good_step) &&
         std::all_of(header.ct_from_grid.begin(), header.ct_from_grid.end(), finite) &&
         std::uint64_t(header.size[0]) * std::uint64_t(header.size[1]) *
                 std::uint64_t(header.size[2]) <=
             kMaxVoxels;
}

template <class T>
void append(std::vector<std::byte>& bytes, std::span<const T> values) {
  const auto raw = std::as_bytes(values);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

template <class T>
bool take(std::span<const std::byte>& bytes, std::span<T> values) {
  if (values.size_bytes() > bytes.size()) return false;
  std::memcpy(values.data(), bytes.data(), values.size_bytes());
  bytes = bytes.subspan(values.size_bytes());
  return true;
}

}  // namespace

Result<void> write_volume(const std::filesystem::path& path, const Volume& volume) {
  Header header;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.size[axis] = volume.size[axis];
    header.spacing_mm[axis] = volume.spacing_mm[static_cast<Eigen::Index>(axis)];
  }
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(header.ct_from_grid.data()) =
      volume.ct_from_grid.matrix().topRows<3>();
  if (!is_sound(header) || volume.num_voxels() != volume.index(0, 0, volume.size[2])) {
    return make_error(ErrorCode::kInvalidArgument, "a volume without voxels cannot be written");
  }
  const auto num_slices = static_cast<std::size_t>(volume.size[2]);
  const std::size_t slice_size = volume.num_voxels() / num_slices;
  std::vector<std::vector<unsigned char>> slices(num_slices);
  tbb::parallel_for(std::size_t{0}, num_slices, [&](std::size_t z) {
    slices[z] = packed(std::span(volume.hu).subspan(z * slice_size, slice_size));
  });
  std::vector<std::byte> bytes;
  append(bytes, std::span<const char>(kMagic));
  append(bytes, std::span<const Header>(&header, 1));
  for (const auto& slice : slices) {
    const auto size = static_cast<std::uint32_t>(slice.size());
    append(bytes, std::span<const std::uint32_t>(&size, 1));
  }
  for (const auto& slice : slices) append(bytes, std::span<const unsigned char>(slice));
  return write_file(path, bytes);
}

Result<Volume> read_volume(const std::filesystem::path& path) {
  MOR_TRY(const auto bytes, read_file(path, kMaxFileBytes));
  const auto bad = [&path](const std::string& what) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} {}; prepare the case again", path.string(), what));
  };
  std::span<const std::byte> rest(bytes);
  std::array<char, 8> magic{};
  Header header;
  if (!take(rest, std::span<char>(magic)) || magic != kMagic ||
      !take(rest, std::span<Header>(&header, 1))) {
    return bad("is no volume");
  }
  if (header.version != kVersion) {
    return bad(fmt::format("is a volume of version {}, not {}", header.version, kVersion));
  }
  if (!is_sound(header)) return bad("is a volume of an impossible size or place");
  const auto num_slices = static_cast<std::size_t>(header.size[2]);
  const std::size_t slice_size =
      static_cast<std::size_t>(header.size[0]) * static_cast<std::size_t>(header.size[1]);
  std::vector<std::uint32_t> sizes(num_slices);
  if (!take(rest, std::span<std::uint32_t>(sizes)) ||
      slice_size * num_slices * 2 > (rest.size() + 64 * num_slices) * kMostPacking) {
    return bad("is a truncated volume");
  }
  std::vector<std::span<const std::byte>> slices(num_slices);
  for (std::size_t z = 0; z < num_slices; ++z) {
    if (sizes[z] > rest.size()) return bad("is a truncated volume");
    slices[z] = rest.first(sizes[z]);
    rest = rest.subspan(sizes[z]);
  }
  if (!rest.empty()) return bad("is a volume with something behind it");
  Volume volume;
  volume.size = {header.size[0], header.size[1], header.size[2]};
  volume.spacing_mm = Eigen::Map<const Eigen::Vector3d>(header.spacing_mm.data());
  volume.ct_from_grid.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(header.ct_from_grid.data());
  volume.hu.resize(slice_size * num_slices);
  std::atomic<bool> is_good = true;
  tbb::parallel_for(std::size_t{0}, num_slices, [&](std::size_t z) {
    if (!unpack(slices[z], std::span(volume.hu).subspan(z * slice_size, slice_size))) {
      is_good = false;
    }
  });
  if (!is_good) return bad("is a damaged volume");
  return volume;
}

}  // namespace mor
