// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace mor::internal::ros {

/// A ROS 2 message type: its name and, as a `ros2msg` schema has it, its definition followed by
/// those of the types within.
struct Schema {
  std::string_view name;
  std::string text;
};

[[nodiscard]] Schema image_schema();
[[nodiscard]] Schema compressed_image_schema();
[[nodiscard]] Schema camera_info_schema();
[[nodiscard]] Schema time_reference_schema();
[[nodiscard]] Schema transforms_schema();
[[nodiscard]] Schema diagnostics_schema();

}  // namespace mor::internal::ros
