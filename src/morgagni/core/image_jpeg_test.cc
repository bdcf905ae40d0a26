// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/image_jpeg.h"

#include <cstdlib>

#include <gmock/gmock.h>

namespace mor {
namespace {

using testing::HasSubstr;

Image<Rgb8> slope() {
  Image<Rgb8> image(33, 17);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(15 * y), 90};
    }
  }
  return image;
}

TEST(Jpeg, ComesBackNearlyAsItWas) {
  const auto image = slope();
  const auto back = decode_jpeg(encode_jpeg(image.view(), 95).value()).value();
  ASSERT_EQ(back.width(), 33);
  ASSERT_EQ(back.height(), 17);
  for (std::size_t i = 0; i < image.size(); ++i) {
    EXPECT_LT(std::abs(image.data()[i].r - back.data()[i].r), 12) << i;
    EXPECT_LT(std::abs(image.data()[i].g - back.data()[i].g), 12) << i;
    EXPECT_LT(std::abs(image.data()[i].b - back.data()[i].b), 12) << i;
  }
}

TEST(Jpeg, TellsItsSizeBeforeItIsUnpacked) {
  const auto size = read_jpeg_size(encode_jpeg(slope().view(), 95).value()).value();
  EXPECT_EQ(size.width_px, 33);
  EXPECT_EQ(size.height_px, 17);
  EXPECT_FALSE(read_jpeg_size({}));
}

TEST(Jpeg, TakesAPartOfALargerPicture) {
  const auto image = slope();
  const ImageView<const Rgb8> part(image.data() + 1, 16, 17, 33);
  const auto back = decode_jpeg(encode_jpeg(part, 100).value()).value();
  EXPECT_EQ(back.width(), 16);
  EXPECT_NEAR(back(0, 16).g, image(1, 16).g, 6);
}

TEST(Jpeg, EveryTruncationIsSaid) {
  const auto bytes = encode_jpeg(slope().view(), 80).value();
  for (std::size_t size = 0; size + 2 < bytes.size(); ++size) {
    const auto back = decode_jpeg({bytes.data(), size});
    ASSERT_FALSE(back) << size;
    EXPECT_THAT(back.error().message, HasSubstr("JPEG"));
  }
}

TEST(Jpeg, SaysWhatCannotBePacked) {
  EXPECT_THAT(encode_jpeg({}, 90).error().message, HasSubstr("empty"));
  EXPECT_THAT(encode_jpeg(slope().view(), 101).error().message, HasSubstr("[1, 100], got 101"));
}

}  // namespace
}  // namespace mor
