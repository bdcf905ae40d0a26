// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/structure_mesh.h"

#include <cstring>
#include <random>

#include <gmock/gmock.h>

#include "morgagni/ct/mesh_quality.h"
#include "morgagni/ct/test_volumes.h"
#include "morgagni/ct/testing/import_folder.h"
#include "morgagni/geometry/testing/box_mesh.h"

namespace mor {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A box from (10, 20, 30) to (14, 26, 38), 192 mm^3.
TriangleMesh box() {
  return testing_mesh::make_box({10.0F, 20.0F, 30.0F}, {14.0F, 26.0F, 38.0F});
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string binary_stl(const TriangleMesh& mesh, const std::string& head = "made") {
  std::string bytes = head;
  bytes.resize(80, ' ');
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    append(bytes, Eigen::Vector3f(0, 0, 0));
    for (const auto corner : triangle) append(bytes, mesh.vertices[corner]);
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string place_of(const Eigen::Vector3f& v) {
  return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
}

std::string ascii_stl(const TriangleMesh& mesh) {
  std::string text = "solid made\n";
  for (const auto& triangle : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto corner : triangle) text += "vertex " + place_of(mesh.vertices[corner]);
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid made\n";
}

std::string obj(const TriangleMesh& mesh, const std::string& comment = "# made\n") {
  std::string text = comment;
  for (const auto& vertex : mesh.vertices) text += "v " + place_of(vertex);
  for (const auto& [a, b, c] : mesh.triangles)
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
            std::to_string(c + 1) + "\n";
  return text;
}

std::string ascii_ply(const TriangleMesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                     std::to_string(mesh.vertices.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& vertex : mesh.vertices) text += place_of(vertex);
  for (const auto& [a, b, c] : mesh.triangles)
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  return text;
}

class StructureMesh : public ImportFolder {
 protected:
  std::string refusal(const std::string& name, const std::string& bytes) {
    const auto mesh = import_structure_mesh(write(name, bytes), {}, {});
    return mesh ? "no error" : mesh.error().message;
  }
};

void expect_box(const Result<StructureSurface>& surface, const Eigen::Vector3f& low) {
  ASSERT_TRUE(surface) << surface.error().message;
  const auto& mesh = surface->mesh;
  EXPECT_EQ(mesh.vertices.size(), 8U) << "corners are joined";
  EXPECT_EQ(mesh.normals.size(), 8U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_EQ(mesh_topology(mesh).num_open_edges, 0);
  EXPECT_NEAR(enclosed_volume_mm3(mesh), 192.0, 1e-3) << "and not inside out";
  EXPECT_LT((mesh.bounds().min() - low).norm(), 1e-5F);
}

TEST_F(StructureMesh, ReadsEachFormat) {
  const Eigen::Vector3f low(10, 20, 30);
  const auto read = [&](const std::string& name, const std::string& bytes) {
    SCOPED_TRACE(name);
    expect_box(import_structure_mesh(write(name, bytes), {}, {}), low);
  };
  read("binary.stl", binary_stl(box()));
  read("text.STL", ascii_stl(box()));
  read("knife.obj", obj(box()));
  read("text.ply", ascii_ply(box()));
  EXPECT_EQ(import_structure_mesh(folder_ / "knife.obj", {}, {})->name, "knife");
}

TEST_F(StructureMesh, TurnsRasToLps) {
  const Eigen::Vector3f turned(-14, -26, 30);
  const auto plain = write("plain.stl", binary_stl(box()));
  expect_box(import_structure_mesh(plain, {.frame = MeshFrame::kRas}, {}), turned);
  const auto slicer = write("slicer.stl", binary_stl(box(), "3D Slicer output. SPACE=RAS"));
  expect_box(import_structure_mesh(slicer, {}, {}), turned);
  const auto says_lps = write("lps.obj", obj(box(), "# 3D Slicer output. SPACE=LPS\n"));
  expect_box(import_structure_mesh(says_lps, {.frame = MeshFrame::kRas}, {}), {10, 20, 30});
}

TEST_F(StructureMesh, RefusesBadFilesWithASentence) {
  EXPECT_THAT(refusal("empty.stl", ""),
              HasSubstr("empty.stl is damaged or not what its name says: it gives no surface"));
  EXPECT_THAT(refusal("garbage.stl", "just some text"), HasSubstr("damaged or not what its name"));
  EXPECT_THAT(refusal("cut.stl", binary_stl(box()).substr(0, 300)), HasSubstr("damaged"));
  EXPECT_THAT(refusal("points.obj", "v 1 2 3\nv 2 3 4\n"),
              HasSubstr("points.obj is damaged or not what its name says: it gives no surface"));
  EXPECT_THAT(refusal("far.obj", "v 1 2 3\nf 1 2 999999999\n"),
              HasSubstr("far.obj is damaged or not what its name says: it gives no surface"));
  EXPECT_THAT(refusal("lying.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n1 2 3\n"),
              HasSubstr("lying.ply: the file is too short for the 4000000000 of 'vertex'"));
  EXPECT_THAT(refusal("nan.obj", "v nan 2 3\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
              HasSubstr("nan.obj has a vertex whose place is not a finite number (vertex 0)"));
  EXPECT_THAT(refusal("scene.glb", "glTF"), HasSubstr("give an .stl, .obj, .ply or .vtp file"));
  const auto gone = import_structure_mesh(folder_ / "gone.stl", {}, {});
  ASSERT_FALSE(gone);
  EXPECT_THAT(gone.error().message, HasSubstr("there is no file"));
}

TEST_F(StructureMesh, SurvivesMutants) {
  std::mt19937 random(1);
  const std::vector<std::pair<std::string, std::string>> sound = {
      {"m.stl", binary_stl(box())}, {"m.obj", obj(box())}, {"m.ply", ascii_ply(box())}};
  for (int round = 0; round < 60; ++round) {
    for (const auto& [name, bytes] : sound) {
      std::string mutant = bytes;
      for (int change = 0; change < 4; ++change)
        mutant[random() % mutant.size()] = static_cast<char>(random());
      if (round % 3 == 0) mutant.resize(random() % mutant.size());
      const auto mesh = import_structure_mesh(write(name, mutant), {}, {});
      if (mesh) continue;
      EXPECT_THAT(mesh.error().message, AllOf(Not(HasSubstr("\n")), HasSubstr("."))) << round;
    }
  }
}

}  // namespace
}  // namespace mor
