// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/export_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/documentation/testing/tube_body.h"

namespace mor {
namespace {

using namespace testing_body;  // NOLINT
using ::testing::HasSubstr;

TEST(ExportModel, SplitsVerticesOnlyAtTheSeam) {
  const auto texture = tube_texture();
  const auto model = make_export_model(texture.atlas->mesh, &texture, {});
  ASSERT_TRUE(model.has_value());
  EXPECT_EQ(model->skin.mesh.vertices.size(), texture.atlas->mesh.vertices.size() + kUp);
  for (std::size_t t = 0; t < texture.atlas->mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = model->skin.mesh.triangles[t][k];
      EXPECT_EQ(model->skin.mesh.vertices[corner],
                texture.atlas->mesh.vertices[texture.atlas->mesh.triangles[t][k]]);
      EXPECT_EQ(model->skin.picture_px[corner], texture.atlas->corners_px[t][k]);
    }
  }
}

TEST(ExportModel, MarksWhatWasNeverSeenAndKeepsWhatWas) {
  const auto model = tube_model();
  EXPECT_EQ(model.picture(200, 100), tube_color(200, 100));
  EXPECT_EQ(model.picture(200, 190), kNeverSeenColor);
  EXPECT_NEAR(model.seen_share, 0.8, 0.01);
  // Colours go on beyond the patch's rim.
  EXPECT_NEAR(model.picture(200, 6).r, tube_color(200, 10).r, 2);
  EXPECT_NEAR(model.picture(200, 6).g, tube_color(200, 10).g, 2);
  EXPECT_EQ(model.picture(0, 0), kNeverSeenColor);
}

TEST(ExportModel, IsPlainWithoutTexture) {
  const auto model = make_export_model(tube_skin(), nullptr, {});
  ASSERT_TRUE(model.has_value());
  EXPECT_TRUE(model->picture.empty());
  EXPECT_TRUE(model->skin.picture_px.empty());
  EXPECT_EQ(model->skin.color, kPlainSkinColor);
}

TEST(ExportModel, RefusesAPictureThatIsNotTheAtlass) {
  auto texture = tube_texture();
  texture.color = Image<Rgb8>(10, 10);
  const auto model = make_export_model(texture.atlas->mesh, &texture, {});
  ASSERT_FALSE(model.has_value());
  EXPECT_THAT(model.error().message, HasSubstr("picture is 10x10 px, its atlas 520x210 px"));
  EXPECT_FALSE(make_export_model({}, nullptr, {}).has_value());
}

TEST(ExportModel, SubdividesWithoutMovingTheSurface) {
  const auto model = tube_model();
  const auto fine = subdivided(model.skin, 2);
  EXPECT_EQ(fine.mesh.triangles.size(), model.skin.mesh.triangles.size() * 16);
  EXPECT_NEAR(surface_area_mm2(fine.mesh), surface_area_mm2(model.skin.mesh), 1.0);
  EXPECT_EQ(fine.mesh.vertices.size(), fine.picture_px.size());
}

TEST(SamplePicture, MixesFourTexelsAndStaysInside) {
  Image<Rgb8> picture(2, 2);
  picture(1, 0) = {100, 0, 0};
  picture(1, 1) = {100, 200, 0};
  EXPECT_EQ(sample_picture(picture, {0.5F, 0.5F}), (Rgb8{50, 50, 0}));
  EXPECT_EQ(sample_picture(picture, {5.0F, 5.0F}), (Rgb8{100, 200, 0}));
}

}  // namespace
}  // namespace mor
