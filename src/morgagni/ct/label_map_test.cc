// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/label_map.h"

#include <cmath>
#include <cstring>
#include <ctime>
#include <functional>
#include <set>

#include <gmock/gmock.h>

#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"
#include "morgagni/ct/testing/import_folder.h"

namespace mor {
namespace {

using testing::HasSubstr;

using LabelOf = std::function<int(int, int, int)>;

Volume labels_of(const std::array<int, 3>& size, const LabelOf& label_of) {
  Volume volume;
  volume.size = size;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        volume.hu.push_back(static_cast<std::int16_t>(label_of(x, y, z)));
  return volume;
}

int two_balls(int x, int y, int z) {
  const auto within = [&](double cx, double radius) {
    return std::hypot(x - cx, y - 20.0, z - 20.0) < radius;
  };
  return within(15, 10) ? 3 : within(45, 12) ? 51 : 0;
}

TEST(ExtractLabels, GivesClosedSmoothSurfacesWithNames) {
  LabelMap labels = {labels_of({60, 40, 40}, two_balls), {{51, "heart", {0.7F, 0.2F, 0.2F}}}};
  labels.voxels.ct_from_grid.translation() = Eigen::Vector3d(100, 0, 0);
  const auto surfaces = extract_labels(labels, {.num_triangles = 2000}, {});
  ASSERT_TRUE(surfaces) << surfaces.error().message;
  ASSERT_EQ(surfaces->size(), 2U);
  EXPECT_EQ((*surfaces)[0].name, "label 3");
  EXPECT_EQ((*surfaces)[1].name, "heart");
  EXPECT_EQ((*surfaces)[1].color, Eigen::Vector3f(0.7F, 0.2F, 0.2F));
  const auto& heart = (*surfaces)[1].mesh;
  EXPECT_LE(heart.triangles.size(), 2050U);
  const auto topology = mesh_topology(heart);
  EXPECT_EQ(topology.num_open_edges, 0);
  EXPECT_EQ(topology.num_components, 1);
  EXPECT_EQ(heart.normals.size(), heart.vertices.size());
  EXPECT_NEAR(enclosed_volume_mm3(heart), 4.0 / 3.0 * 3.14159 * 12 * 12 * 12, 250.0);
  double worst_mm = 0.0;
  for (const auto& vertex : heart.vertices)
    worst_mm = std::max(worst_mm, std::abs((vertex - Eigen::Vector3f(145, 20, 20)).norm() - 11.8));
  EXPECT_LT(worst_mm, 0.6) << "no stairs of a whole voxel";
}

TEST(ExtractLabels, ClosesAStructureAtTheVolumesFace) {
  const LabelMap labels = {labels_of({20, 20, 20}, [](int x, int, int) { return x < 8 ? 1 : 0; }),
                           {}};
  const auto surfaces = extract_labels(labels, {}, {});
  ASSERT_TRUE(surfaces);
  EXPECT_EQ(mesh_topology(surfaces->front().mesh).num_open_edges, 0);
}

/// A thing of known shape in voxels of 1 mm, slanted against them.
struct Thin {
  const char* name;
  std::function<double(const Eigen::Vector3d&)> depth_mm;  ///< Positive inside.
};

/// Smoothing must not waste away what is a few voxels thin.
TEST(ExtractLabels, KeepsThinSheetsAndRods) {
  const Eigen::Vector3d middle(40, 40, 40);
  const Eigen::Vector3d along = Eigen::Vector3d(0.2, 0.3, 1.0).normalized();
  const auto sheet = [&](double thick_mm) {
    return [=](const Eigen::Vector3d& place) {
      const Eigen::Vector3d from = place - middle;
      const double high_mm = from.dot(along);
      return std::min(0.5 * thick_mm - std::abs(high_mm), 30.0 - (from - high_mm * along).norm());
    };
  };
  const auto rod = [&](double thick_mm) {
    return [=](const Eigen::Vector3d& place) {
      const Eigen::Vector3d from = place - middle;
      const double high_mm = from.dot(along);
      return std::min(0.5 * thick_mm - (from - high_mm * along).norm(), 30.0 - std::abs(high_mm));
    };
  };
  const auto one_voxel = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d from = place - middle;
    return std::min(0.5 - std::abs(from.z()), 30.0 - from.head<2>().norm());
  };
  for (const Thin& thin : {Thin{"sheet of one voxel", one_voxel},
                           Thin{"sheet of 2 mm", sheet(2.0)},
                           Thin{"sheet of 3 mm", sheet(3.0)},
                           Thin{"rod of 3 mm", rod(3.0)},
                           Thin{"rod of 5 mm", rod(5.0)}}) {
    const LabelMap labels = {labels_of({81, 81, 81},
                                       [&](int x, int y, int z) {
                                         return thin.depth_mm(Eigen::Vector3d(x, y, z)) > 0.0 ? 1
                                                                                              : 0;
                                       }),
                             {}};
    const auto num_voxels =
        static_cast<double>(std::count(labels.voxels.hu.begin(), labels.voxels.hu.end(), 1));
    const auto surfaces = extract_labels(labels, {}, {});
    ASSERT_TRUE(surfaces) << thin.name;
    const auto& mesh = surfaces->front().mesh;
    EXPECT_NEAR(enclosed_volume_mm3(mesh) / num_voxels, 1.0, 0.03) << thin.name;
    double worst_mm = 0.0;
    for (const auto& vertex : mesh.vertices)
      worst_mm = std::max(worst_mm, std::abs(thin.depth_mm(vertex.cast<double>())));
    EXPECT_LE(worst_mm, 0.501) << thin.name;
    EXPECT_EQ(mesh_topology(mesh).num_components, 1) << thin.name;
    EXPECT_EQ(mesh_topology(mesh).num_open_edges, 0) << thin.name;
  }
}

TEST(ExtractLabels, SaysWhatIsWrong) {
  const auto message = [](const LabelMap& labels, const LabelSurfaceOptions& options = {}) {
    const auto surfaces = extract_labels(labels, options, {});
    return surfaces ? std::string("no error") : surfaces.error().message;
  };
  const LabelMap none = {labels_of({4, 4, 4}, [](int, int, int) { return 0; }), {}};
  EXPECT_THAT(message(none), HasSubstr("holds no label above 0"));
  const LabelMap many = {
      labels_of({8, 8, 8}, [](int x, int y, int z) { return 1 + x + 8 * y + 64 * z; }), {}};
  EXPECT_THAT(message(many), HasSubstr("512 labels, at most 200 are drawn: is it a CT?"));
  EXPECT_THAT(message(none, {.num_triangles = 3}), HasSubstr("num_triangles must be in"));
}

TEST(ExtractLabels, TakesUnderFiveSecondsForALargeLabel) {
  const auto within = [](double x, double y, double z) { return x * x + y * y + z * z < 1.0; };
  const LabelMap labels = {
      labels_of({512, 512, 300},
                [&](int x, int y, int z) {
                  return within((x - 256) / 200.0, (y - 256) / 150.0, (z - 150) / 120.0) ? 5 : 0;
                }),
      {}};
  const std::clock_t start = std::clock();
  const auto surfaces = extract_labels(labels, {}, {});
  ASSERT_TRUE(surfaces);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 5.0) << "processor seconds";
}

TEST(TotalSegmentator, HasDistinctNamesAtTheirNumbers) {
  const auto names = total_segmentator_names();
  ASSERT_EQ(names.size(), 117U);
  EXPECT_EQ(names[4].name, "liver");
  EXPECT_EQ(names[50].name, "heart");
  EXPECT_EQ(names[90].name, "skull");
  EXPECT_EQ(names[116].name, "costal_cartilages");
  std::set<std::string> distinct;
  for (const auto& name : names) distinct.insert(name.name);
  EXPECT_EQ(distinct.size(), names.size());
}

class ImportLabels : public ImportFolder {
 protected:
  static std::string message_of(const std::filesystem::path& path) {
    const auto labels = import_label_map(path, {});
    return labels ? "no error" : labels.error().message;
  }
};

TEST_F(ImportLabels, TakesNamesAndColoursFromSlicersHead) {
  const std::string head =
      "NRRD0004\ntype: uchar\nencoding: raw\ndimension: 3\nsizes: 4 3 2\n"
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
      "space origin: (5,6,7)\nSegment0_Name:=liver\nSegment0_LabelValue:=2\n"
      "Segment0_Color:=0.5 0.25 0.125\nSegment1_Name:=bullet\nSegment1_LabelValue:=9\n\n";
  const auto labels = import_label_map(write("map.seg.nrrd", head + std::string(24, '\2')), {});
  ASSERT_TRUE(labels) << labels.error().message;
  EXPECT_EQ(labels->voxels.hu, HuArray(24, 2));
  EXPECT_TRUE(labels->voxels.ct_from_grid.translation().isApprox(Eigen::Vector3d(5, 6, 7)));
  ASSERT_EQ(labels->names.size(), 2U);
  EXPECT_EQ(labels->names[0].value, 2);
  EXPECT_EQ(labels->names[0].name, "liver");
  EXPECT_TRUE(labels->names[0].color.isApprox(Eigen::Vector3f(0.5F, 0.25F, 0.125F)));
  EXPECT_EQ(labels->names[1].name, "bullet");
}

TEST_F(ImportLabels, TakesNothingThatCannotBeShown) {
  const std::string head =
      "NRRD0004\ntype: uchar\nencoding: raw\ndimension: 3\nsizes: 4 3 2\n"
      "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
      "space origin: (5,6,7)\nSegment0_Name:=Sch\xe4"
      "del\x1b[31m\nSegment0_LabelValue:=2\nSegment0_Color:=nan 1e300 -1\n"
      "Segment1_Name:=far\nSegment1_LabelValue:=1e300\nSegment2_Name:=" +
      std::string(79, 'x') + "\xc3\xa4\nSegment2_LabelValue:=3\n\n";
  const auto labels = import_label_map(write("map.seg.nrrd", head + std::string(24, '\2')), {});
  ASSERT_TRUE(labels) << labels.error().message;
  ASSERT_EQ(labels->names.size(), 2U) << "a label beyond 32767 names nothing";
  EXPECT_EQ(labels->names[0].name, "Sch\u00e4del [31m");
  EXPECT_TRUE(labels->names[0].color.isApprox(Eigen::Vector3f(0, 1, 0)));
  EXPECT_EQ(labels->names[1].name, std::string(79, 'x')) << "no half of a letter";
}

/// A NIfTI as TotalSegmentator writes it: the label table in an extension behind the head.
TEST_F(ImportLabels, TakesNamesFromTotalSegmentatorsTable) {
  std::string table =
      "<CaretExtension><LabelTable><Label Key=\"5\" Red=\"0.5\" Green=\"0.25\" Blue=\"0\" "
      "Alpha=\"1\"><![CDATA[liver]]></Label></LabelTable></CaretExtension>";
  table.resize((table.size() + 8 + 15) / 16 * 16 - 8, ' ');
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, const auto& value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  put(0, std::int32_t{348});
  put(40, std::array<std::int16_t, 8>{3, 4, 3, 2, 1, 1, 1, 1});
  put(70, std::int16_t{2});
  put(72, std::int16_t{8});
  put(76, std::array<float, 8>{1, 1, 1, 1, 0, 0, 0, 0});
  put(108, static_cast<float>(352 + 8 + table.size()));
  std::memcpy(bytes.data() + 344, "n+1\0\1", 5);
  const std::array<std::int32_t, 2> extension = {static_cast<std::int32_t>(8 + table.size()), 0};
  bytes.append(reinterpret_cast<const char*>(extension.data()), sizeof(extension));
  const auto labels = import_label_map(write("map.nii", bytes + table + std::string(24, '\5')), {});
  ASSERT_TRUE(labels) << labels.error().message;
  ASSERT_EQ(labels->names.size(), 1U);
  EXPECT_EQ(labels->names[0].value, 5);
  EXPECT_EQ(labels->names[0].name, "liver");
}

TEST_F(ImportLabels, RefusesWhatIsNoLabelMap) {
  const auto mha = [&](const std::string& type, const std::string& voxels) {
    return write(
        "map.mha",
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
        "DimSize = 2 2 2\nElementType = " +
            type + "\nElementDataFile = LOCAL\n" + voxels);
  };
  std::string halves;
  for (int i = 0; i < 8; ++i) halves += std::string("\0\0\0\x3f", 4);
  EXPECT_THAT(message_of(mha("MET_FLOAT", halves)),
              HasSubstr("is 0.500000, labels are whole numbers"));
  EXPECT_THAT(message_of(mha("MET_SHORT", std::string(16, '\xfc'))),
              HasSubstr("labels are whole numbers"));
  EXPECT_THAT(message_of(folder_ / "none.nii"), HasSubstr("there is no file"));
}

}  // namespace
}  // namespace mor
