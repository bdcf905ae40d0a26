// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"

/// ROS 2 messages as CDR bytes. ROS measures in metres, images of encoding 16UC1 in millimetres.
namespace mor::internal::ros {

struct Header {
  std::uint64_t stamp_ns = 0;  ///< Since 1970.
  std::string_view frame;
};

using Bytes = std::vector<std::byte>;

[[nodiscard]] Bytes encode_depth(const Header& header, ImageView<const std::uint16_t> depth_mm);
/// @param format  "jpeg", "png".
[[nodiscard]] Bytes encode_compressed(const Header& header,
                                      std::string_view format,
                                      std::span<const std::byte> picture);
[[nodiscard]] Bytes encode_camera_info(const Header& header, const PinholeCamera& camera);
/// What another clock, that of the device, says at the header's time.
[[nodiscard]] Bytes encode_time_reference(const Header& header,
                                          std::uint64_t other_ns,
                                          std::string_view source);
/// @param child  Frame whose points `parent_from_child` (mm) takes to the header's frame.
[[nodiscard]] Bytes encode_transform(const Header& header,
                                     std::string_view child,
                                     const Eigen::Isometry3d& parent_from_child);

enum class Level : std::uint8_t { kOk = 0, kWarn = 1, kError = 2 };

struct Diagnostic {
  Level level = Level::kOk;
  std::string name;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};
[[nodiscard]] Bytes encode_diagnostic(const Header& header, const Diagnostic& diagnostic);

// Of a stranger's making. @errors kInvalidArgument: cut short, or not what it should be.
[[nodiscard]] Result<Image<std::uint16_t>> decode_depth(std::span<const std::byte> message);
/// Unpacks JPEG and PNG.
[[nodiscard]] Result<Image<Rgb8>> decode_color(std::span<const std::byte> message);
[[nodiscard]] Result<Diagnostic> decode_diagnostic(std::span<const std::byte> message);
[[nodiscard]] Result<std::uint64_t> decode_time_reference(std::span<const std::byte> message);

}  // namespace mor::internal::ros
