// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/ros/schemas.h"

#include <initializer_list>

namespace mor::internal::ros {
namespace {

struct Part {
  std::string_view name;
  std::string_view fields;
};

constexpr Part kTime = {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"};
constexpr Part kHeader = {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"};
constexpr Part kRegion = {
    "sensor_msgs/RegionOfInterest",
    "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"};
constexpr Part kTransformStamped = {
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"};
constexpr Part kTransform = {
    "geometry_msgs/Transform",
    "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"};
constexpr Part kVector = {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"};
constexpr Part kQuaternion = {"geometry_msgs/Quaternion",
                              "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"};
constexpr Part kStatus = {
    "diagnostic_msgs/DiagnosticStatus",
    "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n"
    "string hardware_id\ndiagnostic_msgs/KeyValue[] values\n"};
constexpr Part kKeyValue = {"diagnostic_msgs/KeyValue", "string key\nstring value\n"};

Schema schema(std::string_view name, std::string_view fields, std::initializer_list<Part> parts) {
  std::string text(fields);
  for (const auto& part : parts) {
    text += std::string(80, '=') + "\nMSG: " + std::string(part.name) + "\n";
    text += part.fields;
  }
  return {name, std::move(text)};
}

}  // namespace

Schema image_schema() {
  return schema("sensor_msgs/msg/Image",
                "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
                "uint8 is_bigendian\nuint32 step\nuint8[] data\n",
                {kHeader, kTime});
}

Schema compressed_image_schema() {
  return schema("sensor_msgs/msg/CompressedImage",
                "std_msgs/Header header\nstring format\nuint8[] data\n",
                {kHeader, kTime});
}

Schema camera_info_schema() {
  return schema("sensor_msgs/msg/CameraInfo",
                "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
                "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n"
                "uint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
                {kHeader, kTime, kRegion});
}

Schema time_reference_schema() {
  return schema("sensor_msgs/msg/TimeReference",
                "std_msgs/Header header\nbuiltin_interfaces/Time time_ref\nstring source\n",
                {kHeader, kTime});
}

Schema transforms_schema() {
  return schema("tf2_msgs/msg/TFMessage",
                "geometry_msgs/TransformStamped[] transforms\n",
                {kTransformStamped, kTransform, kVector, kQuaternion, kHeader, kTime});
}

Schema diagnostics_schema() {
  return schema("diagnostic_msgs/msg/DiagnosticArray",
                "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
                {kStatus, kKeyValue, kHeader, kTime});
}

}  // namespace mor::internal::ros
