// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/body_preview.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "morgagni/ct/internal/outline_colors.h"

namespace mor::internal {
namespace {

constexpr int kPanePx = 360;
constexpr int kGapPx = 8;
constexpr Rgb8 kBackground = {24, 24, 28};

Rgb8 shaded(Rgb8 color, std::uint8_t grey) {
  const auto mixed = [&](std::uint8_t channel) {
    return static_cast<std::uint8_t>(channel * grey / 255);
  };
  return {mixed(color.r), mixed(color.g), mixed(color.b)};
}

/// Where a pixel of a pane looks: across two of the CT's axes, in mm of the grid.
struct Pane {
  int across = 0;  ///< Grid axis along the picture's x.
  int down = 1;    ///< ... along its y.
  bool flip_across = false;
  bool flip_down = false;
};

class PreviewPainter {
 public:
  PreviewPainter(const Volume& volume,
                 const BitMask& matter,
                 const BitMask& body,
                 const BitMask& doubtful)
      : volume_(volume), matter_(matter), body_(body), doubtful_(doubtful) {
    const auto& axes = volume.ct_from_grid.linear();
    for (int lps = 0; lps < 3; ++lps) {
      int best = 0;
      for (int grid = 1; grid < 3; ++grid)
        if (std::abs(axes(lps, grid)) > std::abs(axes(lps, best))) best = grid;
      grid_of_[static_cast<std::size_t>(lps)] = best;
      flipped_[static_cast<std::size_t>(lps)] = axes(lps, best) < 0.0;
    }
    for (int axis = 0; axis < 3; ++axis)
      largest_mm_ = std::max(largest_mm_,
                             volume.size[static_cast<std::size_t>(axis)] * volume.spacing_mm[axis]);
  }

  /// A slice across the body axis, at a share of its length; left of the picture: patient's right.
  void paint_slice(Image<Rgb8>& picture, int left_px, int top_px, double share) const {
    const Pane pane = {grid_of_[0], grid_of_[1], flipped_[0], flipped_[1]};
    const int axis = grid_of_[2];
    const int depth = static_cast<int>(share * (side(axis) - 1));
    paint(picture, left_px, top_px, pane, [&](std::array<int, 3> at) {
      at[static_cast<std::size_t>(axis)] = depth;
      return color_in_slice(at, pane);
    });
  }

  /// The body seen from the front (lps_depth 1) or from its left (0), head up.
  void paint_view(Image<Rgb8>& picture, int left_px, int top_px, int lps_depth) const {
    const int lps_across = 1 - lps_depth;
    const Pane pane = {grid_of_[static_cast<std::size_t>(lps_across)],
                       grid_of_[2],
                       flipped_[static_cast<std::size_t>(lps_across)],
                       !flipped_[2]};
    const int axis = grid_of_[static_cast<std::size_t>(lps_depth)];
    // From the front is from small y (LPS), from the left is from large x.
    const bool from_high = flipped_[static_cast<std::size_t>(lps_depth)] != (lps_depth == 0);
    paint(picture, left_px, top_px, pane, [&](std::array<int, 3> at) {
      return color_along_ray(at, axis, from_high);
    });
  }

 private:
  [[nodiscard]] int side(int axis) const { return volume_.size[static_cast<std::size_t>(axis)]; }

  template <class ColorOf>
  void paint(
      Image<Rgb8>& picture, int left_px, int top_px, const Pane& pane, const ColorOf& color) const {
    const double mm_per_px = largest_mm_ / kPanePx;
    for (int y = 0; y < kPanePx; ++y) {
      for (int x = 0; x < kPanePx; ++x) {
        std::array<int, 3> at{};
        if (!to_grid(pane.across, x, mm_per_px, pane.flip_across, at) ||
            !to_grid(pane.down, y, mm_per_px, pane.flip_down, at))
          continue;
        picture(left_px + x, top_px + y) = color(at);
      }
    }
  }

  /// The pane's middle is the grid's.
  bool to_grid(int axis, int px, double mm_per_px, bool flip, std::array<int, 3>& at) const {
    const double mm = (px - 0.5 * kPanePx) * mm_per_px * (flip ? -1.0 : 1.0);
    const double index = mm / volume_.spacing_mm[axis] + 0.5 * side(axis);
    at[static_cast<std::size_t>(axis)] = static_cast<int>(std::floor(index));
    return index >= 0.0 && index < side(axis);
  }

  [[nodiscard]] bool is_edge(const std::array<int, 3>& at, const Pane& pane) const {
    for (const int axis : {pane.across, pane.down}) {
      for (const int step : {-1, 1}) {
        auto next = at;
        next[static_cast<std::size_t>(axis)] += step;
        const int place = next[static_cast<std::size_t>(axis)];
        if (place < 0 || place >= side(axis)) continue;
        if (!body_.test(next[0], next[1], next[2])) return true;
      }
    }
    return false;
  }

  [[nodiscard]] Rgb8 outline_color(const std::array<int, 3>& at) const {
    return doubtful_.test(at[0], at[1], at[2]) ? kDoubtful : kOutline;
  }

  [[nodiscard]] Rgb8 color_in_slice(const std::array<int, 3>& at, const Pane& pane) const {
    constexpr double kLowHu = -1000.0;
    constexpr double kHighHu = 500.0;
    const double hu = volume_.hu[volume_.index(at[0], at[1], at[2])];
    const auto grey =
        static_cast<std::uint8_t>(std::clamp((hu - kLowHu) / (kHighHu - kLowHu), 0.0, 1.0) * 255.0);
    if (body_.test(at[0], at[1], at[2]))
      return is_edge(at, pane) ? outline_color(at) : Rgb8{grey, grey, grey};
    if (matter_.test(at[0], at[1], at[2]))
      return {static_cast<std::uint8_t>(155 + grey / 3),
              static_cast<std::uint8_t>(grey / 4),
              static_cast<std::uint8_t>(grey / 4)};
    return {grey, grey, static_cast<std::uint8_t>(std::min(255, grey + 14))};
  }

  /// The first matter that a ray meets, darker the deeper it lies; red where it was cut off.
  [[nodiscard]] Rgb8 color_along_ray(std::array<int, 3> at, int axis, bool from_high) const {
    auto& place = at[static_cast<std::size_t>(axis)];
    bool through_cut = false;
    for (int step = 0; step < side(axis); ++step) {
      place = from_high ? side(axis) - 1 - step : step;
      const bool is_body = body_.test(at[0], at[1], at[2]);
      through_cut = through_cut || (!is_body && matter_.test(at[0], at[1], at[2]));
      if (!is_body) continue;
      const double share = static_cast<double>(step) / side(axis);
      const auto grey = static_cast<std::uint8_t>(255.0 * (1.0 - 0.85 * share));
      if (doubtful_.test(at[0], at[1], at[2])) return shaded(kDoubtful, grey);
      if (!through_cut) return {grey, grey, grey};
      return {
          grey, static_cast<std::uint8_t>(grey * 2 / 3), static_cast<std::uint8_t>(grey * 2 / 3)};
    }
    return through_cut ? Rgb8{150, 40, 40} : kBackground;
  }

  const Volume& volume_;
  const BitMask& matter_;
  const BitMask& body_;
  const BitMask& doubtful_;
  std::array<int, 3> grid_of_{};
  std::array<bool, 3> flipped_{};
  double largest_mm_ = 0.0;
};

}  // namespace

Image<Rgb8> draw_body_preview(const Volume& volume,
                              const BitMask& matter,
                              const BitMask& body,
                              const BitMask& doubtful) {
  const PreviewPainter painter(volume, matter, body, doubtful);
  constexpr int kColumns = 3;
  constexpr int kRows = 2;
  Image<Rgb8> picture(
      kColumns * (kPanePx + kGapPx) + kGapPx, kRows * (kPanePx + kGapPx) + kGapPx, kBackground);
  const auto place = [](int index) { return kGapPx + index * (kPanePx + kGapPx); };
  constexpr std::array<double, 4> kSlices = {0.15, 0.4, 0.65, 0.9};
  for (int i = 0; i < kColumns; ++i)
    painter.paint_slice(picture, place(i), place(0), kSlices[static_cast<std::size_t>(i)]);
  painter.paint_slice(picture, place(2), place(1), kSlices[3]);
  painter.paint_view(picture, place(0), place(1), 1);
  painter.paint_view(picture, place(1), place(1), 0);
  return picture;
}

}  // namespace mor::internal
