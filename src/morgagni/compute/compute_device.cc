// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/compute/compute_device.h"

#include <algorithm>
#include <cctype>

#include <spdlog/fmt/fmt.h>

#include "morgagni/compute/internal/opencl.h"

namespace mor {
namespace {

ComputeDeviceType type_of(const cl::Device& device) {
  const auto type = device.getInfo<CL_DEVICE_TYPE>();
  if ((type & CL_DEVICE_TYPE_GPU) != 0) return ComputeDeviceType::kGpu;
  return (type & CL_DEVICE_TYPE_CPU) != 0 ? ComputeDeviceType::kCpu
                                          : ComputeDeviceType::kAccelerator;
}

/// Drivers pad their names, or end them with a zero.
std::string trimmed(std::string text) {
  const auto is_noise = [](unsigned char c) { return c == '\0' || std::isspace(c) != 0; };
  text.erase(std::find_if_not(text.rbegin(), text.rend(), is_noise).base(), text.end());
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), is_noise));
  return text;
}

bool can_be_used(const cl::Device& device) {
  return device.getInfo<CL_DEVICE_AVAILABLE>() != 0U &&
         device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>() != 0U;
}

ComputeDevice describe(const cl::Platform& platform, const cl::Device& device) {
  return {.name = trimmed(device.getInfo<CL_DEVICE_NAME>()),
          .platform = fmt::format("{} {}",
                                  trimmed(platform.getInfo<CL_PLATFORM_NAME>()),
                                  trimmed(device.getInfo<CL_DRIVER_VERSION>())),
          .type = type_of(device),
          .num_units = static_cast<int>(device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>()),
          .max_group_size = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>(),
          .memory_bytes = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>(),
          .has_double = device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0};
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return lower;
}

}  // namespace

std::string_view to_string(ComputeDeviceType type) {
  switch (type) {
    case ComputeDeviceType::kGpu:
      return "GPU";
    case ComputeDeviceType::kCpu:
      return "CPU";
    case ComputeDeviceType::kAccelerator:
      return "accelerator";
  }
  return "unknown";
}

std::vector<ComputeDevice> list_compute_devices() {
  std::vector<ComputeDevice> devices;
  for (auto& device : internal::find_opencl_devices()) devices.push_back(std::move(device.listed));
  return devices;
}

Result<std::size_t> choose_compute_device(const std::vector<ComputeDevice>& devices,
                                          std::string_view choice) {
  if (devices.empty()) {
    return make_error(
        ErrorCode::kNotFound,
        "there is no OpenCL device: install a driver (Debian: pocl-opencl-icd runs "
        "OpenCL on the CPU; nvidia-opencl-icd, intel-opencl-icd or mesa-opencl-icd on "
        "a GPU)");
  }
  if (choice == "opencl") return 0;
  std::string names;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!choice.empty() &&
        lower_case(devices[i].name).find(lower_case(choice)) != std::string::npos) {
      return i;
    }
    names += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", devices[i].name);
  }
  return make_error(
      ErrorCode::kInvalidArgument,
      fmt::format("no OpenCL device's name contains \"{}\"; there is {}", choice, names));
}

namespace internal {

std::vector<OpenclDevice> find_opencl_devices() {
  std::vector<cl::Platform> platforms;
  if (cl::Platform::get(&platforms) != CL_SUCCESS) return {};
  std::vector<OpenclDevice> found;
  for (const auto& platform : platforms) {
    std::vector<cl::Device> devices;
    if (platform.getDevices(CL_DEVICE_TYPE_ALL, &devices) != CL_SUCCESS) continue;
    for (const auto& device : devices) {
      if (can_be_used(device)) found.push_back({device, describe(platform, device)});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const OpenclDevice& a, const OpenclDevice& b) {
    return a.listed.type < b.listed.type;
  });
  return found;
}

std::string opencl_error_name(cl_int code) {
  const auto name = [code]() -> const char* {
    switch (code) {
      case CL_DEVICE_NOT_FOUND:
        return "CL_DEVICE_NOT_FOUND";
      case CL_DEVICE_NOT_AVAILABLE:
        return "CL_DEVICE_NOT_AVAILABLE";
      case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        return "CL_MEM_OBJECT_ALLOCATION_FAILURE";
      case CL_OUT_OF_RESOURCES:
        return "CL_OUT_OF_RESOURCES";
      case CL_OUT_OF_HOST_MEMORY:
        return "CL_OUT_OF_HOST_MEMORY";
      case CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST:
        return "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST";
      case CL_BUILD_PROGRAM_FAILURE:
        return "CL_BUILD_PROGRAM_FAILURE";
      case CL_INVALID_BUFFER_SIZE:
        return "CL_INVALID_BUFFER_SIZE";
      case CL_INVALID_COMMAND_QUEUE:
        return "CL_INVALID_COMMAND_QUEUE";
      case CL_INVALID_KERNEL_NAME:
        return "CL_INVALID_KERNEL_NAME";
      case CL_INVALID_KERNEL_ARGS:
        return "CL_INVALID_KERNEL_ARGS";
      case CL_INVALID_ARG_SIZE:
        return "CL_INVALID_ARG_SIZE";
      case CL_INVALID_WORK_GROUP_SIZE:
        return "CL_INVALID_WORK_GROUP_SIZE";
      default:
        return "OpenCL error";
    }
  }();
  return fmt::format("{} ({})", name, code);
}

Result<void> check_opencl(cl_int code, std::string_view what) {
  if (code == CL_SUCCESS) return {};
  return make_error(
      ErrorCode::kDevice,
      fmt::format("the OpenCL device failed to {}: {}", what, opencl_error_name(code)));
}

}  // namespace internal
}  // namespace mor
