// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/viewer.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/documentation/internal/viewer_volume.h"
#include "morgagni/documentation/testing/tube_body.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

double hu_of_code(int code) {
  const auto& knots = internal::kHuCodes;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (code > knots[i].code) continue;
    const double share =
        static_cast<double>(code - knots[i - 1].code) / (knots[i].code - knots[i - 1].code);
    return knots[i - 1].hu + share * (knots[i].hu - knots[i - 1].hu);
  }
  return knots.back().hu;
}

TEST(ViewerVolume, CodesKeepSoftTissueToTwoHu) {
  for (int hu = -200; hu <= 300; ++hu) EXPECT_NEAR(hu_of_code(internal::code_of_hu(hu)), hu, 2.01);
  for (int hu = -1000; hu <= 1880; ++hu)
    EXPECT_NEAR(hu_of_code(internal::code_of_hu(hu)), hu, 10.01);
  EXPECT_EQ(internal::code_of_hu(-3000), 1);
  EXPECT_EQ(internal::code_of_hu(5000), 255);
}

/// A block of 100 HU with a gradient along z, air of the table around.
Volume block_volume() {
  Volume volume;
  volume.size = {40, 30, 20};
  volume.spacing_mm = {1.0, 1.0, 2.0};
  volume.ct_from_grid.translation() = Eigen::Vector3d(-100.0, 50.0, 7.0);
  volume.hu.assign(40 * 30 * 20, kOutsideHu);
  for (int z = 0; z < 20; ++z)
    for (int y = 4; y < 28; ++y)
      for (int x = 8; x < 40; ++x)
        volume.hu[volume.index(x, y, z)] = static_cast<std::int16_t>(100 + 4 * z);
  return volume;
}

TEST(ViewerVolume, ShrinksTheBodysBoxInItsPlace) {
  const auto volume = block_volume();
  const auto small = internal::shrink_volume(volume, 20);
  EXPECT_EQ(small.size, (std::array<int, 3>{16, 12, 20}));
  EXPECT_EQ(small.spacing_mm, Eigen::Vector3d(2.0, 2.0, 2.0));
  // The first block's centre lies between the voxels 8 and 9, 4 and 5.
  EXPECT_LT((small.ct_from_grid.translation() - Eigen::Vector3d(-91.5, 54.5, 7.0)).norm(), 1e-9);
  ASSERT_EQ(small.codes.size(), 16U * 12U * 20U);
  for (int z = 0; z < 20; ++z) {
    const auto code = static_cast<std::uint8_t>(small.codes[static_cast<std::size_t>(z) * 192]);
    EXPECT_NEAR(hu_of_code(code), 100 + 4 * z, 2.01);
  }
}

class FilledViewer : public ::testing::Test {
 protected:
  fs::path file_ = fs::temp_directory_path() / ("morgagni-viewer-" + std::to_string(getpid()));
  DocumentSource source_;
  ExportModel model_ = testing_body::tube_model();

  void SetUp() override {
    ASSERT_TRUE(write_file(file_, "<html><!-- morgagni: case --></html>"));
    source_.case_name = "case";
    source_.volume = std::make_shared<const Volume>(block_volume());
  }
  void TearDown() override { fs::remove(file_); }
};

TEST_F(FilledViewer, NoWordOfPeopleLeavesItsBlock) {
  source_.case_name = "</script><script>alert(1)</script>";
  Finding finding;
  finding.id = "F1";
  finding.note = "<!-- </SCRIPT > <script>alert(2)</script> \xFF";
  finding.photo = "../../etc/passwd";
  source_.findings = {finding};
  const auto page = fill_viewer(source_, model_, {"t", ""}, file_);
  ASSERT_TRUE(page.has_value()) << page.error().message;
  // Three blocks of data are all that the page got.
  std::size_t num_tags = 0;
  for (auto at = page->html.find('<'); at != std::string::npos; at = page->html.find('<', at + 1))
    ++num_tags;
  EXPECT_EQ(num_tags, 2U + 2U * 3U);
  EXPECT_THAT(page->html, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
  EXPECT_THAT(page->remarks, ::testing::Contains(HasSubstr("1 photos of findings are left out")));
}

TEST_F(FilledViewer, SaysWhatItsVoxelsAre) {
  const auto page = fill_viewer(source_, model_, {"t", ""}, file_);
  ASSERT_TRUE(page.has_value());
  EXPECT_THAT(page->remarks,
              ::testing::Contains(HasSubstr("voxels of 1.00 x 1.00 x 2.00 mm (of 1.00 x 1.00")));
  source_.volume = nullptr;
  EXPECT_THAT(fill_viewer(source_, model_, {"t", ""}, file_)->html, HasSubstr("\"volume\":null"));
}

TEST_F(FilledViewer, MakesManyTrianglesFewer) {
  model_.structures[0] = subdivided(model_.structures[0], 5);
  ASSERT_GT(model_.structures[0].mesh.triangles.size(), 500'000U);
  const auto page = fill_viewer(source_, model_, {"t", ""}, file_);
  ASSERT_TRUE(page.has_value());
  EXPECT_THAT(page->remarks, ::testing::Contains(HasSubstr("the structures are coarser")));
  EXPECT_LT(page->html.size(), kMaxViewerBytes);
}

TEST_F(FilledViewer, WantsTheBuiltPage) {
  EXPECT_THAT(fill_viewer(source_, model_, {}, "/nowhere/viewer.html").error().message,
              HasSubstr("the viewer page is not built"));
  ASSERT_TRUE(write_file(file_, "<html></html>"));
  EXPECT_THAT(fill_viewer(source_, model_, {}, file_).error().message,
              HasSubstr("is not the viewer page"));
}

}  // namespace
}  // namespace mor
