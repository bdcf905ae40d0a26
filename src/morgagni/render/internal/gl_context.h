// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "morgagni/core/result.h"

namespace mor::internal {

/// OpenGL 3.3 core without a window: the first GPU that gives it, else Mesa's software renderer.
/// @threads Belongs to one thread at a time: the one that last called make_current().
class GlContext {
 public:
  /// Made current in the calling thread. @errors kDevice: says what was tried.
  [[nodiscard]] static Result<std::unique_ptr<GlContext>> create();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Free of cost where it is current already. @return False: the context is lost.
  [[nodiscard]] bool make_current() const;

  /// GL_RENDERER, such as "llvmpipe (LLVM 15.0.6, 256 bits)".
  [[nodiscard]] const std::string& device() const { return device_; }

  /// Drawn by the CPU: every triangle costs what the rest of the program needs too.
  [[nodiscard]] bool is_software() const { return is_software_; }

 private:
  GlContext(void* display, void* context) : display_(display), context_(context) {}

  void* display_;  ///< EGLDisplay: shared by the process, so never terminated here.
  void* context_;  ///< EGLContext.
  std::string device_;
  bool is_software_ = false;
};

}  // namespace mor::internal
