// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/render/testing/picture_difference.h"

/// Pictures that somebody has judged, kept in testdata/render.
namespace mor::testing {

inline Image<Rgb8> without_alpha(ImageView<const Rgba8> picture) {
  Image<Rgb8> result(picture.width(), picture.height());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Rgba8& pixel = picture(x, y);
      result(x, y) = {pixel.r, pixel.g, pixel.b};
    }
  }
  return result;
}

inline void write_picture(const std::filesystem::path& path, const Image<Rgb8>& picture) {
  std::filesystem::create_directories(path.parent_path());
  const auto written = write_file(path, encode_png(picture.view()));
  ASSERT_TRUE(written) << written.error().message;
}

/// White where pictures look the same, red where they do not.
inline Image<Rgb8> map_of(const PictureDifference& difference) {
  Image<Rgb8> map(difference.delta.width(), difference.delta.height());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float off = std::min(1.0F, difference.delta.data()[i] / 20.0F);
    const auto rest = static_cast<std::uint8_t>(255.0F * (1.0F - off));
    map.data()[i] = {255, rest, rest};
  }
  return map;
}

/// Fails where the picture looks different from the kept one, and writes it with the difference
/// into the build folder's golden_failures. With MORGAGNI_WRITE_GOLDEN set it becomes the kept one.
inline void expect_golden(const std::string& name, const Image<Rgb8>& picture) {
  namespace fs = std::filesystem;
  const fs::path golden = fs::path(MORGAGNI_TESTDATA) / "render" / (name + ".png");
  if (std::getenv("MORGAGNI_WRITE_GOLDEN") != nullptr) return write_picture(golden, picture);
  const auto expected = read_png_rgb(golden);
  ASSERT_TRUE(expected) << expected.error().message;
  ASSERT_EQ(expected->width(), picture.width());
  ASSERT_EQ(expected->height(), picture.height());
  const auto off = difference(picture, *expected);
  if (off.is_same()) return;
  const fs::path folder = fs::path(MORGAGNI_GOLDEN_FAILURES);
  write_picture(folder / (name + ".png"), picture);
  write_picture(folder / (name + "-difference.png"), map_of(off));
  ADD_FAILURE() << "looks different from " << golden << ": mean " << off.mean << ", seen at "
                << 100.0 * off.seen_share << " % of the pixels; see " << folder;
}

}  // namespace mor::testing
