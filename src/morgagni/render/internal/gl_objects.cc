// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/gl_objects.h"

#include <algorithm>
#include <array>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

GlRenderbuffer make_renderbuffer(GLenum format, int width, int height) {
  GLuint name = 0;
  glGenRenderbuffers(1, &name);
  glBindRenderbuffer(GL_RENDERBUFFER, name);
  glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  return GlRenderbuffer(name);
}

GlFramebuffer make_framebuffer(const GlRenderbuffer& color, const GlRenderbuffer& depth) {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color.get());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.get());
  return GlFramebuffer(name);
}

Result<GLuint> compile(GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint is_good = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &is_good);
  if (is_good == GL_TRUE) return shader;
  std::array<char, 1024> words{};
  glGetShaderInfoLog(shader, words.size(), nullptr, words.data());
  glDeleteShader(shader);
  return make_error(ErrorCode::kDevice,
                    fmt::format("the OpenGL driver refuses a shader: {}", words.data()));
}

}  // namespace

GlBuffer make_buffer() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return GlBuffer(name);
}

GlVertexArray make_vertex_array() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return GlVertexArray(name);
}

Result<GlProgram> make_program(const char* vertex_text, const char* fragment_text) {
  MOR_TRY(const GLuint vertex, compile(GL_VERTEX_SHADER, vertex_text));
  const auto fragment = compile(GL_FRAGMENT_SHADER, fragment_text);
  GlProgram program(glCreateProgram());
  glAttachShader(program.get(), vertex);
  if (fragment) glAttachShader(program.get(), *fragment);
  glLinkProgram(program.get());
  // Attached shaders live until their program goes.
  glDeleteShader(vertex);
  if (!fragment) return tl::unexpected<Error>(fragment.error());
  glDeleteShader(*fragment);
  GLint is_good = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &is_good);
  if (is_good == GL_TRUE) return program;
  std::array<char, 1024> words{};
  glGetProgramInfoLog(program.get(), words.size(), nullptr, words.data());
  return make_error(ErrorCode::kDevice,
                    fmt::format("the OpenGL driver refuses a program: {}", words.data()));
}

void GlPicture::upload(ImageView<const Rgba8> picture) {
  upload(picture.width(),
         picture.height(),
         GL_RGBA8,
         GL_RGBA,
         GL_UNSIGNED_BYTE,
         picture.row(0),
         picture.stride(),
         GL_LINEAR);
}

void GlPicture::upload(ImageView<const float> values) {
  upload(values.width(),
         values.height(),
         GL_R32F,
         GL_RED,
         GL_FLOAT,
         values.row(0),
         values.stride(),
         GL_NEAREST);
}

void GlPicture::upload(int width,
                       int height,
                       GLint internal_format,
                       GLenum format,
                       GLenum type,
                       const void* pixels,
                       std::ptrdiff_t stride,
                       GLint filter) {
  const bool is_new = texture_.get() == 0;
  if (is_new) {
    GLuint name = 0;
    glGenTextures(1, &name);
    texture_ = GlTexture(name);
  }
  glBindTexture(GL_TEXTURE_2D, texture_.get());
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(stride));
  if (!is_new && width == width_ && height == height_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, format, type, pixels);
  } else {
    width_ = width;
    height_ = height;
    glTexImage2D(GL_TEXTURE_2D, 0, internal_format, width, height, 0, format, type, pixels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void GlPicture::bind(GLenum texture_unit) const {
  glActiveTexture(texture_unit);
  glBindTexture(GL_TEXTURE_2D, texture_.get());
  glActiveTexture(GL_TEXTURE0);
}

Result<void> RenderTarget::allocate(int width, int height) {
  width_ = std::max(width, width_);
  height_ = std::max(height, height_);
  color_ = make_renderbuffer(GL_RGBA8, width_, height_);
  depth_ = make_renderbuffer(GL_DEPTH_COMPONENT32F, width_, height_);
  drawn_ = make_framebuffer(color_, depth_);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    const auto error = make_error(
        ErrorCode::kDevice,
        fmt::format("OpenGL gives no target of {} x {} px (0x{:x})", width_, height_, status));
    width_ = 0;
    height_ = 0;
    return error;
  }
  return {};
}

Result<void> RenderTarget::begin(int width, int height) {
  if (width > width_ || height > height_) MOR_CHECK(allocate(width, height));
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.get());
  glViewport(0, 0, width, height);
  glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  return {};
}

void RenderTarget::read(int width, int height, void* rgba, float* depth) {
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
  glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
}

}  // namespace mor::internal
