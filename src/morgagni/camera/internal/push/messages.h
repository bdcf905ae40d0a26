// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "morgagni/core/result.h"
#include "morgagni/geometry/pinhole_camera.h"

/// What a device sends: ROS 2 messages of strangers' making, as CDR bytes or as JSON.
namespace mor::internal::push {

/// `sensor_msgs/Image` or `CompressedImage`, still packed.
struct Picture {
  std::uint64_t stamp_ns = 0;
  std::string frame = {};
  bool is_compressed = false;
  std::string encoding = {};  ///< "16UC1", "rgb8"; of a compressed one its format, "jpeg".
  std::uint32_t width_px = 0, height_px = 0, row_bytes = 0;  ///< Not of a compressed one.
  bool is_big_endian = false;
  std::vector<std::byte> data = {};
};

/// `sensor_msgs/CameraInfo`. One without distortion, or with that of Brown and Conrady.
struct CameraInfo {
  std::string frame;
  PinholeCamera as_seen = {};                   ///< K and D: of image_raw.
  std::optional<PinholeCamera> rectified = {};  ///< P: of image_rect. None: P was not given.
};

/// One of a `tf2_msgs/TFMessage`.
struct Transform {
  std::string parent;
  std::string child;
  Eigen::Isometry3d parent_from_child = Eigen::Isometry3d::Identity();  ///< mm.
};

using Message = std::variant<Picture, CameraInfo, std::vector<Transform>>;

enum class MessageKind : std::uint8_t { kImage, kCompressedImage, kCameraInfo, kTransforms };
enum class Encoding : std::uint8_t { kCdr, kJson };

/// By its name, "sensor_msgs/msg/Image" or "sensor_msgs/Image". None: another.
[[nodiscard]] std::optional<MessageKind> message_kind(std::string_view schema_name);

/// @errors kInvalidArgument: cut short, a number that is none, a lens model that is not known;
///         names the member.
[[nodiscard]] Result<Message> parse_message(MessageKind kind,
                                            Encoding encoding,
                                            std::span<const std::byte> bytes);

// What both encodings come to, checked.
struct RawCameraInfo {
  std::string frame;
  std::uint32_t width_px = 0, height_px = 0;
  std::string lens_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 12> p{};
  bool is_part = false;  ///< Binned, or a region of the sensor alone.
};
[[nodiscard]] Result<CameraInfo> checked(const RawCameraInfo& raw);
/// @param position_m  Of the child in the parent. @param xyzw  Quaternion, of length 1 or nearly.
[[nodiscard]] Result<Transform> checked(std::string parent,
                                        std::string child,
                                        const Eigen::Vector3d& position_m,
                                        const Eigen::Vector4d& xyzw);

[[nodiscard]] Result<Message> parse_cdr(MessageKind kind, std::span<const std::byte> bytes);
[[nodiscard]] Result<Message> parse_json(MessageKind kind, std::span<const std::byte> bytes);

}  // namespace mor::internal::push
