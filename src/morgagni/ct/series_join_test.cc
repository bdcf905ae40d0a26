// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// A made body, scanned in pieces that overlap, and joined again.
#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/ct/join_volumes.h"
#include "morgagni/ct/testing/dicom_writer.h"
#include "morgagni/ct/testing/import_folder.h"
#include "morgagni/ct/volume_alignment.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing_dicom::slice_file;
using testing_dicom::SliceText;

/// A trunk of flesh with balls of bone, fat and air in it, none like the other, on a table.
class Body {
 public:
  explicit Body(unsigned seed = 7) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (int i = 0; i < 60; ++i)
      balls_.push_back({{between(-80, 80), between(-50, 50), between(-180, 180)},
                        between(6, 20),
                        between(-250, 450)});
  }

  /// @param table_mm  How far the table lies below the middle.
  [[nodiscard]] double hu_at(const Eigen::Vector3d& p, double table_mm = 75.0) const {
    const double trunk = std::hypot(p.x() / (95.0 + 0.05 * p.z()), p.y() / 60.0);
    if (trunk >= 1.0) return std::abs(p.y() - table_mm) < 3.0 ? -150.0 : -1000.0;
    for (const auto& ball : balls_) {
      if ((p - ball.middle).squaredNorm() >= ball.radius * ball.radius) continue;
      // Outermost a body has skin, fat and flesh: bone or gas there would be taken for a cover.
      return trunk > kSkinFrom ? std::clamp(ball.hu, -120.0, 90.0) : ball.hu;
    }
    return 40.0;
  }

 private:
  static constexpr double kSkinFrom = 0.9;

  struct Ball {
    Eigen::Vector3d middle;
    double radius;
    double hu;
  };
  std::vector<Ball> balls_;
};

struct Scan {
  double from_z_mm = -120.0;
  double to_z_mm = 120.0;
  Eigen::Vector3d spacing_mm = {3.0, 3.0, 3.0};
  double table_mm = 75.0;
  double hu_offset = 0.0;
  Eigen::Isometry3d scanner_from_body = Eigen::Isometry3d::Identity();
};

/// The mean of eight places in each voxel, as a scanner sees it.
Volume scanned(const Body& body, const Scan& scan) {
  Volume volume;
  const Eigen::Vector3d low(-120, -90, scan.from_z_mm);
  const Eigen::Vector3d high(120, 90, scan.to_z_mm);
  for (int axis = 0; axis < 3; ++axis)
    volume.size[static_cast<std::size_t>(axis)] =
        1 + static_cast<int>(std::lround((high - low)[axis] / scan.spacing_mm[axis]));
  volume.spacing_mm = scan.spacing_mm;
  volume.ct_from_grid.translation() = low;
  const Eigen::Isometry3d body_from_scanner = scan.scanner_from_body.inverse();
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x) {
        double sum = 0.0;
        for (int corner = 0; corner < 8; ++corner) {
          const Eigen::Vector3d inside(
              corner & 1 ? .25 : -.25, corner & 2 ? .25 : -.25, corner & 4 ? .25 : -.25);
          const Eigen::Vector3d place =
              volume.ct_from_grid *
              (Eigen::Vector3d(x, y, z) + inside).cwiseProduct(scan.spacing_mm);
          sum += body.hu_at(body_from_scanner * place, scan.table_mm);
        }
        volume.hu.push_back(static_cast<std::int16_t>(std::lround(sum / 8.0 + scan.hu_offset)));
      }
    }
  }
  return volume;
}

Eigen::Isometry3d moved(double angle_rad, const Eigen::Vector3d& axis, const Eigen::Vector3d& by) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  pose.translation() = by;
  return pose;
}

/// Farthest that a place of the body is put wrong.
double error_mm(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth) {
  double most = 0.0;
  for (const double z : {0.0, 120.0})
    for (const double x : {-90.0, 90.0}) {
      const Eigen::Vector3d in_second = truth.inverse() * Eigen::Vector3d(x, 0, z);
      most = std::max(most, (found * in_second - Eigen::Vector3d(x, 0, z)).norm());
    }
  return most;
}

TEST(JoinVolumes, GivesTheWholeBackVoxelForVoxel) {
  const Body body;
  const Volume whole = scanned(body, {});
  const Volume low = scanned(body, {.from_z_mm = -120, .to_z_mm = 30});
  const Volume high = scanned(body, {.from_z_mm = -30, .to_z_mm = 120});
  const auto joined = join_volumes(low, high, Eigen::Isometry3d::Identity(), {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(joined->size, whole.size);
  EXPECT_EQ(joined->hu, whole.hu);
  // The other way round: another first one, the same body.
  const auto swapped = join_volumes(high, low, Eigen::Isometry3d::Identity(), {}).value();
  EXPECT_EQ(swapped.hu, whole.hu);
  EXPECT_LT((swapped.ct_from_grid.translation() - whole.ct_from_grid.translation()).norm(), 1e-9);
}

TEST(JoinVolumes, TakesTheSharperOneWhereSlicesDiffer) {
  const Body body;
  const Volume fine = scanned(body, {.from_z_mm = -120, .to_z_mm = 30});
  const Volume thick =
      scanned(body, {.from_z_mm = -60, .to_z_mm = 120, .spacing_mm = {3.0, 3.0, 9.0}});
  const auto joined = join_volumes(thick, fine, Eigen::Isometry3d::Identity(), {}).value();
  EXPECT_NEAR(joined.spacing_mm.z(), 3.0, 1e-9);
  const Volume whole = scanned(body, {});
  std::size_t num_wrong = 0;
  for (int z = 0; z * 3.0 - 120.0 <= 18.0; ++z)
    for (int y = 0; y < whole.size[1]; ++y)
      for (int x = 0; x < whole.size[0]; ++x)
        if (joined.hu[joined.index(x, y, z)] != whole.hu[whole.index(x, y, z)]) ++num_wrong;
  EXPECT_EQ(num_wrong, 0U) << "up to 10 mm from its end the fine one is taken as it is";
}

TEST(JoinVolumes, DoesNotBridgeAGap) {
  const Body body;
  const auto refused = join_volumes(scanned(body, {.from_z_mm = -120, .to_z_mm = -30}),
                                    scanned(body, {.from_z_mm = 0, .to_z_mm = 60}),
                                    Eigen::Isometry3d::Identity(),
                                    {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("lie 30.0 mm apart"));
}

TEST(AlignVolumes, FindsAMovedAndTurnedBody) {
  const Body body;
  const Volume first = scanned(body, {.from_z_mm = -120, .to_z_mm = 60});
  const double kPi = 3.14159265358979;
  const struct {
    const char* what;
    Eigen::Isometry3d scanner_from_body;
  } cases[] = {
      {"shifted", moved(0.0, {0, 0, 1}, {6, -8, -150})},
      {"turned a little", moved(0.08, {1, 0.5, 2}, {5, 10, -130})},
      {"turned over", moved(kPi, {0, 0, 1}, {4, 3, -140})},
      {"feet first", moved(kPi, {0, 1, 0.02}, {-6, 5, 30})},
  };
  for (const auto& given : cases) {
    const Scan scan = {.from_z_mm = -180,
                       .to_z_mm = 60,
                       .spacing_mm = {2.5, 2.5, 4.0},
                       .table_mm = 66.0,
                       .hu_offset = 10.0,
                       .scanner_from_body = given.scanner_from_body};
    const auto aligned = align_volumes(first, scanned(body, scan), {});
    ASSERT_TRUE(aligned) << given.what << ": " << aligned.error().message;
    const auto& pose = aligned->first_from_second;
    EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-9) << "never mirrored";
    EXPECT_LT(error_mm(pose, given.scanner_from_body.inverse()), 1.0) << given.what;
    EXPECT_GT(aligned->quality.correlation, 0.9) << given.what;
    EXPECT_LT(aligned->quality.median_offset_mm, 1.0) << given.what;
    EXPECT_NEAR(aligned->quality.hu_difference, 10.0, 4.0) << given.what;
  }
}

TEST(AlignVolumes, RefusesAnotherBody) {
  const Volume first = scanned(Body(7), {.from_z_mm = -120, .to_z_mm = 60});
  const Volume other = scanned(Body(8), {.from_z_mm = -60, .to_z_mm = 120});
  const auto refused = align_volumes(first, other, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("do not fit together"));
  EXPECT_THAT(refused.error().message, HasSubstr("correlation"));
}

/// A mirrored body fits nowhere: nothing mirrors it back.
TEST(AlignVolumes, RefusesAMirroredBody) {
  const Body body;
  const Volume first = scanned(body, {.from_z_mm = -120, .to_z_mm = 60});
  Volume mirrored = scanned(body, {.from_z_mm = -60, .to_z_mm = 120});
  for (int z = 0; z < mirrored.size[2]; ++z)
    for (int y = 0; y < mirrored.size[1]; ++y)
      std::reverse(mirrored.hu.begin() + static_cast<std::ptrdiff_t>(mirrored.index(0, y, z)),
                   mirrored.hu.begin() + static_cast<std::ptrdiff_t>(mirrored.index(0, y, z)) +
                       mirrored.size[0]);
  EXPECT_FALSE(align_volumes(first, mirrored, {}));
}

class SeriesJoin : public ImportFolder {
 protected:
  /// Writes a scan as DICOM slices of a series.
  void write_series(const Volume& volume, const SliceText& head, const std::string& folder = {}) {
    for (int z = 0; z < volume.size[2]; ++z) {
      SliceText slice = head;
      slice.columns = volume.size[0];
      slice.rows = volume.size[1];
      slice.column_spacing_mm = volume.spacing_mm.x();
      slice.row_spacing_mm = volume.spacing_mm.y();
      slice.position_mm = volume.ct_from_grid * Eigen::Vector3d(0, 0, z * volume.spacing_mm.z());
      slice.sop_instance_uid =
          fmt::format("{}.{}", head.series_uid, 1000 * (head.acquisition_number - 1) + z + 1);
      for (std::size_t i = 0; i < volume.index(0, 0, 1); ++i)
        slice.stored.push_back(
            static_cast<std::uint16_t>(volume.hu[volume.index(0, 0, z) + i] + 1024));
      write(fmt::format("{}/{}", folder.empty() ? head.series_description : folder, z),
            slice_file(slice));
    }
  }

  std::string join_error(const ImportOptions& options) {
    const auto volume = import_volume(folder_, options, {});
    return volume ? "no error" : volume.error().message;
  }

  static SliceText named(const std::string& name, int number, const std::string& frame) {
    SliceText head;
    head.series_description = name;
    head.series_number = number;
    head.series_uid = fmt::format("1.2.3.{}", number);
    head.frame_of_reference_uid = frame;
    return head;
  }

  const Body body_;
};

TEST_F(SeriesJoin, OfOneFrameOfReferenceGoesByCoordinates) {
  write_series(scanned(body_, {.from_z_mm = -120, .to_z_mm = 30}), named("low", 1, "9.1"));
  write_series(scanned(body_, {.from_z_mm = -30, .to_z_mm = 120}), named("high", 2, "9.1"));
  const auto list = list_ct_series(folder_, {});
  ASSERT_TRUE(list) << list.error().message;
  EXPECT_EQ(list->at(1).frame_of_reference_uid, "9.1");
  const auto joined = import_volume(folder_, {.series = "1", .join = {"high"}}, {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(joined->hu, scanned(body_, {}).hu);
  EXPECT_THAT(joined->description, HasSubstr("joined with \"high\" by coordinates: "));
  EXPECT_THAT(join_error({.series = "1", .join = {"7"}}), HasSubstr("holds no series \"7\""));
}

/// Scanned at two table positions under one UID: where both are, they differ.
TEST_F(SeriesJoin, PartsOfOneSeriesAreToldByTheirNumber) {
  auto low = named("body", 1, "9.1");
  auto high = low;
  high.acquisition_number = 2;
  write_series(scanned(body_, {.from_z_mm = -120, .to_z_mm = 30}), low, "low");
  write_series(scanned(body_, {.from_z_mm = -30, .to_z_mm = 120, .hu_offset = 8.0}), high, "high");
  ASSERT_EQ(list_ct_series(folder_, {}).value().size(), 2U);
  const auto joined = import_volume(folder_, {.series = "1", .join = {"2"}}, {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(joined->size, scanned(body_, {}).size);
  EXPECT_THAT(join_error({.series = "1", .join = {"body"}}),
              HasSubstr("more than one series \"body\""));
  EXPECT_THAT(join_error({.series = "1", .join = {"1"}}), HasSubstr("named twice"));
}

TEST_F(SeriesJoin, OfOtherFramesIsDoneOnlyWhenTold) {
  const auto scanner_from_body = moved(0.05, {0, 0, 1}, {8, -5, 300});
  write_series(scanned(body_, {.from_z_mm = -120, .to_z_mm = 30}), named("low", 1, "9.1"));
  write_series(scanned(body_,
                       {.from_z_mm = 255,
                        .to_z_mm = 420,
                        .table_mm = 68.0,
                        .scanner_from_body = scanner_from_body}),
               named("high", 2, "9.2"));
  EXPECT_THAT(join_error({.series = "1", .join = {"2"}}),
              HasSubstr("different frames of reference"));
  const auto joined = import_volume(folder_, {.series = "1", .join = {"2"}, .align = true}, {});
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_THAT(joined->description, HasSubstr("by what both show"));
  const Volume whole = scanned(body_, {});
  double sum = 0.0;
  std::size_t n = 0;
  const Eigen::Isometry3d joined_from_whole = joined->ct_from_grid.inverse() * whole.ct_from_grid;
  for (int z = 0; z < whole.size[2] - 2; ++z) {
    for (int y = 15; y < 45; ++y) {
      for (int x = 20; x < 60; ++x) {
        const Eigen::Vector3d at = joined_from_whole * (3.0 * Eigen::Vector3d(x, y, z)) / 3.0;
        const Eigen::Vector3i i = at.array().round().cast<int>();
        sum += std::abs(joined->hu[joined->index(i.x(), i.y(), i.z())] -
                        whole.hu[whole.index(x, y, z)]);
        ++n;
      }
    }
  }
  EXPECT_LT(sum / static_cast<double>(n), 25.0) << "HU, with balls of 700 HU more";
}

TEST_F(SeriesJoin, IsRefusedWhereTheHuDoNotFit) {
  write_series(scanned(body_, {.from_z_mm = -120, .to_z_mm = 30}), named("low", 1, "9.1"));
  write_series(scanned(body_, {.from_z_mm = -30, .to_z_mm = 120, .hu_offset = 140}),
               named("high", 2, "9.1"));
  EXPECT_THAT(join_error({.series = "1", .join = {"2"}}), HasSubstr("soft tissue differs by 1"));
}

TEST_F(SeriesJoin, SaysWhatIsWrong) {
  const auto lower = [&](const SliceText& head) {
    write_series(scanned(body_, {.from_z_mm = -120, .to_z_mm = 30}), head);
  };
  lower(named("low", 1, "9.1"));
  write_series(scanned(body_, {.from_z_mm = -30, .to_z_mm = 120}), named("high", 2, "9.1"));
  write_series(scanned(body_, {.from_z_mm = 60, .to_z_mm = 120}), named("far", 3, "9.1"));
  EXPECT_THAT(join_error({.series = "1", .join = {"low"}}), HasSubstr("\"low\" is named twice"));
  EXPECT_THAT(join_error({.series = "1", .join = {"2", "2"}}), HasSubstr("\"2\" is named twice"));
  EXPECT_THAT(join_error({.series = "", .join = {"2"}}),
              HasSubstr("name the series of the 3 in " + folder_.string()));
  EXPECT_THAT(join_error({.series = "1", .join = {"far"}}),
              HasSubstr("lie 30.0 mm apart along the body, more than 4.5 mm are not bridged"));
  fs::resize_file(folder_ / "high" / "3", 900);
  EXPECT_THAT(join_error({.series = "1", .join = {"2"}}),
              HasSubstr("high/3 is cut short or damaged (at byte 364 of 740)"));
}

}  // namespace
}  // namespace mor
