// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtp_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <expat.h>

#include "morgagni/core/files.h"
#include "morgagni/ct/import_protocol.h"

#include "messages.h"
#include "sandbox.h"
#include "vtp_data.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

using Attributes = std::map<std::string, std::string>;

/// One <DataArray> that matters.
struct Array {
  std::string section;  ///< "Points", "Polys", "Strips".
  Attributes attributes;
  std::string text;

  [[nodiscard]] std::string attribute(const std::string& name) const {
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::string() : found->second;
  }
};

struct Piece {
  Attributes attributes;
  std::vector<Array> arrays;
};

/// What the XML says; the arrays' numbers are still as they are written.
struct Document {
  Attributes file;
  std::vector<Piece> pieces;
  std::string appended_encoding;
  std::size_t appended_at = 0;  ///< Of the file's bytes, behind the tag; 0: there is none.
  std::string refusal;          ///< Why reading ended early.
  std::string section;
  int depth = 0;
  int array_depth = 0;  ///< Of the array whose numbers come; 0: none.
  XML_Parser parser = nullptr;

  void refuse(const std::string& why) {
    refusal = why;
    XML_StopParser(parser, XML_FALSE);
  }
};

constexpr int kMostDepth = 64;
constexpr std::size_t kMostPieces = 1000;
constexpr std::size_t kMostArrays = 20;  ///< Of one piece's points, polygons and strips.

void on_start(void* data, const XML_Char* raw_name, const XML_Char** raw_attributes) {
  auto& document = *static_cast<Document*>(data);
  if (++document.depth > kMostDepth) return document.refuse("nests deeper than 64 levels");
  const std::string name = raw_name;
  Attributes attributes;
  for (; *raw_attributes != nullptr; raw_attributes += 2)
    attributes[raw_attributes[0]] = raw_attributes[1];
  if (document.depth == 1 && name != "VTKFile") return document.refuse("is no VTK XML file");
  if (name == "VTKFile") {
    document.file = attributes;
  } else if (name == "Piece") {
    if (document.pieces.size() == kMostPieces) return document.refuse("has more than 1000 pieces");
    document.pieces.push_back({attributes, {}});
  } else if (name == "Points" || name == "Polys" || name == "Strips") {
    document.section = name;
  } else if (name == "DataArray" && !document.section.empty() && !document.pieces.empty()) {
    auto& arrays = document.pieces.back().arrays;
    if (arrays.size() == kMostArrays) return document.refuse("has too many arrays");
    arrays.push_back({document.section, attributes, {}});
    document.array_depth = document.depth;
  } else if (name == "AppendedData") {
    document.appended_encoding = attributes["encoding"];
    document.appended_at = static_cast<std::size_t>(XML_GetCurrentByteIndex(document.parser) +
                                                    XML_GetCurrentByteCount(document.parser));
    // What follows may be any bytes: no XML.
    XML_StopParser(document.parser, XML_FALSE);
  }
}

void on_end(void* data, const XML_Char* raw_name) {
  auto& document = *static_cast<Document*>(data);
  if (document.depth == document.array_depth) document.array_depth = 0;
  --document.depth;
  const std::string name = raw_name;
  if (name == document.section) document.section.clear();
}

void on_text(void* data, const XML_Char* text, int num_bytes) {
  auto& document = *static_cast<Document*>(data);
  // VTK writes keys with values of their own into an array's element: they are none of its numbers.
  if (document.array_depth > 0 && document.depth == document.array_depth)
    document.pieces.back().arrays.back().text.append(text, static_cast<std::size_t>(num_bytes));
}

/// Entities can swell a file without end, and no VTK file has them.
void on_doctype(void* data, const XML_Char*, const XML_Char*, const XML_Char*, int) {
  static_cast<Document*>(data)->refuse("declares a document type, which no VTK file does");
}

/// Bounded reading of a file's parts.
class VtpReader {
 public:
  VtpReader(std::string name, std::vector<std::byte> bytes)
      : name_(std::move(name)), bytes_(std::move(bytes)) {}

  Result<TriangleMesh> read() {
    MOR_CHECK(parse());
    MOR_CHECK(check_kind());
    TriangleMesh mesh;
    for (const auto& piece : document_.pieces) MOR_CHECK(add(piece, mesh));
    return mesh;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> damaged(const std::string& what) const {
    return make_error(ErrorCode::kIo, name_ + " is cut short or damaged: " + what);
  }

  Result<void> parse() {
    const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
        XML_ParserCreate(nullptr), &XML_ParserFree);
    if (!parser) return make_error(ErrorCode::kIo, "there is not enough memory for " + name_);
    document_.parser = parser.get();
    XML_SetUserData(parser.get(), &document_);
    XML_SetElementHandler(parser.get(), on_start, on_end);
    XML_SetCharacterDataHandler(parser.get(), on_text);
    XML_SetStartDoctypeDeclHandler(parser.get(), on_doctype);
    constexpr std::size_t kStep = std::size_t{1} << 20;
    XML_Status status = XML_STATUS_OK;
    for (std::size_t at = 0; status == XML_STATUS_OK && at < bytes_.size(); at += kStep) {
      const std::size_t num = std::min(kStep, bytes_.size() - at);
      status = XML_Parse(parser.get(),
                         reinterpret_cast<const char*>(bytes_.data() + at),
                         static_cast<int>(num),
                         at + num == bytes_.size() ? XML_TRUE : XML_FALSE);
    }
    document_.parser = nullptr;
    if (!document_.refusal.empty())
      return make_error(ErrorCode::kInvalidArgument, name_ + " " + document_.refusal);
    if (status == XML_STATUS_OK || document_.appended_at > 0) return {};
    return damaged(std::string("it is no XML (") + XML_ErrorString(XML_GetErrorCode(parser.get())) +
                   ")");
  }

  Result<void> check_kind() {
    const auto said = [&](const char* what) { return document_.file[what]; };
    if (said("type") != "PolyData") {
      return make_error(ErrorCode::kUnsupported,
                        name_ + " holds a VTK \"" + said("type").substr(0, 40) +
                            "\", of which no surface is read: PolyData is wanted");
    }
    coding_.big_endian = said("byte_order") == "BigEndian";
    coding_.wide_heads = said("header_type") == "UInt64";
    coding_.compressed = !said("compressor").empty();
    if (coding_.compressed && said("compressor") != "vtkZLibDataCompressor") {
      return make_error(ErrorCode::kUnsupported,
                        name_ + " is compressed with " + said("compressor").substr(0, 40) +
                            ", which is not read: write it with zlib");
    }
    return {};
  }

  /// A count of the piece; the whole must not have more than the limit.
  Result<std::size_t> count(const Piece& piece, const char* what, std::size_t limit) const {
    const auto found = piece.attributes.find(what);
    if (found == piece.attributes.end()) return std::size_t{0};
    std::size_t number = 0;
    const std::string& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size())
      return damaged(std::string(what) + " is no number");
    if (number > limit) {
      return make_error(
          ErrorCode::kInvalidArgument,
          name_ + " has " + text + " for " + what + ", the limit is " + std::to_string(limit));
    }
    return number;
  }

  Result<std::vector<double>> numbers(const Array& array, std::size_t at_most) {
    const std::string type = array.attribute("type");
    const std::size_t size = vtp_type_bytes(type);
    if (size == 0) return damaged("it has numbers of type \"" + type.substr(0, 40) + "\"");
    const auto what = array.section + " \"" + array.attribute("Name").substr(0, 40) +
                      "\" are not what is announced: at most " + std::to_string(at_most) +
                      " numbers";
    const std::string format = array.attribute("format");
    allow_memory(12 * bytes_.size() + 4 * at_most * (size + sizeof(double)));
    if (format == "ascii") {
      if (auto found = vtp_ascii(array.text, at_most)) return *std::move(found);
      return damaged("the numbers of its " + what);
    }
    const auto bytes = format == "appended"
                           ? appended(array, size * at_most)
                           : vtp_base64(trimmed(array.text), coding_, size * at_most);
    if (!bytes) return damaged("the data of its " + what);
    auto found = vtp_numbers(*bytes, type, coding_.big_endian);
    if (!found) return damaged("the data of its " + what);
    return *std::move(found);
  }

  static std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    const auto begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
  }

  std::optional<std::vector<std::byte>> appended(const Array& array, std::size_t at_most) const {
    if (document_.appended_at == 0) return std::nullopt;
    const std::string offset_text = array.attribute("offset");
    std::size_t offset = 0;
    if (std::from_chars(offset_text.data(), offset_text.data() + offset_text.size(), offset).ec !=
        std::errc())
      return std::nullopt;
    // Behind the first "_".
    const auto after = std::span(bytes_).subspan(std::min(document_.appended_at, bytes_.size()));
    const auto mark = std::find(after.begin(), after.end(), std::byte{'_'});
    const auto begin = static_cast<std::size_t>(mark - after.begin()) + 1;
    if (begin > after.size() || offset > after.size() - begin) return std::nullopt;
    const auto data = after.subspan(begin + offset);
    if (document_.appended_encoding == "raw") return vtp_raw(data, coding_, at_most);
    return vtp_base64({reinterpret_cast<const char*>(data.data()), data.size()}, coding_, at_most);
  }

  static const Array* find(const Piece& piece,
                           const std::string& section,
                           const std::string& name) {
    const auto found =
        std::find_if(piece.arrays.begin(), piece.arrays.end(), [&](const Array& array) {
          return array.section == section && (name.empty() || array.attribute("Name") == name);
        });
    return found == piece.arrays.end() ? nullptr : &*found;
  }

  Result<void> add(const Piece& piece, TriangleMesh& mesh) {
    const std::size_t first = mesh.vertices.size();
    MOR_TRY(const std::size_t num_points,
            count(piece, "NumberOfPoints", 3 * kMaxMeshTriangles - first));
    const Array* points = find(piece, "Points", "");
    if (num_points > 0) {
      if (points == nullptr) return damaged("a piece has no points");
      MOR_TRY(const auto places, numbers(*points, 3 * num_points));
      if (places.size() != 3 * num_points) {
        return damaged("a piece announces " + std::to_string(num_points) + " points, " +
                       std::to_string(places.size() / 3) + " are there");
      }
      for (std::size_t i = 0; i < num_points; ++i)
        mesh.vertices.emplace_back(static_cast<float>(places[3 * i]),
                                   static_cast<float>(places[3 * i + 1]),
                                   static_cast<float>(places[3 * i + 2]));
    }
    MOR_CHECK(add_cells(piece, "Polys", "NumberOfPolys", first, mesh));
    return add_cells(piece, "Strips", "NumberOfStrips", first, mesh);
  }

  Result<void> add_cells(const Piece& piece,
                         const std::string& section,
                         const char* counted_by,
                         std::size_t first,
                         TriangleMesh& mesh) {
    MOR_TRY(const std::size_t num_cells, count(piece, counted_by, kMaxMeshTriangles));
    if (num_cells == 0) return {};
    const Array* offsets_array = find(piece, section, "offsets");
    const Array* corners_array = find(piece, section, "connectivity");
    if (offsets_array == nullptr || corners_array == nullptr)
      return damaged(section + " have no connectivity");
    MOR_TRY(const auto offsets, numbers(*offsets_array, num_cells));
    if (offsets.size() != num_cells) {
      return damaged(std::to_string(num_cells) + " " + section + " are announced, " +
                     std::to_string(offsets.size()) + " are there");
    }
    const double last = offsets.back();
    if (!(last >= 0.0 && last <= 4.0 * kMaxMeshTriangles))
      return damaged(section + " end with the offset " + short_text(last));
    MOR_TRY(const auto corners, numbers(*corners_array, static_cast<std::size_t>(last)));
    std::size_t begin = 0;
    for (const double offset : offsets) {
      if (!(offset >= static_cast<double>(begin) && offset <= static_cast<double>(corners.size())))
        return damaged(section + " have the offset " + short_text(offset) + " where " +
                       std::to_string(begin) + " to " + std::to_string(corners.size()) +
                       " are possible");
      const auto end = static_cast<std::size_t>(offset);
      MOR_CHECK(add_cell(
          std::span(corners).subspan(begin, end - begin), section == "Strips", first, mesh));
      begin = end;
    }
    return {};
  }

  /// A polygon as a fan, or a strip.
  Result<void> add_cell(std::span<const double> corners,
                        bool is_strip,
                        std::size_t first,
                        TriangleMesh& mesh) const {
    const auto num_points = static_cast<double>(mesh.vertices.size() - first);
    for (const double corner : corners)
      if (!(corner >= 0.0 && corner < num_points)) {
        return damaged("a corner names point " + short_text(corner) + ", there are 0 to " +
                       short_text(num_points - 1.0));
      }
    const auto vertex = [&](std::size_t i) {
      return static_cast<std::uint32_t>(first + static_cast<std::size_t>(corners[i]));
    };
    for (std::size_t i = 2; i < corners.size(); ++i) {
      if (mesh.triangles.size() == kMaxMeshTriangles) {
        return make_error(ErrorCode::kInvalidArgument,
                          name_ + " has more than " + std::to_string(kMaxMeshTriangles) +
                              " triangles, which is the limit");
      }
      if (!is_strip) {
        mesh.triangles.push_back({vertex(0), vertex(i - 1), vertex(i)});
      } else if (i % 2 == 0) {
        mesh.triangles.push_back({vertex(i - 2), vertex(i - 1), vertex(i)});
      } else {
        mesh.triangles.push_back({vertex(i - 1), vertex(i - 2), vertex(i)});
      }
    }
    return {};
  }

  std::string name_;
  std::vector<std::byte> bytes_;
  Document document_;
  VtpCoding coding_;
};

}  // namespace

Result<TriangleMesh> read_vtp(const fs::path& path) {
  MOR_TRY(auto bytes, read_file(path, static_cast<std::uintmax_t>(kMaxVolumeBytes)));
  if (bytes.empty()) return make_error(ErrorCode::kIo, path.filename().string() + " is empty");
  return VtpReader(path.filename().string(), std::move(bytes)).read();
}

}  // namespace mor::import
