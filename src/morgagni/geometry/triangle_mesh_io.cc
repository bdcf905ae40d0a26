// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/triangle_mesh_io.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written as memory holds it");

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31U;
constexpr std::size_t kMaxHeaderBytes = 1U << 16U;
/// Indices are 32 bits wide and the largest one is kept free for "none".
constexpr std::uint64_t kMaxCount = 0xFFFFFFFEU;

enum class Scalar : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

std::optional<Scalar> scalar_of(std::string_view name) {
  if (name == "char" || name == "int8") return Scalar::kInt8;
  if (name == "uchar" || name == "uint8") return Scalar::kUint8;
  if (name == "short" || name == "int16") return Scalar::kInt16;
  if (name == "ushort" || name == "uint16") return Scalar::kUint16;
  if (name == "int" || name == "int32") return Scalar::kInt32;
  if (name == "uint" || name == "uint32") return Scalar::kUint32;
  if (name == "float" || name == "float32") return Scalar::kFloat;
  if (name == "double" || name == "float64") return Scalar::kDouble;
  return std::nullopt;
}

std::size_t bytes_of(Scalar scalar) {
  switch (scalar) {
    case Scalar::kInt8:
    case Scalar::kUint8:
      return 1;
    case Scalar::kInt16:
    case Scalar::kUint16:
      return 2;
    case Scalar::kInt32:
    case Scalar::kUint32:
    case Scalar::kFloat:
      return 4;
    case Scalar::kDouble:
      return 8;
  }
  return 0;
}

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat;
  std::optional<Scalar> list_count;  ///< Set where the property is a list.
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool is_ascii = false;
  std::vector<Element> elements;
};

std::string_view next_word(std::string_view& text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return text = {};
  const auto end = text.find_first_of(kBlank, begin);
  const auto word = text.substr(begin, end - begin);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end);
  return word;
}

/// Says what is wrong with one file.
class Complaint {
 public:
  explicit Complaint(const std::filesystem::path& path) : path_(path.string()) {}
  [[nodiscard]] tl::unexpected<Error> operator()(std::string_view what) const {
    return make_error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", path_, what));
  }

 private:
  std::string path_;
};

Result<void> parse_property(std::string_view line, Header& header, const Complaint& complain) {
  if (header.elements.empty()) return complain("the PLY header has a property before any element");
  Property property;
  auto type = next_word(line);
  if (type == "list") {
    property.list_count = scalar_of(next_word(line));
    const bool counts = property.list_count && *property.list_count != Scalar::kFloat &&
                        *property.list_count != Scalar::kDouble;
    if (!counts) return complain("the PLY header has a list whose length is no whole number");
    type = next_word(line);
  }
  const auto scalar = scalar_of(type);
  if (!scalar) return complain(fmt::format("the PLY property type '{}' is unknown", type));
  property.type = *scalar;
  property.name = next_word(line);
  header.elements.back().properties.push_back(std::move(property));
  return {};
}

Result<void> parse_element(std::string_view line, Header& header, const Complaint& complain) {
  Element element;
  element.name = next_word(line);
  const auto count = next_word(line);
  const auto [end, status] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (status != std::errc() || end != count.data() + count.size() || element.count > kMaxCount) {
    return complain(fmt::format(
        "the PLY header counts '{}' of '{}', the limit is {}", count, element.name, kMaxCount));
  }
  header.elements.push_back(std::move(element));
  return {};
}

Result<void> parse_header_line(std::string_view line, Header& header, const Complaint& complain) {
  const auto keyword = next_word(line);
  if (keyword == "element") return parse_element(line, header, complain);
  if (keyword == "property") return parse_property(line, header, complain);
  if (keyword == "format") {
    const auto format = next_word(line);
    header.is_ascii = format == "ascii";
    if (!header.is_ascii && format != "binary_little_endian") {
      return complain(fmt::format(
          "the PLY format '{}' is not read, only binary_little_endian and ascii", format));
    }
  }
  return {};  // Comments, obj_info and what is not known mean nothing to us.
}

/// Takes the header off the front of `text`.
Result<Header> parse_header(std::string_view& text, const Complaint& complain) {
  Header header;
  bool has_format = false;
  for (std::size_t used = 0; used < kMaxHeaderBytes;) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) break;
    auto line = text.substr(0, end);
    text.remove_prefix(end + 1);
    auto rest = line;
    const auto keyword = next_word(rest);
    if (used == 0 && keyword != "ply") break;
    used += line.size() + 1;
    if (keyword == "end_header") {
      if (!has_format) return complain("the PLY header names no format");
      return header;
    }
    has_format = has_format || keyword == "format";
    MOR_CHECK(parse_header_line(line, header, complain));
  }
  return complain("not a PLY file (its header is missing or does not end)");
}

/// The numbers after the header, one by one.
class Numbers {
 public:
  Numbers(std::string_view rest, bool is_ascii) : rest_(rest), is_ascii_(is_ascii) {}

  /// None at the file's end, or where an ASCII word is no number.
  std::optional<double> next(Scalar scalar) {
    return is_ascii_ ? next_text() : next_bytes(scalar);
  }

  /// Whether the rest of the file can hold `count` times these properties, lists being empty.
  [[nodiscard]] bool can_hold(const Element& element) const {
    std::uint64_t least = 0;
    for (const auto& property : element.properties) {
      least += is_ascii_ ? 2 : bytes_of(property.list_count.value_or(property.type));
    }
    return least > 0 && element.count <= (rest_.size() + 1) / least;
  }

 private:
  std::optional<double> next_text() {
    const auto word = next_word(rest_);
    double value = 0.0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || status != std::errc() || end != word.data() + word.size()) {
      return std::nullopt;
    }
    return value;
  }

  template <class T>
  double take() {
    T value{};
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return static_cast<double>(value);
  }

  std::optional<double> next_bytes(Scalar scalar) {
    if (rest_.size() < bytes_of(scalar)) return std::nullopt;
    switch (scalar) {
      case Scalar::kInt8:
        return take<std::int8_t>();
      case Scalar::kUint8:
        return take<std::uint8_t>();
      case Scalar::kInt16:
        return take<std::int16_t>();
      case Scalar::kUint16:
        return take<std::uint16_t>();
      case Scalar::kInt32:
        return take<std::int32_t>();
      case Scalar::kUint32:
        return take<std::uint32_t>();
      case Scalar::kFloat:
        return take<float>();
      case Scalar::kDouble:
        return take<double>();
    }
    return std::nullopt;
  }

  std::string_view rest_;
  bool is_ascii_;
};

/// Where a vertex's property goes: x y z are 0 1 2, the normal's are 3 4 5, the rest nowhere.
std::optional<std::size_t> slot_of(const Property& property) {
  constexpr std::array<std::string_view, 6> kNames = {"x", "y", "z", "nx", "ny", "nz"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (property.name == kNames[i] && !property.list_count) return i;
  }
  return std::nullopt;
}

class MeshReader {
 public:
  MeshReader(Numbers numbers, const Complaint& complain) : numbers_(numbers), complain_(complain) {}

  Result<TriangleMesh> read(const Header& header) {
    for (const auto& element : header.elements) {
      if (element.count == 0) continue;
      if (!numbers_.can_hold(element)) {
        return complain_(fmt::format("the file is too short for the {} of '{}' that it announces",
                                     element.count,
                                     element.name));
      }
      if (element.name == "vertex") {
        MOR_CHECK(read_vertices(element));
      } else if (element.name == "face") {
        MOR_CHECK(read_faces(element));
      } else {
        MOR_CHECK(pass_over(element));
      }
    }
    MOR_CHECK(check_indices());
    return std::move(mesh_);
  }

 private:
  Result<double> number(Scalar scalar, const Element& element, std::uint64_t row) {
    const auto value = numbers_.next(scalar);
    if (value) return *value;
    return complain_(fmt::format("'{}' number {} is cut off or is no number", element.name, row));
  }

  /// Reads a list and keeps its first three entries.
  Result<std::array<double, 3>> list(const Property& property,
                                     const Element& element,
                                     std::uint64_t row,
                                     double& length) {
    MOR_TRY(length, number(*property.list_count, element, row));
    std::array<double, 3> first{};
    for (double i = 0; i < length; ++i) {
      MOR_TRY(const double value, number(property.type, element, row));
      if (i < 3) first[static_cast<std::size_t>(i)] = value;
    }
    return first;
  }

  Result<void> pass_over(const Property& property, const Element& element, std::uint64_t row) {
    if (property.list_count) {
      double length = 0.0;
      MOR_CHECK(list(property, element, row, length));
    } else {
      MOR_CHECK(number(property.type, element, row));
    }
    return {};
  }

  Result<void> pass_over(const Element& element) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const auto& property : element.properties) {
        MOR_CHECK(pass_over(property, element, row));
      }
    }
    return {};
  }

  Result<void> read_vertices(const Element& element) {
    std::array<bool, 6> has{};
    for (const auto& property : element.properties) {
      if (const auto slot = slot_of(property)) has[*slot] = true;
    }
    if (!has[0] || !has[1] || !has[2]) return complain_("the PLY vertices have no x, y, z");
    const bool has_normals = has[3] && has[4] && has[5];
    mesh_.vertices.reserve(element.count);
    if (has_normals) mesh_.normals.reserve(element.count);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      std::array<float, 6> values{};
      for (const auto& property : element.properties) {
        const auto slot = slot_of(property);
        if (!slot) {
          MOR_CHECK(pass_over(property, element, row));
          continue;
        }
        MOR_TRY(const double value, number(property.type, element, row));
        values[*slot] = static_cast<float>(value);
        if (!std::isfinite(values[*slot])) {
          return complain_(
              fmt::format("vertex {} has a {} that is not finite", row, property.name));
        }
      }
      mesh_.vertices.emplace_back(values[0], values[1], values[2]);
      if (has_normals) mesh_.normals.emplace_back(values[3], values[4], values[5]);
    }
    return {};
  }

  Result<void> read_faces(const Element& element) {
    mesh_.triangles.reserve(element.count);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const auto& property : element.properties) {
        const bool is_corners = property.list_count && (property.name == "vertex_indices" ||
                                                        property.name == "vertex_index");
        if (!is_corners) {
          MOR_CHECK(pass_over(property, element, row));
          continue;
        }
        double length = 0.0;
        MOR_TRY(const auto corners, list(property, element, row, length));
        if (length != 3.0) {
          return complain_(fmt::format("face {} has {} corners, not 3", row, length));
        }
        MOR_CHECK(add_triangle(corners, row));
      }
    }
    if (mesh_.triangles.size() == element.count) return {};
    return complain_("the PLY faces do not have one vertex_indices list each");
  }

  Result<void> add_triangle(const std::array<double, 3>& corners, std::uint64_t row) {
    Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const bool is_index = corners[i] >= 0.0 && corners[i] <= static_cast<double>(kMaxCount) &&
                            corners[i] == std::floor(corners[i]);
      if (!is_index) return complain_(fmt::format("face {} has the index {}", row, corners[i]));
      triangle[i] = static_cast<std::uint32_t>(corners[i]);
    }
    mesh_.triangles.push_back(triangle);
    return {};
  }

  /// At the end, for faces may stand before the vertices.
  [[nodiscard]] Result<void> check_indices() const {
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (const auto corner : mesh_.triangles[i]) {
        if (corner < mesh_.vertices.size()) continue;
        return complain_(
            fmt::format("face {} names vertex {} of {}", i, corner, mesh_.vertices.size()));
      }
    }
    return {};
  }

  Numbers numbers_;
  const Complaint& complain_;
  TriangleMesh mesh_;
};

template <class T>
void append(std::vector<std::byte>& out, const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof(T));
}

std::string header_of(const TriangleMesh& mesh, bool has_normals) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}element face {}\n"
      "property list uchar uint vertex_indices\nend_header\n",
      mesh.vertices.size(),
      has_normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
      mesh.triangles.size());
}

}  // namespace

Result<TriangleMesh> read_ply(const std::filesystem::path& path) {
  MOR_TRY(const auto bytes, read_file(path, kMaxFileBytes));
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const Complaint complain(path);
  MOR_TRY(const auto header, parse_header(text, complain));
  return MeshReader(Numbers(text, header.is_ascii), complain).read(header);
}

Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const bool has_normals = !mesh.normals.empty() && mesh.normals.size() == mesh.vertices.size();
  const auto header = header_of(mesh, has_normals);
  std::vector<std::byte> out;
  out.reserve(header.size() + mesh.vertices.size() * 24 + mesh.triangles.size() * 13);
  const auto head = std::as_bytes(std::span(header));
  out.insert(out.end(), head.begin(), head.end());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (const float value : mesh.vertices[i]) append(out, value);
    if (!has_normals) continue;
    for (const float value : mesh.normals[i]) append(out, value);
  }
  for (const auto& triangle : mesh.triangles) {
    append(out, std::uint8_t{3});
    append(out, triangle);
  }
  return write_file(path, out);
}

}  // namespace mor
