// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/render/internal/gl_context.h"

#include <array>
#include <string_view>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

struct Candidate {
  std::string name;
  EGLDisplay display = EGL_NO_DISPLAY;
};

bool has_extension(const char* extensions, std::string_view name) {
  return extensions != nullptr &&
         fmt::format(" {} ", extensions).find(fmt::format(" {} ", name)) != std::string::npos;
}

/// The GPUs, without the software device that Mesa lists among them.
std::vector<Candidate> gpu_displays(const char* client_extensions) {
  const bool can_list = has_extension(client_extensions, "EGL_EXT_platform_device") &&
                        (has_extension(client_extensions, "EGL_EXT_device_base") ||
                         has_extension(client_extensions, "EGL_EXT_device_enumeration"));
  std::vector<Candidate> candidates;
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint num_devices = 0;
  if (!can_list || eglQueryDevicesEXT(devices.size(), devices.data(), &num_devices) != EGL_TRUE) {
    return candidates;
  }
  for (int i = 0; i < num_devices; ++i) {
    const char* extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
    if (has_extension(extensions, "EGL_MESA_device_software")) continue;
    candidates.push_back({fmt::format("GPU {}", i),
                          eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr)});
  }
  return candidates;
}

std::vector<Candidate> displays_to_try() {
  const char* client_extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  std::vector<Candidate> candidates = gpu_displays(client_extensions);
  if (has_extension(client_extensions, "EGL_MESA_platform_surfaceless")) {
    candidates.push_back(
        {"Mesa without a screen",
         eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)});
  }
  return candidates;
}

/// A current OpenGL 3.3 core context without any surface, or why there is none.
tl::expected<EGLContext, std::string> open_context(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY) return tl::unexpected<std::string>("no display");
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
    return tl::unexpected(fmt::format("eglInitialize failed (0x{:x})", eglGetError()));
  }
  if (!has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context") ||
      eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) {
    return tl::unexpected<std::string>("no OpenGL without a surface");
  }
  constexpr std::array<EGLint, 5> kConfig{
      EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint num_configs = 0;
  if (eglChooseConfig(display, kConfig.data(), &config, 1, &num_configs) != EGL_TRUE ||
      num_configs == 0) {
    return tl::unexpected<std::string>("no OpenGL configuration");
  }
  constexpr std::array<EGLint, 7> kContext{EGL_CONTEXT_MAJOR_VERSION,
                                           3,
                                           EGL_CONTEXT_MINOR_VERSION,
                                           3,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                           EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, kContext.data());
  if (context == EGL_NO_CONTEXT) {
    return tl::unexpected(fmt::format("no OpenGL 3.3 (0x{:x})", eglGetError()));
  }
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE) {
    eglDestroyContext(display, context);
    return tl::unexpected(fmt::format("eglMakeCurrent failed (0x{:x})", eglGetError()));
  }
  return context;
}

bool names_software(std::string_view device) {
  return device.find("llvmpipe") != std::string_view::npos ||
         device.find("softpipe") != std::string_view::npos ||
         device.find("SWR") != std::string_view::npos;
}

}  // namespace

Result<std::unique_ptr<GlContext>> GlContext::create() {
  std::string tried;
  for (const Candidate& candidate : displays_to_try()) {
    const auto context = open_context(candidate.display);
    if (!context) {
      tried += fmt::format("{}{}: {}", tried.empty() ? "" : ", ", candidate.name, context.error());
      continue;
    }
    std::unique_ptr<GlContext> result(new GlContext(candidate.display, *context));
    const auto* name = glGetString(GL_RENDERER);
    result->device_ = name == nullptr ? "unnamed" : reinterpret_cast<const char*>(name);
    result->is_software_ = names_software(result->device_);
    return result;
  }
  return make_error(ErrorCode::kDevice,
                    fmt::format("no OpenGL 3.3 without a screen (tried {}); install libegl-mesa0 "
                                "and libgl1-mesa-dri, or a GPU driver with EGL",
                                tried.empty() ? "EGL, which offers no device" : tried));
}

GlContext::~GlContext() {
  if (eglGetCurrentContext() == context_) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_, context_);
}

bool GlContext::make_current() const {
  return eglGetCurrentContext() == context_ ||
         eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
}

}  // namespace mor::internal
