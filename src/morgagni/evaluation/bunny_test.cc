// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// The one pair of a real CT and a real range sensor that is public: the terracotta Stanford bunny
// (Stanford 3D Scanning Repository; CT by Yoo, Rubin, Napel and Levoy). Its ten Cyberware scans,
// each on its own, must find their place in the CT.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/ct/surfaces.h"
#include "morgagni/ct/volume_import.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/registration/fine_registration.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr double kMmPerM = 1000.0;
constexpr int kNumStarts = 10;
constexpr double kStartMm = 20.0;
constexpr double kStartRad = 15.0 * std::numbers::pi / 180.0;
constexpr double kMaxMeanMm = 0.5;
/// Where the virtual camera looks from: the scanner's rays are parallel, ours meet far away.
constexpr float kCameraMm = 700.0F;

fs::path bunny() {
  return fs::path(MORGAGNI_DATA_DIR) / "bunny";
}

std::string next_line(std::ifstream& file) {
  std::string line;
  std::getline(file, line);
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

/// Vertices of an ASCII PLY in mm, and the lists that follow them.
struct Ply {
  std::vector<Eigen::Vector3f> vertices;
  int num_columns = 0;
  std::vector<int> grid;  ///< Of a range scan, row by row: a vertex, or -1.
};

Ply read_ply(const fs::path& path) {
  std::ifstream file(path);
  Ply ply;
  std::size_t num_vertices = 0;
  std::size_t num_grid = 0;
  for (std::string line = next_line(file); file && line != "end_header"; line = next_line(file)) {
    std::sscanf(line.c_str(), "element vertex %zu", &num_vertices);
    std::sscanf(line.c_str(), "element range_grid %zu", &num_grid);
    std::sscanf(line.c_str(), "obj_info num_cols %d", &ply.num_columns);
  }
  for (std::size_t i = 0; i < num_vertices; ++i) {
    Eigen::Vector3d p;
    std::istringstream(next_line(file)) >> p.x() >> p.y() >> p.z();
    ply.vertices.push_back((kMmPerM * p).cast<float>());
  }
  for (std::size_t i = 0; i < num_grid; ++i) {
    int count = 0;
    int vertex = -1;
    std::istringstream(next_line(file)) >> count >> vertex;
    ply.grid.push_back(count > 0 ? vertex : -1);
  }
  return ply;
}

/// A scan as a camera in front of it would see it; the scanner looks along -z.
struct RangeScan {
  PointCloud cloud;
  Eigen::Isometry3d scan_from_depth = Eigen::Isometry3d::Identity();
};

/// Triangulates the scan's grid over gaps of less than 3 mm for normals, and thins it.
RangeScan read_scan(const fs::path& path, std::size_t stride) {
  const Ply ply = read_ply(path);
  TriangleMesh mesh;
  mesh.vertices = ply.vertices;
  const auto add = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    Triangle t = {static_cast<std::uint32_t>(a),
                  static_cast<std::uint32_t>(b),
                  static_cast<std::uint32_t>(c)};
    const auto& v = mesh.vertices;
    if ((v[t[0]] - v[t[1]]).norm() > 3.0F || (v[t[1]] - v[t[2]]).norm() > 3.0F ||
        (v[t[2]] - v[t[0]]).norm() > 3.0F) {
      return;
    }
    if ((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).z() < 0.0F) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  };
  const int rows = static_cast<int>(ply.grid.size()) / ply.num_columns;
  for (int y = 0; y + 1 < rows; ++y) {
    for (int x = 0; x + 1 < ply.num_columns; ++x) {
      const auto i = static_cast<std::size_t>(y * ply.num_columns + x);
      const auto below = i + static_cast<std::size_t>(ply.num_columns);
      add(ply.grid[i], ply.grid[i + 1], ply.grid[below]);
      add(ply.grid[i + 1], ply.grid[below + 1], ply.grid[below]);
    }
  }
  mesh.normals = vertex_normals(mesh);
  const Eigen::Vector3f center = mesh.bounds().center();
  RangeScan scan;
  scan.scan_from_depth.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  scan.scan_from_depth.translation() =
      (center + kCameraMm * Eigen::Vector3f::UnitZ()).cast<double>();
  const Eigen::Isometry3f depth_from_scan = scan.scan_from_depth.inverse().cast<float>();
  std::vector<bool> has_normal(mesh.vertices.size(), false);
  for (const auto& triangle : mesh.triangles) {
    for (const auto corner : triangle) has_normal[corner] = true;
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); i += stride) {
    if (!has_normal[i]) continue;
    scan.cloud.points.push_back(depth_from_scan * mesh.vertices[i]);
    scan.cloud.normals.push_back(depth_from_scan.linear() * mesh.normals[i]);
  }
  return scan;
}

/// `bun.conf`: where each scan lies in the zippered mesh; its quaternions turn the other way.
Eigen::Isometry3d zipper_from_scan(const std::string& line, std::string& name) {
  std::istringstream in(line);
  std::string word;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  in >> word >> name >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = q.normalized().toRotationMatrix().transpose();
  pose.translation() = kMmPerM * t;
  return pose;
}

Eigen::Isometry3d read_ct_from_zipper() {
  std::ifstream file(bunny() / "T_ct_from_zipper_mm.txt");
  next_line(file);
  Eigen::Matrix4d ras = Eigen::Matrix4d::Identity();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) file >> ras(r, c);
  }
  Eigen::Isometry3d pose;
  pose.matrix() = Eigen::Vector4d(-1.0, -1.0, 1.0, 1.0).asDiagonal() * ras;
  return pose;
}

std::shared_ptr<const FixedSurface> skin_of_ct() {
  const auto quiet = [](std::string_view, double) {};
  const auto volume = import_volume(bunny() / "bunny_ct_half.nii.gz", {}, quiet);
  if (!volume) return nullptr;
  // Terracotta is at 1200 HU: its surface lies half way from air.
  const auto skin = extract_skin(*volume, {.threshold_hu = 100.0, .closing_mm = 1.0}, quiet);
  if (!skin) return nullptr;
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = skin->remeshed;
  surface->field = *DistanceField::build(surface->mesh);
  return surface;
}

double mean_displacement_mm(const Eigen::Isometry3d& found,
                            const Eigen::Isometry3d& truth,
                            const std::vector<Eigen::Vector3f>& zipper,
                            const Eigen::Isometry3d& scan_from_zipper) {
  double sum_mm = 0.0;
  for (const auto& vertex : zipper) {
    const Eigen::Vector3d p = scan_from_zipper * vertex.cast<double>();
    sum_mm += (found * p - truth * p).norm();
  }
  return sum_mm / static_cast<double>(zipper.size());
}

TEST(StanfordBunny, EveryRangeScanFindsItsPlaceInTheCt) {
  if (!fs::exists(bunny())) GTEST_SKIP() << bunny() << " is not there";
  const fs::path scans = fs::temp_directory_path() / fmt::format("morgagni_bunny_{}", ::getpid());
  fs::create_directories(scans);
  const std::string unpack = fmt::format(
      "tar xJf '{}' -C '{}'", (bunny() / "bunny_range_scans.tar.xz").string(), scans.string());
  ASSERT_EQ(std::system(unpack.c_str()), 0);
  const auto surface = skin_of_ct();
  ASSERT_TRUE(surface);
  const auto registration = *make_fine_registration(surface, {});
  const Eigen::Isometry3d ct_from_zipper = read_ct_from_zipper();
  const Ply zipper = read_ply(bunny() / "bun_zipper_res2.ply");
  std::ifstream conf(scans / "bun.conf");
  int num_scans = 0;
  for (std::string line = next_line(conf); conf; line = next_line(conf)) {
    if (!line.starts_with("bmesh")) continue;
    std::string name;
    const Eigen::Isometry3d zipper_from = zipper_from_scan(line, name);
    const RangeScan scan = read_scan(scans / name, 4);
    ASSERT_GT(scan.cloud.size(), 500U) << name;
    const Eigen::Isometry3d truth = ct_from_zipper * zipper_from * scan.scan_from_depth;
    const Eigen::Isometry3d depth_from_zipper = (zipper_from * scan.scan_from_depth).inverse();
    const Eigen::Vector3d center = truth * Eigen::Vector3d(0.0, 0.0, kCameraMm);
    std::mt19937_64 random(1000 + static_cast<std::uint64_t>(num_scans++));
    double worst_mm = 0.0;
    for (int i = 0; i < kNumStarts; ++i) {
      const auto start = perturbed_start(truth, center, kStartMm, kStartRad, random);
      const auto result = registration->align(scan.cloud, start, StartQuality::kRough);
      ASSERT_TRUE(result) << result.error().message;
      worst_mm =
          std::max(worst_mm,
                   mean_displacement_mm(
                       result->fixed_from_moving, truth, zipper.vertices, depth_from_zipper));
    }
    fmt::print("{:<14}{:>7} points, worst of {} starts {:.3f} mm\n",
               name,
               scan.cloud.size(),
               kNumStarts,
               worst_mm);
    EXPECT_LT(worst_mm, kMaxMeanMm) << name;
  }
  EXPECT_EQ(num_scans, 10);
  fs::remove_all(scans);
}

}  // namespace
}  // namespace mor
