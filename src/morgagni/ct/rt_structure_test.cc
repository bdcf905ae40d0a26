// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// DICOM RT Structure Sets as label maps.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/ct/label_map.h"
#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"
#include "morgagni/ct/testing/import_folder.h"
#include "morgagni/ct/testing/structure_set_writer.h"

namespace mor {
namespace {

using testing::HasSubstr;
using namespace testing_dicom;

const Eigen::Vector3d kMiddle(10, 20, 30);

/// Circles of a ball, a plane every 2.5 mm, along the given axes.
std::vector<ContourText> ball(double radius_mm,
                              const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) {
  std::vector<ContourText> contours;
  for (double height = -2.5 * std::floor(radius_mm / 2.5); height < radius_mm; height += 2.5) {
    const double around = std::sqrt(radius_mm * radius_mm - height * height);
    ContourText contour;
    for (int i = 0; i < 60; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 60;
      contour.places.emplace_back(kMiddle + axes * Eigen::Vector3d(around * std::cos(angle),
                                                                   around * std::sin(angle),
                                                                   height));
    }
    if (around > 1.0) contours.push_back(contour);
  }
  return contours;
}

class RtStructures : public ImportFolder {
 protected:
  std::string refusal(const std::string& bytes) {
    const auto maps = import_label_maps(write("bad.dcm", bytes), {});
    return maps ? "no error" : maps.error().message;
  }
};

double volume_of(int radius_mm) {
  return 4.0 / 3.0 * std::numbers::pi * std::pow(radius_mm, 3);
}

TEST_F(RtStructures, BecomeClosedSurfacesThatMayOverlap) {
  auto shell = ball(25);
  for (const auto& hole : ball(15)) shell.push_back(hole);
  const auto path =
      write("set.dcm",
            structure_set_file(
                {{"tumour", ball(20)}, {"isocentre", {{{kMiddle}, "POINT"}}}, {"shell", shell}}));
  const auto maps = import_label_maps(path, {});
  ASSERT_TRUE(maps) << maps.error().message;
  ASSERT_EQ(maps->size(), 2U) << "the point is no structure";
  const auto surface_of = [&](std::size_t i) {
    const auto surfaces = extract_labels((*maps)[i], {}, {});
    EXPECT_TRUE(surfaces) << surfaces.error().message;
    EXPECT_EQ(surfaces->size(), 1U);
    return surfaces->front();
  };
  const auto tumour = surface_of(0);
  EXPECT_EQ(tumour.name, "tumour");
  EXPECT_NEAR(tumour.color.x(), 1.0F, 1e-3F);
  EXPECT_NEAR(tumour.color.z(), 0.2F, 1e-3F);
  EXPECT_EQ(mesh_topology(tumour.mesh).num_open_edges, 0);
  EXPECT_NEAR(enclosed_volume_mm3(tumour.mesh), volume_of(20), 0.06 * volume_of(20));
  EXPECT_LT((tumour.mesh.bounds().center().cast<double>() - kMiddle).norm(), 0.7);
  EXPECT_EQ(surface_of(1).name, "shell");
  EXPECT_NEAR(
      enclosed_volume_mm3(surface_of(1).mesh), volume_of(25) - volume_of(15), 0.08 * volume_of(25))
      << "contours within contours are holes";
}

/// Of a tilted scan the contours are tilted, too.
TEST_F(RtStructures, AreTakenAsTheyAreTilted) {
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto maps =
      import_label_maps(write("set.dcm", structure_set_file({{"ball", ball(20, axes)}})), {});
  ASSERT_TRUE(maps) << maps.error().message;
  const auto surface = extract_labels(maps->front(), {}, {}).value().front();
  EXPECT_NEAR(enclosed_volume_mm3(surface.mesh), volume_of(20), 0.06 * volume_of(20));
  EXPECT_LT((surface.mesh.bounds().center().cast<double>() - kMiddle).norm(), 0.7);
}

TEST_F(RtStructures, SayWhatIsWrong) {
  auto bent = ball(20);
  bent.front().places.front().z() += 4.0;
  auto far = ball(20);
  far.front().places.front().x() = 90000.0;
  EXPECT_THAT(refusal(structure_set_file({})), HasSubstr("no structure with closed contours"));
  EXPECT_THAT(refusal(structure_set_file({{"point", {{{kMiddle}, "POINT"}}}})),
              HasSubstr("no structure with closed contours"));
  EXPECT_THAT(refusal(structure_set_file({{"bent", bent}})), HasSubstr("not flat or not parallel"));
  EXPECT_THAT(refusal(structure_set_file({{"far", far}})), HasSubstr("no structure of a body"));
  for (const char* data :
       {"1\\2", "1\\2\\3\\4", "1\\2\\3\\4\\5\\6", "a\\b\\c", "1e300\\0\\0\\0\\1\\0\\1\\1\\0"})
    EXPECT_THAT(refusal(structure_set_file({{"odd", ball(20)}}, data)),
                HasSubstr("damaged contour"))
        << data;
  const std::string good = structure_set_file({{"ball", ball(20)}});
  for (const std::size_t at : {good.size() / 4, good.size() / 2, good.size() - 3}) {
    EXPECT_THAT(refusal(good.substr(0, at)), testing::Not(HasSubstr("no error")));
  }
  // A line without an inside: a map without a label, and a sentence when a surface is wanted of it.
  const auto line = import_label_maps(
      write("line.dcm", structure_set_file({{"line", ball(20)}}, "0\\0\\0\\1\\0\\0\\2\\0\\0")), {});
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_THAT(extract_labels(line->front(), {}, {}).error().message, HasSubstr("no label"));
}

}  // namespace
}  // namespace mor
