// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_TARGET_OPENCL_VERSION 120
#include <string_view>
#include <vector>

#include <CL/opencl.hpp>

#include "morgagni/compute/compute_device.h"

namespace mor::internal {

/// A device as OpenCL has it, and as we list it.
struct OpenclDevice {
  cl::Device handle;
  ComputeDevice listed;
};

/// In the order of list_compute_devices().
[[nodiscard]] std::vector<OpenclDevice> find_opencl_devices();

/// "CL_OUT_OF_RESOURCES (-5)".
[[nodiscard]] std::string opencl_error_name(cl_int code);

/// @errors kDevice: `code` is not CL_SUCCESS; `what` could not be done on the device.
[[nodiscard]] Result<void> check_opencl(cl_int code, std::string_view what);

}  // namespace mor::internal
