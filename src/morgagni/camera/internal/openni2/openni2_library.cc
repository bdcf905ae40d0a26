// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/openni2/openni2_library.h"

#include <dlfcn.h>
#include <openni2/OniVersion.h>
#include <spdlog/fmt/fmt.h>

namespace mor::internal {

Result<std::shared_ptr<const Openni2Library>> Openni2Library::load(const std::string& name) {
  std::shared_ptr<Openni2Library> library(new Openni2Library);
  library->handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library->handle_ == nullptr) {
    return make_error(
        ErrorCode::kNotFound,
        fmt::format("an OpenNI2 camera needs the package libopenni2-0, which is not installed ({})",
                    dlerror()));
  }
  if (!library->find_all()) {
    return make_error(ErrorCode::kNotFound, fmt::format("{} is no OpenNI 2", name));
  }
  if (library->initialize_(ONI_API_VERSION) != ONI_STATUS_OK) {
    return make_error(ErrorCode::kDevice,
                      fmt::format("OpenNI2 does not start: {}", library->get_extended_error()));
  }
  library->is_started_ = true;
  return library;
}

bool Openni2Library::find_all() {
  const auto find = [this](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle_, name));
    return function != nullptr;
  };
  return find("oniInitialize", initialize_) && find("oniShutdown", shutdown_) &&
         find("oniGetExtendedError", get_extended_error) &&
         find("oniWaitForAnyStream", wait_for_any_stream) && find("oniDeviceOpen", device_open) &&
         find("oniDeviceClose", device_close) &&
         find("oniDeviceSetProperty", device_set_property) &&
         find("oniDeviceGetProperty", device_get_property) &&
         find("oniDeviceGetSensorInfo", device_get_sensor_info) &&
         find("oniDeviceCreateStream", device_create_stream) &&
         find("oniStreamDestroy", stream_destroy) && find("oniStreamStart", stream_start) &&
         find("oniStreamStop", stream_stop) && find("oniStreamReadFrame", stream_read_frame) &&
         find("oniStreamSetProperty", stream_set_property) &&
         find("oniStreamGetProperty", stream_get_property) &&
         find("oniFrameRelease", frame_release);
}

Openni2Library::~Openni2Library() {
  if (is_started_) shutdown_();
  if (handle_ != nullptr) dlclose(handle_);
}

}  // namespace mor::internal
