// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mor {

struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};

struct Rgba8 {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;
  bool operator==(const Rgba8&) const = default;
};

/// A look at pixels that somebody else owns: row by row, rows `stride` elements apart.
template <class T>
class ImageView {
 public:
  ImageView() = default;
  ImageView(T* data, int width, int height) : ImageView(data, width, height, width) {}
  ImageView(T* data, int width, int height, std::ptrdiff_t stride)
      : data_(data), width_(width), height_(height), stride_(stride) {}

  /// A view of mutable pixels serves where one of constant pixels is asked for.
  operator ImageView<const T>() const {  // NOLINT(google-explicit-constructor)
    return {data_, width_, height_, stride_};
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }
  [[nodiscard]] bool empty() const { return width_ <= 0 || height_ <= 0; }
  [[nodiscard]] bool contains(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }
  [[nodiscard]] T* row(int y) const { return data_ + y * stride_; }
  [[nodiscard]] T& operator()(int x, int y) const { return data_[y * stride_ + x]; }

 private:
  T* data_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

/// Pixels of its own, rows without gaps.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T value = T())
      : pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value),
        width_(width),
        height_(height) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return pixels_.empty(); }
  [[nodiscard]] T* data() { return pixels_.data(); }
  [[nodiscard]] const T* data() const { return pixels_.data(); }
  [[nodiscard]] std::size_t size() const { return pixels_.size(); }
  [[nodiscard]] T& operator()(int x, int y) { return pixels_[index(x, y)]; }
  [[nodiscard]] const T& operator()(int x, int y) const { return pixels_[index(x, y)]; }
  [[nodiscard]] ImageView<T> view() { return {pixels_.data(), width_, height_}; }
  [[nodiscard]] ImageView<const T> view() const { return {pixels_.data(), width_, height_}; }
  bool operator==(const Image&) const = default;

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  std::vector<T> pixels_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace mor
