// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <openni2/OniCAPI.h>

#include "morgagni/core/result.h"

namespace mor::internal {

/// OpenNI2, loaded when one of its cameras is asked for. It looks for its drivers in
/// OpenNI2/Drivers beside the file that was loaded.
class Openni2Library {
 public:
  /// Started until the last owner is gone. @param name  "libOpenNI2.so.0", or a path.
  /// @errors kNotFound: which package is missing; kDevice: its drivers do not start.
  [[nodiscard]] static Result<std::shared_ptr<const Openni2Library>> load(const std::string& name);
  Openni2Library(const Openni2Library&) = delete;
  Openni2Library& operator=(const Openni2Library&) = delete;
  ~Openni2Library();

  decltype(&::oniGetExtendedError) get_extended_error = nullptr;
  decltype(&::oniWaitForAnyStream) wait_for_any_stream = nullptr;
  decltype(&::oniDeviceOpen) device_open = nullptr;
  decltype(&::oniDeviceClose) device_close = nullptr;
  decltype(&::oniDeviceSetProperty) device_set_property = nullptr;
  decltype(&::oniDeviceGetProperty) device_get_property = nullptr;
  decltype(&::oniDeviceGetSensorInfo) device_get_sensor_info = nullptr;
  decltype(&::oniDeviceCreateStream) device_create_stream = nullptr;
  decltype(&::oniStreamDestroy) stream_destroy = nullptr;
  decltype(&::oniStreamStart) stream_start = nullptr;
  decltype(&::oniStreamStop) stream_stop = nullptr;
  decltype(&::oniStreamReadFrame) stream_read_frame = nullptr;
  decltype(&::oniStreamSetProperty) stream_set_property = nullptr;
  decltype(&::oniStreamGetProperty) stream_get_property = nullptr;
  decltype(&::oniFrameRelease) frame_release = nullptr;

 private:
  Openni2Library() = default;
  bool find_all();

  decltype(&::oniInitialize) initialize_ = nullptr;
  decltype(&::oniShutdown) shutdown_ = nullptr;
  void* handle_ = nullptr;
  bool is_started_ = false;
};

}  // namespace mor::internal
