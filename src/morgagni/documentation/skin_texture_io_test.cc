// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/skin_texture_io.h"

#include <csignal>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Two triangles, two frames, one texel never seen.
SkinTexture small_texture() {
  auto atlas = std::make_shared<SkinAtlas>();
  atlas->mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {10, 10, 0.3F}};
  atlas->mesh.normals.assign(4, Eigen::Vector3f::UnitZ());
  atlas->mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  atlas->corners_px = {{Eigen::Vector2f(0.1F, 0), Eigen::Vector2f(9, 0), Eigen::Vector2f(0, 9)},
                       {Eigen::Vector2f(1, 9), Eigen::Vector2f(10, 0), Eigen::Vector2f(10, 9)}};
  atlas->width_px = 12;
  atlas->height_px = 10;
  atlas->px_per_mm = 0.9;
  SkinTexture texture;
  texture.color = Image<Rgb8>(12, 10, {200, 150, 130});
  texture.color(3, 4) = {1, 2, 3};
  texture.sources = Image<TexelSource>(12, 10);
  texture.sources(3, 4) = {1, 0.7854F, 612.3F, 0.815F};
  texture.frames.resize(2);
  texture.frames[0] = {41, 1'700'000'000'123, Eigen::Isometry3d::Identity(), 1.25};
  texture.frames[1].frame_id = 42;
  texture.frames[1].ct_from_color =
      Eigen::Translation3d(1.0 / 3.0, -2, 700) *
      Eigen::AngleAxisd(std::numbers::pi / 7.0, Eigen::Vector3d(1, 2, 3).normalized());
  texture.atlas = atlas;
  return texture;
}

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / "skin_texture_io" / name;
  fs::remove_all(folder);
  return folder;
}

fs::path written_folder(const std::string& name) {
  auto folder = fresh_folder(name);
  EXPECT_TRUE(write_skin_texture(folder, small_texture()).has_value());
  return folder;
}

/// Changes text in texture.json.
void replace_in_index(const fs::path& folder, const std::string& old, const std::string& now) {
  auto text = read_text_file(folder / "texture.json", 1U << 20U).value();
  const auto at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  text.replace(at, old.size(), now);
  ASSERT_TRUE(write_file(folder / "texture.json", text).has_value());
}

std::string refusal(const fs::path& folder) {
  const auto texture = read_skin_texture(folder);
  return texture ? "was read" : texture.error().message;
}

TEST(SkinTextureIo, ComesBackAsItWasWritten) {
  const auto folder = written_folder("round_trip");
  const auto expected = small_texture();
  const auto texture = read_skin_texture(folder);
  ASSERT_TRUE(texture.has_value()) << texture.error().message;
  EXPECT_EQ(texture->color, expected.color);
  EXPECT_EQ(texture->atlas->mesh.vertices, expected.atlas->mesh.vertices);
  EXPECT_EQ(texture->atlas->mesh.normals, expected.atlas->mesh.normals);
  EXPECT_EQ(texture->atlas->mesh.triangles, expected.atlas->mesh.triangles);
  EXPECT_EQ(texture->atlas->corners_px, expected.atlas->corners_px);
  EXPECT_EQ(texture->atlas->px_per_mm, 0.9);
  ASSERT_EQ(texture->frames.size(), 2U);
  EXPECT_EQ(texture->frames[0].captured_unix_ms, 1'700'000'000'123);
  EXPECT_EQ(texture->frames[0].bound_mm, 1.25);
  EXPECT_EQ(texture->frames[1].bound_mm, std::nullopt);
  EXPECT_EQ(texture->frames[1].ct_from_color.matrix(), expected.frames[1].ct_from_color.matrix());
  const auto& source = texture->sources(3, 4);
  EXPECT_EQ(source.frame, 1U);
  EXPECT_NEAR(source.angle_rad, 0.7854F, 0.5e-4F);
  EXPECT_NEAR(source.distance_mm, 612.3F, 0.05F);
  EXPECT_NEAR(source.px_per_mm, 0.815F, 0.5e-3F);
  EXPECT_FALSE(texture->is_seen(0, 0));
}

TEST(SkinTextureIo, ReplacesTheOldOneAndLeavesNothingBeside) {
  const auto folder = written_folder("replaced");
  auto texture = small_texture();
  texture.color(0, 0) = {9, 8, 7};
  ASSERT_TRUE(write_skin_texture(folder, texture).has_value());
  EXPECT_EQ(read_skin_texture(folder)->color(0, 0), (Rgb8{9, 8, 7}));
  for (const auto& entry : fs::directory_iterator(folder.parent_path())) {
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".part")));
  }
}

TEST(SkinTextureIo, OnAFullDiskTheOldOneStays) {
  const auto folder = written_folder("full_disk");
  auto texture = small_texture();
  texture.color(0, 0) = {9, 8, 7};
  // A limit on the size of files fails a write as a full disk does, once SIGXFSZ is ignored.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit few_bytes{100, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &few_bytes);
  const auto written = write_skin_texture(folder, texture);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
  ASSERT_FALSE(written.has_value());
  EXPECT_THAT(written.error().message, HasSubstr("could not be written"));
  EXPECT_EQ(read_skin_texture(folder)->color(0, 0), small_texture().color(0, 0));
  EXPECT_FALSE(fs::exists(folder.string() + ".part-" + std::to_string(getpid())));
}

TEST(SkinTextureIo, WhereNothingMayBeWrittenSaysSo) {
  const auto written = write_skin_texture("/proc/morgagni/texture", small_texture());
  ASSERT_FALSE(written.has_value());
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, HasSubstr("/proc/morgagni"));
}

TEST(SkinTextureIo, AFolderWithoutATextureIsNotFound) {
  const auto texture = read_skin_texture(fresh_folder("absent"));
  ASSERT_FALSE(texture.has_value());
  EXPECT_EQ(texture.error().code, ErrorCode::kNotFound);
}

TEST(SkinTextureIo, RefusesToWriteWhatDoesNotFitTogether) {
  auto texture = small_texture();
  texture.sources(3, 4).frame = 2;
  auto written = write_skin_texture(fresh_folder("unfit"), texture);
  ASSERT_FALSE(written.has_value());
  EXPECT_THAT(written.error().message, HasSubstr("a texel names frame 2 of 2"));
  texture.color = Image<Rgb8>(11, 10);
  written = write_skin_texture(fresh_folder("unfit"), texture);
  ASSERT_FALSE(written.has_value());
  EXPECT_THAT(written.error().message, HasSubstr("12x10 px, got 11x10 px"));
  EXPECT_FALSE(fs::exists(fresh_folder("unfit")));
}

TEST(SkinTextureIo, RefusesChangedFiles) {
  const auto folder = written_folder("changed");
  for (const char* name : {"color.png", "skin.ply", "corners.bin", "source_angle.png"}) {
    const auto bytes = read_file(folder / name, 1U << 20U).value();
    auto changed = bytes;
    changed[changed.size() / 2] ^= std::byte{1};
    ASSERT_TRUE(write_file(folder / name, changed).has_value());
    EXPECT_THAT(refusal(folder), HasSubstr(std::string(name) + " is not the file that was"));
    ASSERT_TRUE(write_file(folder / name, bytes).has_value());
  }
  EXPECT_EQ(refusal(folder), "was read");
}

TEST(SkinTextureIo, RefusesAHostileIndex) {
  const struct {
    const char* old;
    const char* now;
    const char* sentence;
  } cases[] = {
      {"\"format\": 1", "\"format\": 2", "this version reads format 1"},
      {"\"format\": 1", "\"format\": \"x\"", "names no format"},
      {"\"width_px\": 12", "\"width_px\": 1000000", "width_px must be 1 to 8192 px"},
      {"\"width_px\": 12", "\"width_px\": -1", "width_px must be 1 to 8192 px"},
      {"\"width_px\": 12", "\"width_px\": 13", "is 12x10 px, the atlas 13x10 px"},
      {"\"px_per_mm\": 0.9", "\"px_per_mm\": 0", "px_per_mm must be a positive number"},
      {"\"frame_id\": 41", "\"frame_id\": -41", "without id, time or pose"},
      {"0.3333333333333333", "0.3333333333333333, 1", "without id, time or pose"},
      {"\"frames\"", "\"pictures\"", "must list at most 65534 frames"},
      {"\"files\"", "\"hashes\"", "has no hash of skin.ply"},
      {"{", "[", "is not JSON"},
  };
  for (const auto& [old, now, sentence] : cases) {
    const auto folder = written_folder("hostile");
    replace_in_index(folder, old, now);
    EXPECT_THAT(refusal(folder), HasSubstr(sentence)) << now;
  }
}

TEST(SkinTextureIo, RefusesAnIndexNestedWithoutEnd) {
  const auto folder = written_folder("nested");
  ASSERT_TRUE(write_file(folder / "texture.json", std::string(100'000, '[')).has_value());
  EXPECT_THAT(refusal(folder), HasSubstr("is not JSON"));
}

TEST(SkinTextureIo, RefusesASourceOfNoFrame) {
  const auto folder = written_folder("no_frame");
  const auto text = read_text_file(folder / "texture.json", 1U << 20U).value();
  // The list of frames emptied: the texel that names frame 1 has none.
  const auto begin = text.find("\"frames\": [") + 11;
  const auto end = text.find("\"height_px\"");
  ASSERT_LT(begin, end);
  ASSERT_TRUE(write_file(folder / "texture.json", text.substr(0, begin) + "]," + text.substr(end)));
  EXPECT_THAT(refusal(folder), HasSubstr("a texel names frame 1 of 0"));
}

}  // namespace
}  // namespace mor
