// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/documents.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "morgagni/core/files.h"
#include "morgagni/documentation/body_picture.h"
#include "morgagni/documentation/testing/tube_body.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const Progress kQuiet = [](std::string_view, double) {};

class MadeDocuments : public ::testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / ("morgagni-documents-" + std::to_string(getpid()));
  DocumentSource source_;
  DocumentOptions options_;

  void SetUp() override {
    fs::create_directories(folder_);
    source_.case_name = "tube";
    source_.skin = testing_body::tube_skin();
    source_.texture = testing_body::tube_texture();
    source_.structures = {testing_body::ball("left/../kidney", {1, 2, 3}, {20, -30, 100}),
                          testing_body::ball("skin", {1, 2, 3}, {20, -30, 160})};
    options_.formats = {DocumentFormat::kGlb, DocumentFormat::kStl, DocumentFormat::kPdf};
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::vector<std::string> names_in(const fs::path& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(MadeDocuments, HaveSafeNamesAndTheirHashesInTheManifest) {
  const auto made = make_documents(source_, folder_ / "out", options_, kQuiet, {});
  ASSERT_TRUE(made.has_value()) << made.error().message;
  EXPECT_THAT(names_in(folder_ / "out"),
              ::testing::ElementsAre("left_kidney.stl",
                                     "manifest.json",
                                     "model.glb",
                                     "report.pdf",
                                     "skin-2.stl",
                                     "skin-print.stl",
                                     "skin.stl"));
  const auto text = read_text_file(folder_ / "out" / kManifestFile, 1U << 20U);
  ASSERT_TRUE(text.has_value());
  const auto manifest = nlohmann::json::parse(*text);
  EXPECT_EQ(manifest["files"].size(), 6U);
  for (const auto& file : manifest["files"]) {
    EXPECT_EQ(file["sha256"],
              *sha256_hex_of_file(folder_ / "out" / file["name"].get<std::string>()));
  }
  EXPECT_EQ(manifest["print"]["open_ends"], 2);
  EXPECT_NEAR(manifest["texture"]["seen_share"].get<double>(), 0.8, 0.01);
  EXPECT_THAT(made->remarks, ::testing::Contains(HasSubstr("open in 2 places")));
}

TEST_F(MadeDocuments, ReplaceOlderOnesAndNothingElse) {
  ASSERT_TRUE(make_documents(source_, folder_ / "out", options_, kQuiet, {}).has_value());
  options_.formats = {DocumentFormat::kGlb};
  ASSERT_TRUE(make_documents(source_, folder_ / "out", options_, kQuiet, {}).has_value());
  EXPECT_THAT(names_in(folder_ / "out"), ::testing::ElementsAre("manifest.json", "model.glb"));
  fs::create_directories(folder_ / "mine");
  ASSERT_TRUE(write_file(folder_ / "mine" / "holiday.jpg", "x"));
  const auto refused = make_documents(source_, folder_ / "mine", options_, kQuiet, {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("exists and holds no documents"));
  EXPECT_THAT(names_in(folder_ / "mine"), ::testing::ElementsAre("holiday.jpg"));
}

TEST_F(MadeDocuments, LeaveNothingWhenStopped) {
  std::stop_source stop;
  const auto made = make_documents(
      source_,
      folder_ / "out",
      options_,
      [&](std::string_view stage, double) {
        if (stage == "STL") stop.request_stop();
      },
      stop.get_token());
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(MadeDocuments, SayWhenTheSkinCannotBePrinted) {
  source_.texture.reset();
  source_.skin.triangles.push_back(source_.skin.triangles.front());
  const auto made = make_documents(source_, folder_ / "out", options_, kQuiet, {});
  ASSERT_TRUE(made.has_value());
  EXPECT_THAT(made->remarks, ::testing::Contains(HasSubstr("Nothing to print was made")));
  EXPECT_THAT(made->remarks, ::testing::Contains(HasSubstr("no fused texture")));
  EXPECT_FALSE(fs::exists(folder_ / "out" / "skin-print.stl"));
}

TEST(BodyPicture, HasEachSideWhereItsLettersSay) {
  const auto model = testing_body::tube_model();
  const Eigen::Vector3d front(20.0, -90.0, 140.0);
  const Eigen::Vector3d left(105.0, -30.0, 140.0);
  const auto anterior = draw_body(model, BodyView::kAnterior, 200, 300);
  EXPECT_EQ(anterior.letters, (std::array<std::string_view, 4>{"R", "L", "H", "F"}));
  EXPECT_GT(anterior.place_px(left).x(), anterior.place_px(front).x());
  EXPECT_TRUE(anterior.is_visible(front));
  EXPECT_FALSE(draw_body(model, BodyView::kPosterior, 200, 300).is_visible(front));
  const auto side = draw_body(model, BodyView::kLeft, 200, 300);
  EXPECT_LT(side.place_px(front).x(), side.place_px(left).x());  // The front is on the left: "A".
  EXPECT_TRUE(side.is_visible(left));
  EXPECT_EQ(side.mm_per_px, anterior.mm_per_px);
}

TEST(BodyPicture, ShowsThePicturesColorsAtTheirPlaces) {
  const auto model = testing_body::tube_model();
  const auto view = draw_body(model, BodyView::kAnterior, 400, 600);
  // A corner of a triangle in front, whose place in the picture is known: the colour's hue is kept.
  for (std::size_t i = 0; i < model.skin.mesh.vertices.size(); ++i) {
    const auto& normal = model.skin.mesh.normals[i];
    const bool is_at_the_end = model.skin.mesh.vertices[i].z() < 45.0F;  // Mixed with the white.
    if (normal.y() > -0.98F || is_at_the_end) continue;
    const auto expected = sample_picture(model.picture, model.skin.picture_px[i]);
    const auto at = view.place_px(model.skin.mesh.vertices[i].cast<double>());
    const auto seen =
        view.picture(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    if (expected == kNeverSeenColor) continue;
    EXPECT_NEAR(seen.g, expected.g, 12) << i;
    EXPECT_NEAR(seen.b, expected.b, 12) << i;
  }
  EXPECT_EQ(view.picture(2, 2), (Rgb8{255, 255, 255}));
}

}  // namespace
}  // namespace mor
