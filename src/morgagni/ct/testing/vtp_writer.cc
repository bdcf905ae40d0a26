// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/testing/vtp_writer.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>
#include <zlib.h>

namespace mor::testing_files {
namespace {

std::string base64(const std::string& bytes) {
  static const std::string kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// A file with one piece, as VTK writes it.
class Writer {
 public:
  explicit Writer(VtpStyle style) : style_(std::move(style)) {}

  template <class Number>
  std::string array(const std::string& name,
                    const std::string& type,
                    const std::vector<Number>& numbers,
                    int components = 1) {
    std::string head =
        fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"{}\"",
                    type,
                    name,
                    components,
                    style_.format);
    if (style_.format == "ascii")
      return head + fmt::format(">{}</DataArray>", fmt::join(numbers, " "));
    std::string data;
    for (Number number : numbers) put(data, number);
    if (style_.format == "binary") return head + ">\n  " + coded(data, true) + "\n</DataArray>";
    head += fmt::format(" offset=\"{}\"/>", appended_.size());
    appended_ += coded(data, style_.encoding == "base64");
    return head;
  }

  std::string file(const std::string& piece, const std::string& counts) const {
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" "
        "header_type=\"{}\"{}>\n"
        "<PolyData><Piece {}>{}</Piece></PolyData>\n",
        style_.big_endian ? "BigEndian" : "LittleEndian",
        style_.wide_heads ? "UInt64" : "UInt32",
        style_.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "",
        counts,
        piece);
    if (style_.format == "appended")
      text += fmt::format("<AppendedData encoding=\"{}\">\n  _", style_.encoding) + appended_ +
              "\n</AppendedData>\n";
    return text + "</VTKFile>\n";
  }

 private:
  template <class Number>
  void put(std::string& bytes, Number number) const {
    std::string word(reinterpret_cast<const char*>(&number), sizeof(number));
    if (style_.big_endian) std::reverse(word.begin(), word.end());
    bytes += word;
  }
  void put_head(std::string& bytes, std::uint64_t number) const {
    if (style_.wide_heads) {
      put(bytes, number);
    } else {
      put(bytes, static_cast<std::uint32_t>(number));
    }
  }

  /// With its head, in letters or as it is.
  std::string coded(const std::string& data, bool letters) const {
    std::string head;
    if (!style_.compressed) {
      put_head(head, data.size());
      return letters ? base64(head + data) : head + data;
    }
    constexpr std::size_t kBlock = 64;
    const std::size_t num_blocks = (data.size() + kBlock - 1) / kBlock;
    put_head(head, num_blocks);
    put_head(head, kBlock);
    put_head(head, data.size() % kBlock);
    std::string packed;
    for (std::size_t at = 0; at < data.size(); at += kBlock) {
      const std::string block = data.substr(at, kBlock);
      std::string space(compressBound(block.size()), '\0');
      uLongf size = space.size();
      compress(reinterpret_cast<Bytef*>(space.data()),
               &size,
               reinterpret_cast<const Bytef*>(block.data()),
               block.size());
      put_head(head, size);
      packed += space.substr(0, size);
    }
    return letters ? base64(head) + base64(packed) : head + packed;
  }

  VtpStyle style_;
  std::string appended_;
};

}  // namespace

std::string box_vtp_file(const VtpStyle& style) {
  Writer writer(style);
  std::vector<float> places;
  for (int corner = 0; corner < 8; ++corner) {
    places.push_back(corner & 1 ? 14.0F : 10.0F);
    places.push_back(corner & 2 ? 26.0F : 20.0F);
    places.push_back(corner & 4 ? 38.0F : 30.0F);
  }
  std::string piece =
      "<Points>" + writer.array("Points", "Float32", places, 3) + "</Points><Polys>";
  piece += writer.array<std::int64_t>(
      "connectivity", "Int64", {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2});
  piece += writer.array<std::int64_t>("offsets", "Int64", {4, 8, 12, 16, 20}) + "</Polys><Strips>";
  piece += writer.array<std::int32_t>("connectivity", "Int32", {1, 3, 5, 7});
  piece += writer.array<std::int32_t>("offsets", "Int32", {4}) + "</Strips>";
  return writer.file(piece, "NumberOfPoints=\"8\" NumberOfPolys=\"5\" NumberOfStrips=\"1\"");
}

}  // namespace mor::testing_files
