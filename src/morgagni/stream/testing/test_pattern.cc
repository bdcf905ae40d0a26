// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/testing/test_pattern.h"

#include <algorithm>
#include <cmath>

#include "morgagni/core/image_png.h"

namespace mor::testing {

namespace {

constexpr int kSwayPx = 12;

std::uint8_t wave(double phase) {
  return static_cast<std::uint8_t>(std::lround(110.0 + 90.0 * std::sin(phase)));
}

}  // namespace

TestPattern::TestPattern(int width, int height)
    : background_(width, height), picture_(width, height) {
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      background_(x, y) = {wave(x * 0.02), wave(y * 0.025 + 1.0), wave((x + y) * 0.012 + 2.0)};
    }
  }
}

Result<TestPattern> TestPattern::over_picture(const std::filesystem::path& png,
                                              int width,
                                              int height) {
  MOR_TRY(const auto picture, read_png_rgb(png));
  TestPattern pattern(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pattern.background_(x, y) =
          picture(x * picture.width() / width, y * picture.height() / height);
    }
  }
  return pattern;
}

ImageView<const Rgba8> TestPattern::draw(std::uint32_t number) {
  const int width = picture_.width();
  const int height = picture_.height();
  const int shift_x = static_cast<int>(std::lround(kSwayPx * std::sin(number * 0.05)));
  const int shift_y = static_cast<int>(std::lround(kSwayPx * std::cos(number * 0.04)));
  for (int y = 0; y < height; ++y) {
    const int from_y = std::clamp(y + shift_y, 0, height - 1);
    for (int x = 0; x < width; ++x) {
      const Rgb8 color = background_(std::clamp(x + shift_x, 0, width - 1), from_y);
      picture_(x, y) = {color.r, color.g, color.b, 255};
    }
  }
  draw_number(number);
  return std::as_const(picture_).view();
}

void TestPattern::draw_number(std::uint32_t number) {
  for (int bit = 0; bit < kNumBits; ++bit) {
    const bool is_set = ((number >> (kNumBits - 1 - bit)) & 1U) != 0;
    const auto value = static_cast<std::uint8_t>(is_set ? 255 : 0);
    for (int y = picture_.height() - kBitPx; y < picture_.height(); ++y) {
      for (int x = bit * kBitPx; x < (bit + 1) * kBitPx; ++x)
        picture_(x, y) = {value, value, value};
    }
  }
}

}  // namespace mor::testing
