// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// The whole of preparation on real CTs, against the figures that issue and BENCHMARK.md promise.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/components.h"
#include "morgagni/ct/internal/dual_mesh.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/triangle_grid.h"
#include "morgagni/ct/internal/uncovering.h"
#include "morgagni/ct/internal/volume_sample.h"
#include "morgagni/ct/join_volumes.h"
#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_alignment.h"
#include "morgagni/ct/volume_import.h"
#include "morgagni/geometry/kd_tree.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/geometry/triangle_mesh_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

fs::path data(const std::string& name) {
  return fs::path(MORGAGNI_DATA_DIR) / name;
}

/// An archive of the data folder, unpacked for the length of a test.
class Unpacked {
 public:
  explicit Unpacked(const std::string& name)
      : folder_(fs::temp_directory_path() / ("morgagni_real_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    const std::string command =
        "tar xJf '" + data(name).string() + "' -C '" + folder_.string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
  }
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;
  ~Unpacked() { fs::remove_all(folder_); }
  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

/// The same body with a slice between every two: 138 slices become 275.
Volume with_twice_the_slices(const Volume& volume) {
  Volume result = volume;
  result.size[2] = 2 * volume.size[2] - 1;
  result.spacing_mm.z() /= 2.0;
  result.hu.clear();
  const std::size_t slice = volume.index(0, 0, 1);
  for (int z = 0; z < result.size[2]; ++z) {
    const std::int16_t* low = volume.hu.data() + static_cast<std::size_t>(z / 2) * slice;
    const std::int16_t* high = low + (z % 2) * slice;
    for (std::size_t i = 0; i < slice; ++i)
      result.hu.push_back(static_cast<std::int16_t>((low[i] + high[i]) / 2));
  }
  return result;
}

void expect_promised_quality(const SkinSurfaces& skin) {
  const auto topology = mesh_topology(skin.remeshed);
  EXPECT_GE(skin.remeshed.vertices.size(), 19500U);
  EXPECT_LE(skin.remeshed.vertices.size(), 20500U);
  EXPECT_EQ(topology.num_non_manifold_edges, 0);
  EXPECT_TRUE(
      internal::non_manifold_vertices(skin.remeshed.triangles, skin.remeshed.vertices.size())
          .empty());
  EXPECT_EQ(topology.num_degenerate, 0);
  EXPECT_EQ(topology.num_folded_edges, 0);
  EXPECT_GE(topology.valence_5_to_7, 0.90);
  constexpr int kNumPoints = 200000;
  const auto to_full = surface_distance(skin.remeshed, skin.full, kNumPoints);
  const auto from_full = surface_distance(skin.full, skin.remeshed, kNumPoints);
  EXPECT_LE(to_full.mean_mm, 0.25);
  EXPECT_LE(to_full.p99_mm, 1.2);
  EXPECT_LE(from_full.mean_mm, 0.25);
  EXPECT_LE(from_full.p99_mm, 1.2);
}

/// A step along the normal leads out of the body: the HU falls.
void expect_normals_outwards(const Volume& volume, const TriangleMesh& mesh) {
  const auto hu_at = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d voxel =
        (volume.ct_from_grid.inverse() * place).cwiseQuotient(volume.spacing_mm);
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      at[i] = std::clamp(static_cast<int>(std::lround(voxel[axis])), 0, volume.size[i] - 1);
    }
    return volume.hu[volume.index(at[0], at[1], at[2])];
  };
  std::size_t num_outwards = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d place = mesh.vertices[i].cast<double>();
    const Eigen::Vector3d step = 3.0 * mesh.normals[i].cast<double>();
    if (hu_at(place - step) > hu_at(place + step)) ++num_outwards;
  }
  EXPECT_GT(static_cast<double>(num_outwards), 0.93 * static_cast<double>(mesh.vertices.size()));
}

TEST(RealCt, FullSizeChestMeetsThePromisedFigures) {
  const std::string archive = "ct_chest_lidc0314/lidc0314_138x2mm_dicom.tar.xz";
  if (!fs::exists(data(archive))) GTEST_SKIP() << "no " << archive;
  const Unpacked chest(archive);
  const auto read = import_volume(chest.folder(), {}, {});
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->size, (std::array{512, 512, 138}));
  const auto volume = with_twice_the_slices(*read);
  const auto skin = extract_skin(volume, {}, {});
  ASSERT_TRUE(skin) << skin.error().message;
  expect_promised_quality(*skin);
  expect_normals_outwards(volume, skin->remeshed);
  // The table reaches 50 mm farther back, folds of cloth 10 to 30 mm in front of the skin.
  const auto bounds = skin->full.bounds();
  EXPECT_LT(bounds.max().y(), 296.0F) << "the table is not the chest";
  EXPECT_GT(bounds.min().y(), -12.0F) << "nor is the cloth on it";
  double behind_ml = 0.0;
  for (const auto& part : skin->preview.cut)
    if (part.place == "behind") behind_ml += part.volume_ml;
  EXPECT_GT(behind_ml, 700.0) << "the table";
  const auto bone = extract_bone(skin->body, {}, {});
  ASSERT_TRUE(bone);
  EXPECT_GT(bone->triangles.size(), 30000U);
  EXPECT_LE(bone->triangles.size(), 40500U);
}

TEST(RealCt, HeadMeetsThePromisedFigures) {
  const auto file = data("ct_head_invesalius/promed_ct_0051.nii.gz");
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const auto volume = import_volume(file, {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  const auto skin = extract_skin(*volume, {}, {});
  ASSERT_TRUE(skin) << skin.error().message;
  expect_promised_quality(*skin);
  expect_normals_outwards(*volume, skin->remeshed);
  EXPECT_LT(skin->full.bounds().sizes().y(), 240.0F) << "the headrest is not the head";
}

TEST(RealCt, BunnyIsNotMirrored) {
  if (!fs::exists(data("bunny/bunny_ct_half.nii.gz"))) GTEST_SKIP() << "no bunny";
  const auto volume = import_volume(data("bunny/bunny_ct_half.nii.gz"), {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_NEAR(volume->ct_from_grid.linear().determinant(), 1.0, 1e-6);
  auto mesh = read_ply(data("bunny/bun_zipper_res2.ply"));
  ASSERT_TRUE(mesh) << mesh.error().message;
  std::ifstream file(data("bunny/T_ct_from_zipper_mm.txt"));
  std::string comment;
  std::getline(file, comment);
  Eigen::Matrix4d ras_from_zipper;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) file >> ras_from_zipper(row, column);
  ASSERT_TRUE(file);
  constexpr double kClayHu = 0.0;
  const auto clay = internal::threshold(*volume, kClayHu, 32767.0);
  const auto surface = internal::marching_cubes(*volume, clay, kClayHu);
  const internal::TriangleGrid grid(surface);
  std::vector<double> distances;
  for (const auto& vertex : mesh->vertices) {
    const Eigen::Vector4d zipper_mm = (1000.0 * vertex.cast<double>()).homogeneous();
    const Eigen::Vector3d ras = (ras_from_zipper * zipper_mm).head<3>();
    const Eigen::Vector3d lps(-ras.x(), -ras.y(), ras.z());
    distances.push_back(grid.distance_mm(lps.cast<float>()));
  }
  std::sort(distances.begin(), distances.end());
  std::cout << "bunny: the scanned mesh lies " << distances[distances.size() / 2]
            << " mm (median), " << distances[distances.size() * 95 / 100]
            << " mm (95 %) from the CT's surface\n";
  EXPECT_LT(distances[distances.size() / 2], 1.0);
  EXPECT_LT(distances[distances.size() * 95 / 100], 2.0) << "30 mm when mirrored";
}

/// The head's CT with a shell of 3 mm pressed 2 mm into one ear, as headrests are.
Volume with_shell_at_an_ear(const Volume& head, const internal::BitMask& body) {
  constexpr double kPressedMm = 2.0;
  constexpr double kShellMm = 3.0;
  constexpr std::int16_t kShellHu = 100;
  const internal::Components parts(body);
  const auto& box = parts.parts()[parts.largest()];
  const auto steps = [&](double mm) {
    return static_cast<int>(std::lround(mm / head.spacing_mm.x()));
  };
  const int first_x = box.high_x - steps(kPressedMm) + 1;
  Volume pressed = head;
  for (int z = 0; z < head.size[2]; ++z)
    for (int y = box.low_y + 40; y <= box.high_y; ++y)
      for (int x = first_x; x < std::min(first_x + steps(kShellMm), head.size[0]); ++x)
        pressed.hu[head.index(x, y, z)] = std::max(kShellHu, head.hu[head.index(x, y, z)]);
  return pressed;
}

TEST(RealCt, AnEarAgainstAHeadrestStaysAndTheHeadrestGoes) {
  const auto head = import_volume(data("ct_head_invesalius/promed_ct_0051.nii.gz"), {}, {});
  if (!head) GTEST_SKIP() << head.error().message;
  const auto free = internal::body_mask(*head, internal::bare_ct(*head), {}, {}).value();
  const Volume pressed = with_shell_at_an_ear(*head, free.body);
  const auto found = internal::body_mask(pressed, internal::bare_ct(pressed), {}, {});
  ASSERT_TRUE(found) << found.error().message;
  constexpr double kThresholdHu = -300.0;
  const auto truth = internal::marching_cubes(*head, free.body, kThresholdHu);
  const auto skin = internal::marching_cubes(pressed, found->body, kThresholdHu);
  // The side of the shell, beyond the cheek: elsewhere the two are the same.
  const auto side = static_cast<float>(head->ct_from_grid.linear()(0, 0) > 0.0 ? 1.0 : -1.0);
  const auto bounds = truth.bounds();
  const float beyond = side * (side > 0.0F ? bounds.max().x() : bounds.min().x()) - 30.0F;
  const auto distances_at_ear = [&](const TriangleMesh& from, const TriangleMesh& to) {
    const internal::TriangleGrid grid(to);
    std::vector<double> distances;
    for (const auto& vertex : from.vertices)
      if (side * vertex.x() > beyond) distances.push_back(grid.distance_mm(vertex));
    std::sort(distances.begin(), distances.end());
    return distances;
  };
  const auto lost = distances_at_ear(truth, skin);
  const auto gained = distances_at_ear(skin, truth);
  ASSERT_GT(lost.size(), 5000U);
  ASSERT_GT(gained.size(), 5000U);
  const auto at = [](const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  std::cout << "ear against a shell: skin lost p95 " << at(lost, 0.95) << " p99 " << at(lost, 0.99)
            << " max " << lost.back() << " mm; gained p95 " << at(gained, 0.95) << " p99 "
            << at(gained, 0.99) << " max " << gained.back() << " mm\n";
  EXPECT_LE(at(lost, 0.95), 1.0);
  EXPECT_LE(at(gained, 0.95), 1.0);
  EXPECT_LE(lost.back(), 3.0);
  EXPECT_LE(gained.back(), 3.0);
}

/// The upper chest as another scan would give it: turned and shifted, thicker slices, a softer
/// kernel, the table 10 mm lower, its own grid.
Volume scanned_again(const Volume& chest,
                     const internal::BitMask& body,
                     int first_slice,
                     const Eigen::Isometry3d& scanner_from_chest) {
  Volume scan;
  scan.spacing_mm = {0.9, 0.9, 3.0};
  const Eigen::Vector3d corner_mm(10.0, 10.0, first_slice * chest.spacing_mm.z());
  const Eigen::Isometry3d grid_from_chest = chest.ct_from_grid.inverse();
  scan.ct_from_grid.translation() = scanner_from_chest * (chest.ct_from_grid * corner_mm);
  scan.size = {
      420, 420, static_cast<int>((chest.size[2] - 1 - first_slice) * chest.spacing_mm.z() / 3.0)};
  const Eigen::Isometry3d chest_from_scanner = scanner_from_chest.inverse();
  const auto is_in = [&](const Eigen::Vector3d& chest_grid_mm) {
    const Eigen::Vector3i voxel =
        chest_grid_mm.cwiseQuotient(chest.spacing_mm).array().round().cast<int>();
    return voxel.minCoeff() >= 0 && voxel.x() < chest.size[0] && voxel.y() < chest.size[1] &&
           voxel.z() < chest.size[2] && body.test(voxel.x(), voxel.y(), voxel.z());
  };
  for (int z = 0; z < scan.size[2]; ++z) {
    for (int y = 0; y < scan.size[1]; ++y) {
      for (int x = 0; x < scan.size[0]; ++x) {
        const Eigen::Vector3d mm = Eigen::Vector3d(x, y, z).cwiseProduct(scan.spacing_mm);
        const Eigen::Vector3d at =
            grid_from_chest * (chest_from_scanner * (scan.ct_from_grid * mm));
        const bool is_body = is_in(at);
        // Beside the body lies what lay 10 mm above: table and air, but no second skin.
        const Eigen::Vector3d from = is_body ? at : Eigen::Vector3d(at - Eigen::Vector3d(0, 10, 0));
        double sum = 0.0;
        for (const double dx : {-0.6, 0.6}) {
          for (const double dy : {-0.6, 0.6}) {
            const Eigen::Vector3d place = from + Eigen::Vector3d(dx, dy, 0.0);
            const bool is_seen = is_body || !is_in(place);
            sum += is_seen ? internal::sampled_hu(chest, place).value_or(-1000.0) : -1000.0;
          }
        }
        scan.hu.push_back(static_cast<std::int16_t>(std::lround(sum / 4.0)));
      }
    }
  }
  return scan;
}

/// Cut in two that overlap, the upper half changed as a second scan changes it, joined by what both
/// show: where the upper half lies and its skin, against the CT in one piece.
TEST(RealCt, AChestInTwoSeriesIsJoinedAgain) {
  const std::string archive = "ct_chest_lidc0314/lidc0314_138x2mm_dicom.tar.xz";
  if (!fs::exists(data(archive))) GTEST_SKIP() << "no " << archive;
  const Unpacked folder(archive);
  const Volume chest = import_volume(folder.folder(), {}, {}).value();
  const auto body = internal::body_mask(chest, internal::bare_ct(chest), {}, {}).value().body;
  Volume lower = chest;
  lower.size[2] = 85;
  lower.hu.resize(chest.index(0, 0, 85));
  Eigen::Isometry3d scanner_from_chest = Eigen::Isometry3d::Identity();
  scanner_from_chest.linear() =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.2, 0.1, 1.0).normalized()).toRotationMatrix();
  scanner_from_chest.translation() = Eigen::Vector3d(15.0, -20.0, 600.0);
  const Volume upper = scanned_again(chest, body, 60, scanner_from_chest);
  const auto aligned = align_volumes(lower, upper, {});
  ASSERT_TRUE(aligned) << aligned.error().message;
  const auto& quality = aligned->quality;
  double worst_mm = 0.0;
  for (const int z : {60, 137}) {
    for (const int x : {100, 400}) {
      const Eigen::Vector3d place =
          chest.ct_from_grid * Eigen::Vector3d(x, 250, z).cwiseProduct(chest.spacing_mm);
      worst_mm = std::max(
          worst_mm, (aligned->first_from_second * (scanner_from_chest * place) - place).norm());
    }
  }
  const Volume joined = join_volumes(lower, upper, aligned->first_from_second, {}).value();
  const auto joined_body =
      internal::body_mask(joined, internal::bare_ct(joined), {}, {}).value().body;
  const auto truth = internal::marching_cubes(chest, body, -300.0);
  const auto skin = internal::marching_cubes(joined, joined_body, -300.0);
  const internal::TriangleGrid grid(truth);
  // Only where the upper half alone shows it, and not at its cut ends and sides.
  const double from_z = (chest.ct_from_grid * Eigen::Vector3d(0, 0, 90 * 2.0)).z();
  const double to_z = (chest.ct_from_grid * Eigen::Vector3d(0, 0, 125 * 2.0)).z();
  std::vector<double> distances;
  for (std::size_t i = 0; i < skin.vertices.size(); i += 41) {
    const auto& place = skin.vertices[i];
    if (place.z() > from_z && place.z() < to_z && std::abs(place.x()) < 150.0F)
      distances.push_back(grid.distance_mm(place));
  }
  ASSERT_GT(distances.size(), 1000U);
  std::sort(distances.begin(), distances.end());
  std::cout << "joined chest: " << quality.overlap_mm << " mm in common, correlation "
            << quality.correlation << ", pieces off by " << quality.median_offset_mm << " / "
            << quality.p90_offset_mm << " mm, HU " << quality.hu_difference
            << "; upper half put wrong by " << worst_mm << " mm at most; skin off by "
            << distances[distances.size() / 2] << " mm in the middle, "
            << distances[distances.size() * 95 / 100] << " mm at 95 %\n";
  EXPECT_LT(worst_mm, 1.0);
  EXPECT_LT(quality.median_offset_mm, 0.7);
  EXPECT_LT(distances[distances.size() / 2], 0.5);
  EXPECT_LT(distances[distances.size() * 95 / 100], 1.5);
}

TEST(RealCt, TiltedHeadComesOutUpright) {
  const std::string archive = "ct_head_tilt_ge/ge_head_tilt18_dicom.tar.xz";
  if (!fs::exists(data(archive))) GTEST_SKIP() << "no " << archive;
  const Unpacked head(archive);
  const auto volume = import_volume(head.folder(), {}, {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_NEAR(volume->spacing_mm.z(), 1.08, 0.01) << "the smallest of 4.0, 7.0 and 1.08 mm";
  EXPECT_GT(volume->size[1], 512) << "room for the shear";
  const Eigen::Vector3d down = volume->ct_from_grid.linear().col(1);
  EXPECT_NEAR(std::atan2(std::abs(down.z()), down.y()) * 180.0 / std::numbers::pi, 18.5, 0.1);
  const auto skin = extract_skin(*volume, {}, {});
  ASSERT_TRUE(skin) << skin.error().message;
  // A pad of the headrest at each ear, 25 mm and more.
  EXPECT_LT(skin->full.bounds().sizes().x(), 195.0F) << "the headrest is not the head";
  ASSERT_GE(skin->preview.cut.size(), 2U);
  for (const std::size_t side : {0U, 1U}) EXPECT_GT(skin->preview.cut[side].volume_ml, 30.0);
}

/// The phantom's plastic shell, from one scan.
TriangleMesh shell_of(const std::string& archive) {
  const Unpacked folder(archive);
  const auto volume = import_volume(folder.folder(), {}, {});
  EXPECT_TRUE(volume) << volume.error().message;
  constexpr double kPlasticHu = 0.0;
  const auto plastic = internal::threshold(*volume, kPlasticHu, 32767.0);
  return internal::marching_cubes(*volume, plastic, kPlasticHu);
}

/// ICP with the nearest vertices of a dense surface; the closest three quarters count.
Eigen::Isometry3d aligned(const std::vector<Eigen::Vector3f>& fixed,
                          const std::vector<Eigen::Vector3d>& moving) {
  const KdTree tree(fixed);
  Eigen::Isometry3d fixed_from_moving = Eigen::Isometry3d::Identity();
  for (int round = 0; round < 30; ++round) {
    std::vector<std::pair<float, std::size_t>> order;
    std::vector<Eigen::Vector3d> partners;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const auto near = tree.nearest((fixed_from_moving * moving[i]).cast<float>());
      order.emplace_back(near.distance_sq_mm2, i);
      partners.push_back(fixed[near.index].cast<double>());
    }
    std::sort(order.begin(), order.end());
    std::vector<Eigen::Vector3d> a;
    std::vector<Eigen::Vector3d> b;
    for (std::size_t k = 0; k < order.size() * 3 / 4; ++k) {
      a.push_back(partners[order[k].second]);
      b.push_back(moving[order[k].second]);
    }
    fixed_from_moving = fit_rigid(a, b).value();
  }
  return fixed_from_moving;
}

/// One rigid phantom, scanned with the gantry tilted and upright. A shear left in would not fit.
TEST(RealCt, TiltedPhantomHasTheShapeOfTheUntilted) {
  const std::string tilted_archive = "phantom_skull_philips/skull_tilt_p16_dicom.tar.xz";
  if (!fs::exists(data(tilted_archive))) GTEST_SKIP() << "no " << tilted_archive;
  const auto tilted = shell_of(tilted_archive);
  const auto upright = shell_of("phantom_skull_philips/skull_untilted_5mm_dicom.tar.xz");
  constexpr std::size_t kStep = 250;
  std::vector<Eigen::Vector3d> moving;
  for (std::size_t i = 0; i < upright.vertices.size(); i += kStep)
    moving.push_back(upright.vertices[i].cast<double>());
  const auto tilted_from_upright = aligned(tilted.vertices, moving);
  const internal::TriangleGrid grid(tilted);
  std::vector<double> distances;
  for (const auto& place : moving)
    distances.push_back(grid.distance_mm((tilted_from_upright * place).cast<float>()));
  std::sort(distances.begin(), distances.end());
  EXPECT_LE(distances[distances.size() / 2], 0.5);
  std::cout << "median " << distances[distances.size() / 2] << " mm, p75 "
            << distances[distances.size() * 3 / 4] << " mm\n";
}

}  // namespace
}  // namespace mor
