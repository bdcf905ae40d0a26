// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/image_png.h"

#include <fstream>
#include <span>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

using testing::HasSubstr;

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / name;
}

template <class T>
std::filesystem::path store(const Image<T>& image, const std::string& name) {
  const auto path = scratch(name);
  EXPECT_TRUE(write_file(path, encode_png(image.view())));
  return path;
}

Image<std::uint16_t> ramp() {
  Image<std::uint16_t> image(7, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) image(x, y) = static_cast<std::uint16_t>(1000 * y + 257 * x);
  }
  return image;
}

TEST(Png, KeepsDepthToTheLastBit) {
  const auto read = read_png_gray16(store(ramp(), "ramp.png"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, ramp());
}

TEST(Png, KeepsColour) {
  Image<Rgb8> image(3, 2, {10, 200, 30});
  image(2, 1) = {1, 2, 3};
  const auto read = read_png_rgb(store(image, "rgb.png"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, image);
}

TEST(Png, RefusesColourWhereDepthIsExpected) {
  const auto read = read_png_gray16(store(Image<Rgb8>(3, 2), "not_depth.png"));
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("16-bit grey"));
}

TEST(Png, TellsItsSizeBeforeItIsUnpacked) {
  const auto depth = encode_png(Image<std::uint16_t>(5, 3).view());
  EXPECT_EQ(read_png_head(depth).value().width_px, 5U);
  EXPECT_EQ(read_png_head(depth).value().height_px, 3U);
  EXPECT_TRUE(read_png_head(depth).value().is_gray16);
  EXPECT_FALSE(read_png_head(encode_png(Image<Rgb8>(5, 3).view())).value().is_gray16);
  for (std::size_t size = 0; size < 26; ++size) EXPECT_FALSE(read_png_head({depth.data(), size}));
}

TEST(Png, SaysThatATruncatedFileEndsTooEarly) {
  const auto bytes = encode_png(ramp().view());
  const auto path = scratch("cut.png");
  ASSERT_TRUE(write_file(path, std::span(bytes).first(bytes.size() / 2)));
  const auto read = read_png_gray16(path);
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("cut.png"));
}

long resident_mib() {
  std::ifstream pages("/proc/self/statm");
  long all = 0, resident = 0;
  pages >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE) / (1L << 20);
}

TEST(Png, ABrokenPictureLeavesNoMemoryBehind) {
  auto bytes = encode_png(Image<std::uint16_t>(1024, 1024, 7).view());
  bytes.resize(bytes.size() - 30);
  const auto before_mib = resident_mib();
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(decode_png_gray16(bytes));
  EXPECT_LT(resident_mib() - before_mib, 100) << "of 400 MiB that were unpacked";
}

}  // namespace
}  // namespace mor
