// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"

namespace mor {

enum class ComputeDeviceType : std::uint8_t { kGpu, kCpu, kAccelerator };

/// "GPU", "CPU", "accelerator".
[[nodiscard]] std::string_view to_string(ComputeDeviceType type);

/// An OpenCL device of this machine.
struct ComputeDevice {
  std::string name = {};
  std::string platform = {};  ///< Its driver's name and version.
  ComputeDeviceType type = ComputeDeviceType::kGpu;
  int num_units = 0;               ///< Compute units: cores of a CPU, multiprocessors of a GPU.
  std::size_t max_group_size = 0;  ///< Work items that can share local memory.
  std::uint64_t memory_bytes = 0;
  bool has_double = false;  ///< Computes in 64-bit floating point.
};

/// The devices that can be used, GPUs before CPUs; empty where no OpenCL driver is installed.
[[nodiscard]] std::vector<ComputeDevice> list_compute_devices();

/// Which of `devices` a user means: "opencl" is the first, anything else a part of a device's name,
/// upper and lower case alike. @return Its place among `devices`.
/// @errors kNotFound: there is no device at all; says what to install. kInvalidArgument: no name
///         contains `choice`; lists those there are.
[[nodiscard]] Result<std::size_t> choose_compute_device(const std::vector<ComputeDevice>& devices,
                                                        std::string_view choice);

}  // namespace mor
