// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/export_formats.h"

#include <cmath>
#include <filesystem>
#include <functional>

#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/documentation/testing/tube_body.h"

// Each file is read back by assimp, which knows nothing of our writers.

namespace mor {
namespace {

namespace fs = std::filesystem;
using namespace testing_body;  // NOLINT
using ::testing::HasSubstr;

constexpr float kMostMm = 0.01F;
const ExportTitle kTitle{"case 7 <&\"> \xC3\xA4", "2026-11-26T16:20:05Z"};

class ExportedFile : public ::testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / ("morgagni-export-" + std::to_string(getpid()));
  ExportModel model_ = tube_model();
  Assimp::Importer importer_;

  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  const aiScene* read(const std::string& name, const std::string& bytes) {
    EXPECT_TRUE(write_file(folder_ / name, bytes).has_value());
    const aiScene* scene = importer_.ReadFile((folder_ / name).string(), 0);
    EXPECT_NE(scene, nullptr) << importer_.GetErrorString();
    return scene;
  }

  const ExportSurface& surface(std::size_t i) const {
    return i == 0 ? model_.skin : model_.structures[i - 1];
  }

  /// Corner by corner: the place, and of the skin its place in the picture.
  void expect_same(const aiMesh& mesh,
                   const ExportSurface& expected,
                   const std::function<Eigen::Vector3f(const aiVector3D&)>& ct_from_file) {
    ASSERT_EQ(mesh.mNumFaces, expected.mesh.triangles.size());
    for (unsigned t = 0; t < mesh.mNumFaces; ++t) {
      ASSERT_EQ(mesh.mFaces[t].mNumIndices, 3U);
      for (unsigned k = 0; k < 3; ++k) {
        const unsigned corner = mesh.mFaces[t].mIndices[k];
        const auto vertex = expected.mesh.triangles[t][k];
        const Eigen::Vector3f place = ct_from_file(mesh.mVertices[corner]);
        ASSERT_LT((place - expected.mesh.vertices[vertex]).norm(), kMostMm);
        if (expected.picture_px.empty()) continue;
        const auto share = picture_share(expected.picture_px[vertex], model_.picture);
        ASSERT_TRUE(mesh.HasTextureCoords(0));
        // assimp counts a picture's rows from below.
        ASSERT_NEAR(mesh.mTextureCoords[0][corner].x, share.x(), 1e-5F);
        ASSERT_NEAR(1.0F - mesh.mTextureCoords[0][corner].y, share.y(), 1e-5F);
      }
    }
  }

  static Eigen::Vector3f as_is(const aiVector3D& v) { return {v.x, v.y, v.z}; }
};

aiColor4D color_of(const aiMaterial& material) {
  aiColor4D color;
  if (material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS)
    EXPECT_EQ(material.Get(AI_MATKEY_COLOR_DIFFUSE, color), aiReturn_SUCCESS);
  return color;
}

float srgb(float linear) {
  return linear <= 0.0031308F ? linear * 12.92F : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
}

TEST_F(ExportedFile, GlbIsTheModelInMetresWithYUp) {
  const aiScene* scene = read("body.glb", encode_glb(model_, kTitle));
  ASSERT_NE(scene, nullptr);
  ASSERT_EQ(scene->mNumMeshes, 3U);
  for (unsigned i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    expect_same(*scene->mMeshes[i], surface(i), [](const aiVector3D& v) -> Eigen::Vector3f {
      return Eigen::Vector3f(v.x, -v.z, v.y) * 1000.0F;  // Back to LPS, mm.
    });
  }
  EXPECT_EQ(std::string(scene->mMeshes[2]->mName.C_Str()), "left kidney");
  const aiColor4D bone = color_of(*scene->mMaterials[scene->mMeshes[1]->mMaterialIndex]);
  EXPECT_NEAR(srgb(bone.r) * 255.0F, 237.0F, 0.5F);
  EXPECT_NEAR(srgb(bone.g) * 255.0F, 227.0F, 0.5F);
  EXPECT_NEAR(srgb(bone.b) * 255.0F, 199.0F, 0.5F);
  ASSERT_EQ(scene->mNumTextures, 1U);
  const auto* png = reinterpret_cast<const std::byte*>(scene->mTextures[0]->pcData);
  ASSERT_TRUE(write_file(folder_ / "skin.png", std::span(png, scene->mTextures[0]->mWidth)));
  const auto picture = read_png_rgb(folder_ / "skin.png");
  ASSERT_TRUE(picture.has_value());
  EXPECT_EQ(*picture, model_.picture);
}

TEST_F(ExportedFile, ObjIsTheModelWithItsMaterialsAndPicture) {
  ASSERT_TRUE(write_file(folder_ / "body.mtl", encode_mtl(model_, "skin.png")));
  const aiScene* scene = read("body.obj", encode_obj(model_, kTitle, "body.mtl"));
  ASSERT_NE(scene, nullptr);
  ASSERT_EQ(scene->mNumMeshes, 3U);
  for (unsigned i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    expect_same(*scene->mMeshes[i], surface(i), as_is);
  }
  aiString picture;
  const auto& skin = *scene->mMaterials[scene->mMeshes[0]->mMaterialIndex];
  ASSERT_EQ(skin.GetTexture(aiTextureType_DIFFUSE, 0, &picture), aiReturn_SUCCESS);
  EXPECT_STREQ(picture.C_Str(), "skin.png");
  aiColor4D kidney;
  scene->mMaterials[scene->mMeshes[2]->mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, kidney);
  EXPECT_NEAR(kidney.r * 255.0F, 180.0F, 0.5F);
  EXPECT_NEAR(kidney.b * 255.0F, 60.0F, 0.5F);
}

TEST_F(ExportedFile, PlyHasThePicturesColorAtEachVertex) {
  const aiScene* scene = read("skin.ply", encode_colored_ply(model_.skin, model_.picture, kTitle));
  ASSERT_NE(scene, nullptr);
  const aiMesh& mesh = *scene->mMeshes[0];
  ASSERT_TRUE(mesh.HasVertexColors(0));
  EXPECT_GT(mesh.mNumFaces, 30U * model_.skin.mesh.triangles.size());
  const auto expected = subdivided(model_.skin, 3);
  ASSERT_EQ(mesh.mNumFaces, expected.mesh.triangles.size());
  for (unsigned t = 0; t < mesh.mNumFaces; ++t) {
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned corner = mesh.mFaces[t].mIndices[k];
      const auto vertex = expected.mesh.triangles[t][k];
      ASSERT_LT((as_is(mesh.mVertices[corner]) - expected.mesh.vertices[vertex]).norm(), kMostMm);
      const Rgb8 color = sample_picture(model_.picture, expected.picture_px[vertex]);
      ASSERT_NEAR(mesh.mColors[0][corner].r * 255.0F, color.r, 0.6F);
      ASSERT_NEAR(mesh.mColors[0][corner].g * 255.0F, color.g, 0.6F);
      ASSERT_NEAR(mesh.mColors[0][corner].b * 255.0F, color.b, 0.6F);
    }
  }
}

TEST_F(ExportedFile, PlyOfAStructureIsAsItIsInItsColor) {
  const auto& bone = model_.structures[0];
  const aiScene* scene = read("bone.ply", encode_colored_ply(bone, model_.picture, kTitle));
  ASSERT_NE(scene, nullptr);
  expect_same(*scene->mMeshes[0], bone, as_is);
  EXPECT_NEAR(scene->mMeshes[0]->mColors[0][0].g * 255.0F, 227.0F, 0.5F);
}

TEST_F(ExportedFile, StlIsTheSkinInMillimetres) {
  const auto bytes = encode_stl(model_.skin.mesh, {"solid case", ""});
  EXPECT_EQ(bytes.size(), 84 + 50 * model_.skin.mesh.triangles.size());
  EXPECT_FALSE(bytes.starts_with("solid"));
  const aiScene* scene = read("skin.stl", bytes);
  ASSERT_NE(scene, nullptr);
  ExportSurface plain = model_.skin;
  plain.picture_px.clear();
  expect_same(*scene->mMeshes[0], plain, as_is);
}

TEST_F(ExportedFile, PlainModelNeedsNoPicture) {
  model_ = *make_export_model(tube_skin(), nullptr, {});
  const aiScene* scene = read("plain.glb", encode_glb(model_, kTitle));
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->mNumTextures, 0U);
  const aiColor4D skin = color_of(*scene->mMaterials[scene->mMeshes[0]->mMaterialIndex]);
  EXPECT_NEAR(srgb(skin.r) * 255.0F, kPlainSkinColor.r, 0.5F);
  EXPECT_THAT(encode_mtl(model_, "skin.png"), ::testing::Not(HasSubstr("map_Kd")));
}

TEST_F(ExportedFile, NamesCannotBreakOutOfTheirLine) {
  model_.structures[0].name = "bone\nv 0 0 0 # x";
  const auto obj = encode_obj(model_, {"a\nf 1 2 3", ""}, "body.mtl");
  EXPECT_THAT(obj, HasSubstr("o bone_v_0_0_0___x\n"));
  EXPECT_THAT(obj, HasSubstr("# a f 1 2 3\n"));
}

}  // namespace
}  // namespace mor
