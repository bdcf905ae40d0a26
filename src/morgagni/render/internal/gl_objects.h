// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include <epoxy/gl.h>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"

namespace mor::internal {

/// An OpenGL object's name, deleted by `Delete` with it. The context must be current then.
template <void (*Delete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlName() {
    if (name_ != 0) Delete(name_);
  }

  [[nodiscard]] GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

inline void delete_buffer(GLuint name) {
  glDeleteBuffers(1, &name);
}
inline void delete_vertex_array(GLuint name) {
  glDeleteVertexArrays(1, &name);
}
inline void delete_renderbuffer(GLuint name) {
  glDeleteRenderbuffers(1, &name);
}
inline void delete_framebuffer(GLuint name) {
  glDeleteFramebuffers(1, &name);
}
inline void delete_texture(GLuint name) {
  glDeleteTextures(1, &name);
}
inline void delete_program(GLuint name) {
  glDeleteProgram(name);
}

using GlBuffer = GlName<delete_buffer>;
using GlVertexArray = GlName<delete_vertex_array>;
using GlRenderbuffer = GlName<delete_renderbuffer>;
using GlFramebuffer = GlName<delete_framebuffer>;
using GlTexture = GlName<delete_texture>;
using GlProgram = GlName<delete_program>;

[[nodiscard]] GlBuffer make_buffer();
[[nodiscard]] GlVertexArray make_vertex_array();

/// Compiles and links. @errors kDevice: the compiler's own words.
[[nodiscard]] Result<GlProgram> make_program(const char* vertex_text, const char* fragment_text);

/// A picture on the device that shaders look at. Keeps its memory while the size stays.
class GlPicture {
 public:
  /// Between pixels the mean of them; beyond the edge as at the edge.
  void upload(ImageView<const Rgba8> picture);
  /// For looking at single pixels.
  void upload(ImageView<const float> values);

  void bind(GLenum texture_unit) const;

 private:
  void upload(int width,
              int height,
              GLint internal_format,
              GLenum format,
              GLenum type,
              const void* pixels,
              std::ptrdiff_t stride,
              GLint filter);

  GlTexture texture_;
  int width_ = 0;
  int height_ = 0;
};

/// Colour (RGBA8) and depth, off screen. One sample a pixel on every device: a pixel's depth is
/// that of its centre, and a picture does not depend on who drew it. Keeps its memory while the
/// size asked for fits.
class RenderTarget {
 public:
  /// Bound for drawing, cleared to nothing. @errors kDevice: the device refuses such a target.
  [[nodiscard]] Result<void> begin(int width, int height);

  /// Reads `width` x `height` pixels from the corner of row 0, and their depth from 0 to 1 (1:
  /// nothing drawn). Waits for the drawing.
  void read(int width, int height, void* rgba, float* depth);

 private:
  [[nodiscard]] Result<void> allocate(int width, int height);

  int width_ = 0;
  int height_ = 0;
  GlRenderbuffer color_;
  GlRenderbuffer depth_;
  GlFramebuffer drawn_;
};

}  // namespace mor::internal
