// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <type_traits>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/registration/distance_field.h"

// The file: "MORFIELD", version, then coarse and fine level (header, index, nodes), then the
// SHA-256 of all before it as 64 hexadecimal digits. Little-endian, as every machine we build for.

namespace mor {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(FieldNode) == 8 && std::is_trivially_copyable_v<FieldNode>);

constexpr std::array<char, 8> kMagic = {'M', 'O', 'R', 'F', 'I', 'E', 'L', 'D'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uintmax_t kMaxFileBytes = 512U << 20U;
constexpr std::size_t kChecksumDigits = 64;
constexpr std::uint32_t kMaxBricksPerSide = 1024;

struct LevelHeader {
  std::array<float, 3> origin_mm{};
  float spacing_mm = 0.0F;
  float band_mm = 0.0F;
  std::array<std::uint32_t, 3> bricks{};
  std::uint32_t num_stored_bricks = 0;
};

template <class T>
void append(std::vector<std::byte>& bytes, std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto raw = std::as_bytes(values);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

void append_level(std::vector<std::byte>& bytes, const FieldLevel& level) {
  LevelHeader header;
  header.spacing_mm = level.spacing_mm;
  header.band_mm = level.band_mm;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.origin_mm[axis] = level.origin_mm[static_cast<Eigen::Index>(axis)];
    header.bricks[axis] = static_cast<std::uint32_t>(level.bricks[axis]);
  }
  header.num_stored_bricks =
      static_cast<std::uint32_t>(level.nodes.size() / FieldLevel::kBrickNodes);
  append(bytes, std::span<const LevelHeader>(&header, 1));
  append(bytes, std::span<const std::uint32_t>(level.index));
  append(bytes, std::span<const FieldNode>(level.nodes));
}

/// Takes values off the front of a file's bytes; nothing where there are too few.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  [[nodiscard]] bool take(std::span<T> values) {
    if (values.size_bytes() > bytes_.size()) return false;
    if (!values.empty()) std::memcpy(values.data(), bytes_.data(), values.size_bytes());
    bytes_ = bytes_.subspan(values.size_bytes());
    return true;
  }
  [[nodiscard]] std::size_t num_left() const { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
};

bool is_sound(const LevelHeader& header) {
  const auto sound_side = [](std::uint32_t n) { return n >= 1 && n <= kMaxBricksPerSide; };
  const auto finite = [](float v) { return std::isfinite(v); };
  return std::all_of(header.bricks.begin(), header.bricks.end(), sound_side) &&
         std::all_of(header.origin_mm.begin(), header.origin_mm.end(), finite) &&
         header.spacing_mm > 0.0F && finite(header.spacing_mm) && header.band_mm > 0.0F &&
         finite(header.band_mm) && header.num_stored_bricks >= 1;
}

bool take_level(Reader& reader, FieldLevel& level) {
  LevelHeader header;
  if (!reader.take(std::span<LevelHeader>(&header, 1)) || !is_sound(header)) return false;
  const std::uint64_t num_bricks =
      std::uint64_t{header.bricks[0]} * header.bricks[1] * header.bricks[2];
  const std::uint64_t num_nodes = std::uint64_t{header.num_stored_bricks} * FieldLevel::kBrickNodes;
  // Nothing is allocated that the file cannot fill.
  if (num_bricks * sizeof(std::uint32_t) + num_nodes * sizeof(FieldNode) > reader.num_left()) {
    return false;
  }
  level.origin_mm = Eigen::Map<const Eigen::Vector3f>(header.origin_mm.data());
  level.spacing_mm = header.spacing_mm;
  level.band_mm = header.band_mm;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    level.bricks[axis] = static_cast<int>(header.bricks[axis]);
  }
  level.index.resize(num_bricks);
  level.nodes.resize(num_nodes);
  return reader.take(std::span<std::uint32_t>(level.index)) &&
         reader.take(std::span<FieldNode>(level.nodes)) &&
         std::all_of(level.index.begin(), level.index.end(), [&](std::uint32_t brick) {
           return brick < header.num_stored_bricks;
         });
}

}  // namespace

Result<void> write_distance_field(const std::filesystem::path& path, const DistanceField& field) {
  std::vector<std::byte> bytes;
  append(bytes, std::span<const char>(kMagic));
  append(bytes, std::span<const std::uint32_t>(&kVersion, 1));
  append_level(bytes, field.coarse());
  append_level(bytes, field.fine());
  const std::string checksum = sha256_hex(bytes);
  append(bytes, std::span<const char>(checksum));
  return write_file(path, bytes);
}

Result<DistanceField> read_distance_field(const std::filesystem::path& path) {
  MOR_TRY(const auto bytes, read_file(path, kMaxFileBytes));
  const auto bad = [&path](const std::string& what) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} {}; prepare the case again", path.string(), what));
  };
  if (bytes.size() < kMagic.size() + sizeof(kVersion) + kChecksumDigits) {
    return bad("is no distance field");
  }
  const auto content = std::span(bytes).first(bytes.size() - kChecksumDigits);
  Reader reader(content);
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  if (!reader.take(std::span<char>(magic)) || magic != kMagic ||
      !reader.take(std::span<std::uint32_t>(&version, 1))) {
    return bad("is no distance field");
  }
  if (version != kVersion) {
    return bad(fmt::format("is a distance field of version {}, not {}", version, kVersion));
  }
  const std::string checksum = sha256_hex(content);
  if (std::memcmp(checksum.data(), bytes.data() + content.size(), kChecksumDigits) != 0) {
    return bad("is a truncated or damaged distance field");
  }
  DistanceField field;
  if (!take_level(reader, field.coarse_) || !take_level(reader, field.fine_) ||
      reader.num_left() != 0) {
    return bad("is a distance field whose sizes do not agree with each other");
  }
  return field;
}

}  // namespace mor
