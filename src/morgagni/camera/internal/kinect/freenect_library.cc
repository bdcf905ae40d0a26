// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/kinect/freenect_library.h"

#include <dlfcn.h>
#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

template <class Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
}

}  // namespace

Result<std::shared_ptr<const FreenectLibrary>> FreenectLibrary::load(const std::string& name) {
  std::shared_ptr<FreenectLibrary> library(new FreenectLibrary);
  library->handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library->handle_ == nullptr) {
    return make_error(
        ErrorCode::kNotFound,
        fmt::format("a Kinect needs the package libfreenect0.5, which is not installed ({})",
                    dlerror()));
  }
  auto& l = *library;
  const auto need = [&](const char* function, auto& pointer) {
    find(l.handle_, function, pointer);
    return pointer != nullptr;
  };
  const bool is_whole =
      need("freenect_init", l.init) && need("freenect_shutdown", l.shutdown) &&
      need("freenect_set_log_level", l.set_log_level) &&
      need("freenect_select_subdevices", l.select_subdevices) &&
      need("freenect_num_devices", l.num_devices) && need("freenect_open_device", l.open_device) &&
      need("freenect_close_device", l.close_device) &&
      need("freenect_set_depth_callback", l.set_depth_callback) &&
      need("freenect_set_video_callback", l.set_video_callback) &&
      need("freenect_find_depth_mode", l.find_depth_mode) &&
      need("freenect_find_video_mode", l.find_video_mode) &&
      need("freenect_set_depth_mode", l.set_depth_mode) &&
      need("freenect_set_video_mode", l.set_video_mode) &&
      need("freenect_start_depth", l.start_depth) && need("freenect_start_video", l.start_video) &&
      need("freenect_stop_depth", l.stop_depth) && need("freenect_stop_video", l.stop_video) &&
      need("freenect_process_events_timeout", l.process_events_timeout);
  if (!is_whole) {
    return make_error(ErrorCode::kNotFound, fmt::format("{} is no libfreenect 0.5", name));
  }
  find(l.handle_, "freenect_copy_registration", l.copy_registration);
  find(l.handle_, "freenect_destroy_registration", l.destroy_registration);
  find(l.handle_, "freenect_list_device_attributes", l.list_device_attributes);
  find(l.handle_, "freenect_free_device_attributes", l.free_device_attributes);
  return library;
}

FreenectLibrary::~FreenectLibrary() {
  if (handle_ != nullptr) dlclose(handle_);
}

}  // namespace mor::internal
