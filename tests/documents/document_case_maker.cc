// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Makes what the tests of the documents take away: a case with a painted skin and findings, among
// them hostile notes.
// Usage: document_case_maker CASE    (a new case from a synthetic CT, or one that is there already)

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/casefile/testing/synthetic_ct.h"
#include "morgagni/core/image_png.h"
#include "morgagni/documentation/findings_io.h"
#include "morgagni/documentation/geodesic.h"
#include "morgagni/documentation/skin_texture_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr int kCellPx = 10;  ///< Of the atlas; two triangles share a cell.

template <class T>
T must(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// A colour for each place of the body, so that a picture shows whether it is where it should be.
Rgb8 color_at(const Eigen::Vector3f& place_mm) {
  const auto stripes = [](float mm) { return std::fmod(std::abs(mm), 40.0F) < 20.0F; };
  const bool is_dark = stripes(place_mm.x()) != stripes(place_mm.z());
  if (place_mm.y() < 0.0F && is_dark) return {190, 120, 96};
  return is_dark ? Rgb8{176, 132, 110} : Rgb8{222, 178, 150};
}

std::shared_ptr<SkinAtlas> make_atlas(const TriangleMesh& skin) {
  auto atlas = std::make_shared<SkinAtlas>();
  atlas->mesh = skin;
  const auto num_cells = static_cast<double>((skin.triangles.size() + 1) / 2);
  const int num_columns = static_cast<int>(std::ceil(std::sqrt(num_cells)));
  atlas->width_px = num_columns * kCellPx;
  atlas->height_px = (static_cast<int>(num_cells) / num_columns + 1) * kCellPx;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto cell = static_cast<int>(t / 2);
    const Eigen::Vector2f corner(static_cast<float>(cell % num_columns * kCellPx),
                                 static_cast<float>(cell / num_columns * kCellPx));
    const auto at = [&](float x, float y) -> Eigen::Vector2f {
      return corner + Eigen::Vector2f(x, y);
    };
    if (t % 2 == 0) {
      atlas->corners_px.push_back({at(1, 1), at(6, 1), at(1, 6)});
    } else {
      atlas->corners_px.push_back({at(8, 8), at(3, 8), at(8, 3)});
    }
  }
  return atlas;
}

/// Painted everywhere but on the back of the head side.
SkinTexture make_texture(const TriangleMesh& skin) {
  SkinTexture texture;
  const auto atlas = make_atlas(skin);
  texture.color = Image<Rgb8>(atlas->width_px, atlas->height_px);
  texture.sources = Image<TexelSource>(atlas->width_px, atlas->height_px);
  const float middle = skin.bounds().center().y();
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto& [a, b, c] = atlas->corners_px[t];
    Eigen::Matrix2f edges;
    edges << b - a, c - a;
    const Eigen::Matrix2f inverse = edges.inverse();
    const int left = static_cast<int>(std::min({a.x(), b.x(), c.x()}));
    const int top = static_cast<int>(std::min({a.y(), b.y(), c.y()}));
    for (int y = top; y <= top + 5; ++y) {
      for (int x = left; x <= left + 5; ++x) {
        const Eigen::Vector2f share =
            inverse * (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - a);
        if (share.minCoeff() < -1e-3F || share.sum() > 1.001F) continue;
        const auto& corners = skin.triangles[t];
        const Eigen::Vector3f& base = skin.vertices[corners[0]];
        const Eigen::Vector3f place = base + share.x() * (skin.vertices[corners[1]] - base) +
                                      share.y() * (skin.vertices[corners[2]] - base);
        if (place.y() > middle + 0.3F * skin.bounds().sizes().y()) continue;
        texture.color(x, y) = color_at(place);
        texture.sources(x, y) = {static_cast<std::uint32_t>(t % 3), 0.2F, 640.0F, 0.9F};
      }
    }
  }
  for (std::uint64_t i = 0; i < 3; ++i)
    texture.frames.push_back({i,
                              1795708805000 + static_cast<std::int64_t>(i) * 33,
                              Eigen::Isometry3d::Identity(),
                              1.1 + 0.3 * static_cast<double>(i)});
  texture.atlas = atlas;
  return texture;
}

/// The skin's vertex that lies farthest in a direction.
Eigen::Vector3d farthest(const TriangleMesh& skin, const Eigen::Vector3f& direction) {
  const Eigen::Vector3f* best = &skin.vertices.front();
  for (const auto& vertex : skin.vertices) {
    if (vertex.dot(direction) > best->dot(direction)) best = &vertex;
  }
  return best->cast<double>();
}

std::vector<Finding> make_findings(const TriangleMesh& skin) {
  const auto front = farthest(skin, {0.0F, -1.0F, 0.0F});
  const auto left = farthest(skin, {0.5F, -0.8F, 0.25F});
  const auto right = farthest(skin, {-0.6F, -0.75F, -0.2F});
  const GeodesicMesh geodesics(std::make_shared<TriangleMesh>(skin));
  const auto way = must(geodesics.shortest_path(must(nearest_on_surface(skin, left)),
                                                must(nearest_on_surface(skin, right))));
  const std::string when = "2026-11-26T16:20:05Z";
  return {{"F1",
           FindingKind::kPoint,
           "</script><script>window.hacked = 1</script><img src=x onerror=\"window.hacked = 2\"> & "
           "\"quotes\"",
           {{front, true, 1.4}},
           {},
           {},
           {},
           when,
           "F1.png"},
          {"F2",
           FindingKind::kDistance,
           "Einschuss \xC3\x9C"
           "bergang, \xD0\xB2\xD1\x85\xD0\xBE\xD0\xB4\xD0\xBD\xD0\xBE\xD0\xB5 "
           "\xD0\xBE\xD1\x82\xD0\xB2\xD0\xB5\xD1\x80\xD1\x81\xD1\x82\xD0\xB8\xD0\xB5, "
           "\xE5\xB0\x84\xE5\x85\xA5\xE5\x8F\xA3",
           {{left, true, 1.2}, {right, true, 1.6}},
           {},
           (left - right).norm(),
           1.9,
           when,
           ""},
          {"F3",
           FindingKind::kGeodesic,
           "\xD8\xAC\xD8\xB1\xD8\xAD over the skin",
           {{left, true, std::nullopt}, {right, true, std::nullopt}},
           way.points_mm,
           way.length_mm,
           std::nullopt,
           when,
           ""},
          {"F4",
           FindingKind::kPoint,
           "Inside the body",
           {{skin.bounds().center().cast<double>(), false, 3.0}},
           {},
           {},
           {},
           when,
           ""}};
}

void make_photo(const fs::path& file) {
  Image<Rgb8> photo(160, 120);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 0; x < photo.width(); ++x)
      photo(x, y) = {static_cast<std::uint8_t>(150 + x / 4),
                     static_cast<std::uint8_t>(100 + y / 3),
                     static_cast<std::uint8_t>((x / 20 + y / 20) % 2 * 60 + 60)};
  must(write_file(file, encode_png(photo.view())));
}

void run(const fs::path& folder) {
  if (!fs::exists(folder / kCaseFile)) {
    const fs::path ct = folder.string() + ".mha";
    fs::create_directories(fs::absolute(folder).parent_path());
    testing_ct::write_synthetic_ct(ct);
    PrepareOptions options;
    options.skin.num_vertices = 4000;
    must(prepare_case(ct, folder, options, [](std::string_view, double) {}));
    fs::remove(ct);
  }
  const auto body = must(load_case(folder));
  must(write_skin_texture(folder / "texture", make_texture(body.skin->mesh)));
  must(write_findings(folder / "findings", make_findings(body.skin->mesh)));
  make_photo(folder / "findings" / "F1.png");
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  mor::run(argv[1]);
  return 0;
}
