// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// VTK XML PolyData as VTK's file format document has it, in every way that numbers may be written;
// and in ways they may not.
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <zlib.h>

#include "morgagni/ct/structure_mesh.h"
#include "morgagni/ct/test_volumes.h"
#include "morgagni/ct/testing/import_folder.h"

namespace mor {
namespace {

using testing::HasSubstr;

struct Coding {
  std::string format = "ascii";  ///< "ascii", "binary", "appended".
  std::string encoding = "raw";  ///< Of what is appended: "raw", "base64".
  bool compressed = false;
  bool wide_heads = false;
  bool big_endian = false;
};

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
  explicit Writer(Coding coding) : coding_(std::move(coding)) {}

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
                    coding_.format);
    if (coding_.format == "ascii")
      return head + fmt::format(">{}</DataArray>", fmt::join(numbers, " "));
    std::string data;
    for (Number number : numbers) put(data, number);
    if (coding_.format == "binary") return head + ">\n  " + coded(data, true) + "\n</DataArray>";
    head += fmt::format(" offset=\"{}\"/>", appended_.size());
    appended_ += coded(data, coding_.encoding == "base64");
    return head;
  }

  std::string file(const std::string& piece, const std::string& counts) const {
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" "
        "header_type=\"{}\"{}>\n"
        "<PolyData><Piece {}>{}</Piece></PolyData>\n",
        coding_.big_endian ? "BigEndian" : "LittleEndian",
        coding_.wide_heads ? "UInt64" : "UInt32",
        coding_.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "",
        counts,
        piece);
    if (coding_.format == "appended")
      text += fmt::format("<AppendedData encoding=\"{}\">\n  _", coding_.encoding) + appended_ +
              "\n</AppendedData>\n";
    return text + "</VTKFile>\n";
  }

 private:
  template <class Number>
  void put(std::string& bytes, Number number) const {
    std::string word(reinterpret_cast<const char*>(&number), sizeof(number));
    if (coding_.big_endian) std::reverse(word.begin(), word.end());
    bytes += word;
  }
  void put_head(std::string& bytes, std::uint64_t number) const {
    if (coding_.wide_heads) {
      put(bytes, number);
    } else {
      put(bytes, static_cast<std::uint32_t>(number));
    }
  }

  /// With its head, in letters or as it is.
  std::string coded(const std::string& data, bool letters) const {
    std::string head;
    if (!coding_.compressed) {
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

  Coding coding_;
  std::string appended_;
};

/// A box from (10, 20, 30) to (14, 26, 38) of four-cornered polygons and one strip.
std::string box_file(const Coding& coding) {
  Writer writer(coding);
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

class Vtp : public ImportFolder {
 protected:
  std::string refusal(const std::string& bytes) {
    const auto mesh = import_structure_mesh(write("bad.vtp", bytes), {}, {});
    return mesh ? "no error" : mesh.error().message;
  }
};

TEST_F(Vtp, IsReadHoweverItsNumbersAreWritten) {
  for (const auto& [format, encoding] : {std::pair("ascii", ""),
                                         std::pair("binary", ""),
                                         std::pair("appended", "base64"),
                                         std::pair("appended", "raw")}) {
    for (int bits = 0; bits < 8; ++bits) {
      const Coding coding = {format, encoding, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
      SCOPED_TRACE(fmt::format("{} {} {}", format, encoding, bits));
      const auto surface = import_structure_mesh(write("box.vtp", box_file(coding)), {}, {});
      ASSERT_TRUE(surface) << surface.error().message;
      EXPECT_EQ(surface->name, "box");
      EXPECT_EQ(surface->mesh.vertices.size(), 8U);
      EXPECT_EQ(surface->mesh.triangles.size(), 12U);
      EXPECT_NEAR(enclosed_volume_mm3(surface->mesh), 192.0, 1e-3) << "and not inside out";
      EXPECT_LT((surface->mesh.bounds().min() - Eigen::Vector3f(10, 20, 30)).norm(), 1e-5F);
    }
  }
}

std::string with(std::string text, const std::string& what, const std::string& instead) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), instead);
}

TEST_F(Vtp, SaysWhatIsWrong) {
  const std::string plain = box_file({});
  const std::string raw = box_file({"appended", "raw"});
  const std::string packed = box_file({"appended", "raw", true});
  const std::string letters = box_file({"binary", "", true});
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("what is this"), HasSubstr("it is no XML"));
  EXPECT_THAT(refusal(plain.substr(0, 500)), HasSubstr("cut short or damaged"));
  EXPECT_THAT(refusal("<html></html>"), HasSubstr("is no VTK XML file"));
  EXPECT_THAT(refusal(with(plain, "PolyData", "ImageData")),
              HasSubstr("holds a VTK \"ImageData\""));
  EXPECT_THAT(refusal(with(packed, "vtkZLib", "vtkLZMA")),
              HasSubstr("compressed with vtkLZMADataCompressor"));
  EXPECT_THAT(refusal("<!DOCTYPE a [<!ENTITY b \"bb\">]>" + plain.substr(22)),
              HasSubstr("declares a document type"));
  std::string deep = "<VTKFile type=\"PolyData\">";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_THAT(refusal(deep), HasSubstr("nests deeper than 64 levels"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"9\"")),
              HasSubstr("too few points"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"7\"")),
              HasSubstr("the numbers of Points"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"99999999999\"")),
              HasSubstr("the limit is"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPolys=\"5\"", "NumberOfPolys=\"x\"")),
              HasSubstr("NumberOfPolys is no number"));
  EXPECT_THAT(refusal(with(plain, "0 2 3 1", "0 2 3 8")), HasSubstr("a corner names no point"));
  EXPECT_THAT(refusal(with(plain, "0 2 3 1", "0 2 3 -1")), HasSubstr("a corner names no point"));
  EXPECT_THAT(refusal(with(plain, "4 8 12", "4 3 12")), HasSubstr("offsets that are none"));
  EXPECT_THAT(refusal(with(plain, "4 8 12 16 20", "4 8 12 16 nan")),
              HasSubstr("offsets that are none"));
  EXPECT_THAT(refusal(with(plain, "10 20 30", "inf 20 30")), HasSubstr("not a finite number"));
  EXPECT_THAT(refusal(with(plain, "Float32", "Float99")), HasSubstr("numbers of type \"Float99\""));
  EXPECT_THAT(refusal(with(raw, "offset=\"0\"", "offset=\"9999999\"")),
              HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(raw.substr(0, raw.find("  _") + 30)), HasSubstr("the data of"));
  // Lengths that lie.
  const auto spoilt = [](std::string bytes, std::size_t at, const std::string& instead) {
    return bytes.replace(bytes.find("  _") + 3 + at, instead.size(), instead);
  };
  EXPECT_THAT(refusal(spoilt(raw, 0, "\xff\xff\xff\xff")), HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(spoilt(packed, 0, "\xff\xff\xff\xff")), HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(spoilt(packed, 4, "\xff\xff\xff\x7f")), HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(spoilt(packed, 12, "\xff\xff\xff\x7f")), HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(spoilt(packed, 24, "garbage")), HasSubstr("the data of Points"));
  EXPECT_THAT(refusal(with(letters, "format=\"binary\">\n  ", "format=\"binary\">\n  ****")),
              HasSubstr("the data of Points"));
  EXPECT_THAT(refusal("<VTKFile type=\"PolyData\"></VTKFile>"), HasSubstr("has no triangles"));
}

}  // namespace
}  // namespace mor
