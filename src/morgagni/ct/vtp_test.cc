// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// VTK XML PolyData as VTK's file format document has it, in every way that numbers may be written;
// and in ways they may not.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/structure_mesh.h"
#include "morgagni/ct/test_volumes.h"
#include "morgagni/ct/testing/import_folder.h"
#include "morgagni/ct/testing/vtp_writer.h"

namespace mor {
namespace {

using testing::HasSubstr;
using testing_files::box_vtp_file;

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
      const testing_files::VtpStyle style = {
          format, encoding, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
      SCOPED_TRACE(fmt::format("{} {} {}", format, encoding, bits));
      const auto surface = import_structure_mesh(write("box.vtp", box_vtp_file(style)), {}, {});
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

/// ParaView says the range of a vector's lengths so, behind the numbers.
TEST_F(Vtp, TakesNoKeyOfAnArrayForItsNumbers) {
  for (const char* format : {"ascii", "binary"}) {
    std::string text = box_vtp_file({.format = format});
    text.insert(text.find("</DataArray>"),
                "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\">"
                "<Value index=\"0\">1</Value><Value index=\"1\">7</Value></InformationKey>\n");
    const auto surface = import_structure_mesh(write("box.vtp", text), {}, {});
    ASSERT_TRUE(surface) << surface.error().message;
    EXPECT_EQ(surface->mesh.vertices.size(), 8U);
    EXPECT_NEAR(enclosed_volume_mm3(surface->mesh), 192.0, 1e-3);
  }
}

TEST_F(Vtp, SaysWhatIsWrong) {
  const std::string plain = box_vtp_file({});
  const std::string raw = box_vtp_file({"appended", "raw"});
  const std::string packed = box_vtp_file({"appended", "raw", true});
  const std::string letters = box_vtp_file({"binary", "", true});
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
              HasSubstr("a piece announces 9 points, 8 are there"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"7\"")),
              HasSubstr("the numbers of its Points"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"99999999999\"")),
              HasSubstr("the limit is"));
  EXPECT_THAT(refusal(with(plain, "NumberOfPolys=\"5\"", "NumberOfPolys=\"x\"")),
              HasSubstr("NumberOfPolys is no number"));
  EXPECT_THAT(refusal(with(plain, "0 2 3 1", "0 2 3 8")),
              HasSubstr("a corner names point 8, there are 0 to 7"));
  EXPECT_THAT(refusal(with(plain, "0 2 3 1", "0 2 3 -1")), HasSubstr("a corner names point -1"));
  EXPECT_THAT(refusal(with(plain, "4 8 12", "4 3 12")),
              HasSubstr("Polys have the offset 3 where 4 to 20 are possible"));
  EXPECT_THAT(refusal(with(plain, "4 8 12 16 20", "4 8 12 16 nan")),
              HasSubstr("Polys end with the offset nan"));
  EXPECT_THAT(refusal(with(plain, "10 20 30", "inf 20 30")), HasSubstr("not a finite number"));
  EXPECT_THAT(refusal(with(plain, "Float32", "Float99")), HasSubstr("numbers of type \"Float99\""));
  EXPECT_THAT(refusal(with(raw, "offset=\"0\"", "offset=\"9999999\"")),
              HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(raw.substr(0, raw.find("  _") + 30)), HasSubstr("the data of"));
  // Lengths that lie.
  const auto spoilt = [](std::string bytes, std::size_t at, const std::string& instead) {
    return bytes.replace(bytes.find("  _") + 3 + at, instead.size(), instead);
  };
  EXPECT_THAT(refusal(spoilt(raw, 0, "\xff\xff\xff\xff")), HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(spoilt(packed, 0, "\xff\xff\xff\xff")), HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(spoilt(packed, 4, "\xff\xff\xff\x7f")), HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(spoilt(packed, 12, "\xff\xff\xff\x7f")), HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(spoilt(packed, 24, "garbage")), HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal(with(letters, "format=\"binary\">\n  ", "format=\"binary\">\n  ****")),
              HasSubstr("the data of its Points"));
  EXPECT_THAT(refusal("<VTKFile type=\"PolyData\"></VTKFile>"), HasSubstr("has no triangles"));
}

}  // namespace
}  // namespace mor
