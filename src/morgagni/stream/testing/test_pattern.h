// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor::testing {

/// Moving pictures that say in their pixels which one they are: the lower edge has 24 squares of
/// 16 px, white for a 1 and black for a 0 of the frame's number, the highest bit at the left. They
/// survive the video coding, so that a browser can prove which picture it shows.
class TestPattern {
 public:
  static constexpr int kBitPx = 16;
  static constexpr int kNumBits = 24;

  /// Colour waves, or a picture that sways if a PNG is given. Sides of at least
  /// kBitPx * kNumBits and kBitPx.
  TestPattern(int width, int height);
  [[nodiscard]] static Result<TestPattern> over_picture(const std::filesystem::path& png,
                                                        int width,
                                                        int height);

  /// The picture of that number; valid until the next call.
  [[nodiscard]] ImageView<const Rgba8> draw(std::uint32_t number);

 private:
  void draw_number(std::uint32_t number);

  Image<Rgb8> background_;
  Image<Rgba8> picture_;
};

}  // namespace mor::testing
