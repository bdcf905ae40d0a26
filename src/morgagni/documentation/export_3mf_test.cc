// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <filesystem>

#include <Model/COM/NMR_DLLInterfaces.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/documentation/export_formats.h"
#include "morgagni/documentation/testing/tube_body.h"

// Read back by lib3mf, the 3MF consortium's own reader.

namespace mor {
namespace {

namespace fs = std::filesystem;
namespace lib = NMR;
using namespace testing_body;  // NOLINT

constexpr float kMostMm = 0.01F;
constexpr std::uint32_t kTypeModel = 1;
constexpr std::uint32_t kTypeSurface = 4;

struct ReadObject {
  std::string name;
  std::uint32_t type = 0;
  bool is_manifold = false;
  TriangleMesh mesh;
  lib::PLib3MFPropertyHandler* properties = nullptr;
};

std::string name_of(lib::PLib3MFModelResource* object) {
  std::array<char, 256> text{};
  ::ULONG length = 0;
  lib::lib3mf_object_getnameutf8(object, text.data(), text.size(), &length);
  return text.data();
}

class Exported3mf : public ::testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / ("morgagni-3mf-" + std::to_string(getpid()));
  lib::PLib3MFModel* model_ = nullptr;

  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override {
    if (model_ != nullptr) lib::lib3mf_release(model_);
    fs::remove_all(folder_);
  }

  std::vector<ReadObject> read(const Result<std::string>& bytes) {
    EXPECT_TRUE(bytes.has_value());
    EXPECT_TRUE(write_file(folder_ / "body.3mf", *bytes).has_value());
    lib::PLib3MFModelReader* reader = nullptr;
    EXPECT_EQ(lib::lib3mf_createmodel(&model_), 0);
    EXPECT_EQ(lib::lib3mf_model_queryreader(model_, "3mf", &reader), 0);
    EXPECT_EQ(lib::lib3mf_reader_readfromfileutf8(reader, (folder_ / "body.3mf").string().c_str()),
              0);
    ::DWORD warnings = 0;
    lib::lib3mf_reader_getwarningcount(reader, &warnings);
    EXPECT_EQ(warnings, 0U);
    lib::lib3mf_release(reader);
    ::DWORD unit = 0;
    lib::lib3mf_model_getunit(model_, &unit);
    EXPECT_EQ(unit, lib::MODELUNIT_MILLIMETER);
    return objects();
  }

 private:
  std::vector<ReadObject> objects() {
    std::vector<ReadObject> result;
    lib::PLib3MFModelResourceIterator* iterator = nullptr;
    lib::lib3mf_model_getmeshobjects(model_, &iterator);
    for (::BOOL has_next = 0;
         lib::lib3mf_resourceiterator_movenext(iterator, &has_next) == 0 && has_next != 0;) {
      lib::PLib3MFModelResource* resource = nullptr;
      lib::lib3mf_resourceiterator_getcurrent(iterator, &resource);
      result.push_back(object(resource));
    }
    return result;
  }

  static ReadObject object(lib::PLib3MFModelResource* resource) {
    ReadObject read;
    read.name = name_of(resource);
    lib::lib3mf_object_gettype(resource, &read.type);
    ::BOOL is_manifold = 0;
    lib::lib3mf_meshobject_ismanifoldandoriented(resource, &is_manifold);
    read.is_manifold = is_manifold != 0;
    ::DWORD count = 0;
    lib::lib3mf_meshobject_getvertexcount(resource, &count);
    for (::DWORD i = 0; i < count; ++i) {
      lib::MODELMESHVERTEX v;
      lib::lib3mf_meshobject_getvertex(resource, i, &v);
      read.mesh.vertices.emplace_back(v.m_fPosition[0], v.m_fPosition[1], v.m_fPosition[2]);
    }
    lib::lib3mf_meshobject_gettrianglecount(resource, &count);
    for (::DWORD i = 0; i < count; ++i) {
      lib::MODELMESHTRIANGLE t;
      lib::lib3mf_meshobject_gettriangle(resource, i, &t);
      read.mesh.triangles.push_back({t.m_nIndices[0], t.m_nIndices[1], t.m_nIndices[2]});
    }
    lib::lib3mf_meshobject_createpropertyhandler(resource, &read.properties);
    return read;
  }
};

void expect_same_places(const TriangleMesh& read, const TriangleMesh& expected) {
  ASSERT_EQ(read.vertices.size(), expected.vertices.size());
  for (std::size_t i = 0; i < read.vertices.size(); ++i)
    ASSERT_LT((read.vertices[i] - expected.vertices[i]).norm(), kMostMm);
  ASSERT_EQ(read.triangles, expected.triangles);
}

TEST_F(Exported3mf, SkinIsAClosedSolidWithItsPicture) {
  const auto model = tube_model();
  const auto solid = make_printable(model.skin_mesh, {});
  ASSERT_TRUE(solid.has_value());
  const auto objects = read(encode_skin_3mf(model, *solid, {"a <case>", "2026-11-26"}));
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].type, kTypeModel);
  EXPECT_TRUE(objects[0].is_manifold);
  expect_same_places(objects[0].mesh, solid->mesh);

  ::DWORD texture_id = 0;
  for (std::size_t t = 0; t < solid->num_skin_triangles; ++t) {
    lib::MODELMESHTEXTURE2D places;
    ASSERT_EQ(lib::lib3mf_propertyhandler_gettexture(
                  objects[0].properties, static_cast<::DWORD>(t), &places),
              0);
    texture_id = places.m_nTextureID;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto share =
          picture_share(model.skin.picture_px[model.skin.mesh.triangles[t][k]], model.picture);
      ASSERT_NEAR(places.m_fU[k], share.x(), 1e-5F);
      ASSERT_NEAR(places.m_fV[k], 1.0F - share.y(), 1e-5F);
    }
  }
  lib::PLib3MFModelTexture2D* texture = nullptr;
  lib::PLib3MFModelAttachment* attachment = nullptr;
  ASSERT_EQ(lib::lib3mf_model_gettexture2dbyid(model_, texture_id, &texture), 0);
  ASSERT_EQ(lib::lib3mf_texture2d_getattachment(texture, &attachment), 0);
  ASSERT_EQ(
      lib::lib3mf_attachment_writetofileutf8(attachment, (folder_ / "skin.png").string().c_str()),
      0);
  const auto picture = read_png_rgb(folder_ / "skin.png");
  ASSERT_TRUE(picture.has_value());
  EXPECT_EQ(*picture, model.picture);
}

TEST_F(Exported3mf, ShellOfAPlainSkinIsManifoldToo) {
  const auto model = make_export_model(tube_skin(), nullptr, {});
  const auto solid = make_printable(model->skin_mesh, {PrintForm::kShell, 3.0});
  ASSERT_TRUE(solid.has_value());
  const auto objects = read(encode_skin_3mf(*model, *solid, {"shell", ""}));
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_TRUE(objects[0].is_manifold);
  expect_same_places(objects[0].mesh, solid->mesh);
}

TEST_F(Exported3mf, StructuresHaveTheirColorsAndOpenOnesAreNoSolids) {
  auto model = tube_model();
  model.structures[1].mesh.triangles.pop_back();
  const auto objects = read(encode_structures_3mf(model, {"structures", ""}));
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].type, kTypeModel);
  EXPECT_EQ(objects[1].type, kTypeSurface);
  EXPECT_EQ(objects[1].name, "left kidney");
  for (std::size_t i = 0; i < 2; ++i) {
    expect_same_places(objects[i].mesh, model.structures[i].mesh);
    ::DWORD group = 0;
    ::DWORD index = 0;
    ASSERT_EQ(lib::lib3mf_propertyhandler_getbasematerial(objects[i].properties, 0, &group, &index),
              0);
    lib::PLib3MFModelBaseMaterial* material = nullptr;
    ASSERT_EQ(lib::lib3mf_model_getbasematerialbyid(model_, group, &material), 0);
    ::BYTE r = 0, g = 0, b = 0, a = 0;
    ASSERT_EQ(lib::lib3mf_basematerial_getdisplaycolor(material, index, &r, &g, &b, &a), 0);
    EXPECT_EQ((Rgb8{r, g, b}), model.structures[i].color);
  }
}

}  // namespace
}  // namespace mor
