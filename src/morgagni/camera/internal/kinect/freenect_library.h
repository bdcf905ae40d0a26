// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include <libfreenect.h>
#include <libfreenect_registration.h>

#include "morgagni/core/result.h"

namespace mor::internal {

/// libfreenect, loaded when a Kinect is asked for: who has none needs no package. The player of
/// dumps, fakenect, is a library of the same functions.
class FreenectLibrary {
 public:
  /// @param name  "libfreenect.so.0.5", or a path. @errors kNotFound: which package is missing.
  [[nodiscard]] static Result<std::shared_ptr<const FreenectLibrary>> load(const std::string& name);
  FreenectLibrary(const FreenectLibrary&) = delete;
  FreenectLibrary& operator=(const FreenectLibrary&) = delete;
  ~FreenectLibrary();

  decltype(&::freenect_init) init = nullptr;
  decltype(&::freenect_shutdown) shutdown = nullptr;
  decltype(&::freenect_set_log_level) set_log_level = nullptr;
  decltype(&::freenect_select_subdevices) select_subdevices = nullptr;
  decltype(&::freenect_num_devices) num_devices = nullptr;
  decltype(&::freenect_open_device) open_device = nullptr;
  decltype(&::freenect_close_device) close_device = nullptr;
  decltype(&::freenect_set_depth_callback) set_depth_callback = nullptr;
  decltype(&::freenect_set_video_callback) set_video_callback = nullptr;
  decltype(&::freenect_find_depth_mode) find_depth_mode = nullptr;
  decltype(&::freenect_find_video_mode) find_video_mode = nullptr;
  decltype(&::freenect_set_depth_mode) set_depth_mode = nullptr;
  decltype(&::freenect_set_video_mode) set_video_mode = nullptr;
  decltype(&::freenect_start_depth) start_depth = nullptr;
  decltype(&::freenect_start_video) start_video = nullptr;
  decltype(&::freenect_stop_depth) stop_depth = nullptr;
  decltype(&::freenect_stop_video) stop_video = nullptr;
  decltype(&::freenect_process_events_timeout) process_events_timeout = nullptr;
  // fakenect lacks them.
  decltype(&::freenect_copy_registration) copy_registration = nullptr;
  decltype(&::freenect_destroy_registration) destroy_registration = nullptr;
  decltype(&::freenect_list_device_attributes) list_device_attributes = nullptr;
  decltype(&::freenect_free_device_attributes) free_device_attributes = nullptr;

 private:
  FreenectLibrary() = default;
  void* handle_ = nullptr;
};

}  // namespace mor::internal
