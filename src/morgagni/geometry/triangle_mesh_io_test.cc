// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/triangle_mesh_io.h"

#include <fstream>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Ply : public testing::Test {
 protected:
  Ply() : path_(fs::temp_directory_path() / ("mor_ply_" + std::to_string(getpid()) + ".ply")) {}
  ~Ply() override { fs::remove(path_); }

  Result<TriangleMesh> read(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return read_ply(path_);
  }
  std::string error_of(const std::string& text) const {
    const auto mesh = read(text);
    return mesh ? "read" : mesh.error().message;
  }

  fs::path path_;
};

constexpr const char* kHead = "ply\nformat ascii 1.0\n";
constexpr const char* kXyz = "property float x\nproperty float y\nproperty double z\n";
constexpr const char* kFace = "property list uchar int vertex_indices\n";

std::string ascii(const std::string& vertices, const std::string& faces) {
  return std::string(kHead) + "element vertex 3\n" + kXyz + "element face 1\n" + kFace +
         "end_header\n" + vertices + faces;
}

TriangleMesh random_mesh(std::size_t num_vertices, std::size_t num_triangles) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> anywhere(-500.0F, 500.0F);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < num_vertices; ++i) {
    mesh.vertices.emplace_back(anywhere(random), anywhere(random), anywhere(random));
  }
  for (std::size_t i = 0; i < num_triangles; ++i) {
    Triangle triangle{};
    for (auto& corner : triangle) corner = static_cast<std::uint32_t>(random() % num_vertices);
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

TEST_F(Ply, GivesBackWhatWasWritten) {
  for (const bool has_normals : {false, true}) {
    auto mesh = random_mesh(1000, 2000);
    if (has_normals) mesh.normals = vertex_normals(mesh);
    ASSERT_TRUE(write_ply(path_, mesh));
    const auto read = read_ply(path_);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->vertices, mesh.vertices);
    EXPECT_EQ(read->normals, mesh.normals);
    EXPECT_EQ(read->triangles, mesh.triangles);
  }
}

TEST_F(Ply, GivesBackAnEmptyMesh) {
  ASSERT_TRUE(write_ply(path_, {}));
  const auto read = read_ply(path_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->empty());
}

TEST_F(Ply, ReadsAsciiWithOtherPropertiesElementsAndFacesFirst) {
  const auto mesh = read(
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement face 1\r\nproperty uchar flag\r\n"
      "property list uint8 int32 vertex_index\r\nelement edge 2\r\nproperty list uchar int loop\r\n"
      "element vertex 3\r\nproperty uchar red\r\nproperty float x\r\nproperty float y\r\n"
      "property float z\r\nend_header\r\n9 3 0 1 2\r\n2 5 6\r\n0\r\n255 0 0 1e1\r\n1 1 0 0\r\n2 0 "
      "-2.5 0");
  ASSERT_TRUE(mesh) << mesh.error().message;
  ASSERT_EQ(mesh->vertices.size(), 3U);
  EXPECT_EQ(mesh->vertices[0], Eigen::Vector3f(0, 0, 10));
  EXPECT_EQ(mesh->vertices[2], Eigen::Vector3f(0, -2.5F, 0));
  EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST_F(Ply, SaysWhatIsWrongAndNamesTheFile) {
  const std::string corners = "0 0 0 1 0 0 0 1 0 ";
  EXPECT_THAT(error_of(""), HasSubstr("not a PLY file"));
  EXPECT_THAT(error_of("solid cube\nfacet\n"), HasSubstr("not a PLY file"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex 1\n"), HasSubstr("does not end"));
  EXPECT_THAT(error_of("ply\nend_header\n"), HasSubstr("no format"));
  EXPECT_THAT(error_of("ply\nformat binary_big_endian 1.0\nend_header\n"), HasSubstr("big_endian"));
  EXPECT_THAT(error_of(std::string(kHead) + "property float x\n"), HasSubstr("before any element"));
  EXPECT_THAT(error_of(std::string(kHead) + "element vertex 1\nproperty quad x\n"),
              HasSubstr("'quad'"));
  EXPECT_THAT(error_of(std::string(kHead) + "element face 1\nproperty list float int a\n"),
              HasSubstr("no whole number"));
  EXPECT_THAT(error_of(std::string(kHead) + "element vertex -1\n"), HasSubstr("'-1'"));
  EXPECT_THAT(error_of(std::string(kHead) + "element vertex 1\nproperty float x\nend_header\n1 "),
              HasSubstr("no x, y, z"));
  EXPECT_THAT(error_of(ascii(corners, "3 0 1 3")), HasSubstr("names vertex 3 of 3"));
  EXPECT_THAT(error_of(ascii(corners, "3 0 1 -1")), HasSubstr("index -1"));
  EXPECT_THAT(error_of(ascii(corners, "3 0 1 1.5")), HasSubstr("index 1.5"));
  EXPECT_THAT(error_of(ascii(corners, "4 0 1 2 0")), HasSubstr("4 corners, not 3"));
  EXPECT_THAT(error_of(ascii(corners, "3 0 1 two")), HasSubstr("is no number"));
  EXPECT_THAT(error_of(ascii("0 0 0 1 0 0 0 nan 0 ", "3 0 1 2")), HasSubstr("vertex 2 has a y"));
  EXPECT_THAT(error_of(ascii("0 0 0 1 0 0 0 0 1e300 ", "3 0 1 2")), HasSubstr("vertex 2 has a z"));
  EXPECT_THAT(error_of(ascii(corners, "3 0 1 3")), HasSubstr(path_.string()));
}

TEST_F(Ply, RefusesCountsThatTheFileCannotHoldBeforeItAllocates) {
  for (const std::string count : {"100", "4294967294", "4294967295", "99999999999999999999"}) {
    for (const std::string format : {"ascii", "binary_little_endian"}) {
      const auto error = error_of("ply\nformat " + format + " 1.0\nelement vertex " + count + "\n" +
                                  kXyz + "end_header\n0 0 0\n");
      EXPECT_THAT(error, testing::AnyOf(HasSubstr("too short"), HasSubstr("the limit is")));
    }
  }
  EXPECT_THAT(error_of(std::string(kHead) + "element nothing 4000000000\nend_header\n"),
              HasSubstr("too short"));
}

TEST_F(Ply, CutAnywhereIsAnErrorAndNeverACrash) {
  auto mesh = random_mesh(20, 20);
  mesh.normals = vertex_normals(mesh);
  ASSERT_TRUE(write_ply(path_, mesh));
  const auto whole = read_text_file(path_, 1U << 20U).value();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(read(whole.substr(0, size))) << size;
  }
}

TEST_F(Ply, AnyByteFlippedIsReadOrRefusedButNeverACrash) {
  ASSERT_TRUE(write_ply(path_, random_mesh(20, 20)));
  const auto whole = read_text_file(path_, 1U << 20U).value();
  std::mt19937 random(3);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto damaged = whole;
    damaged[i] = static_cast<char>(random());
    const auto mesh = read(damaged);
    if (!mesh) continue;
    for (const auto& triangle : mesh->triangles) {
      for (const auto corner : triangle) ASSERT_LT(corner, mesh->vertices.size());
    }
  }
}

TEST_F(Ply, SaysThatAFileIsMissing) {
  const auto mesh = read_ply("/nowhere/skin.ply");
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace mor
