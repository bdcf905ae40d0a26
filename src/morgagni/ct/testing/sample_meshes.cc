// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// A tetrahedron as PLY, STL and OBJ, and a box as VTP.
#include <array>
#include <cstdint>

#include "morgagni/ct/testing/sample_parts.h"
#include "morgagni/ct/testing/vtp_writer.h"

namespace mor::testing_files {
namespace {

constexpr std::array<std::array<float, 3>, 4> kCorners = {
    {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}};
constexpr std::array<std::array<std::uint32_t, 3>, 4> kFaces = {
    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

}  // namespace

std::vector<SampleFile> ply_samples() {
  const std::string counts =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\ncomment SPACE=RAS\n" + counts;
  std::string text = "ply\nformat ascii 1.0\n" + counts;
  for (const auto& corner : kCorners) {
    append(binary, corner);
    for (const float value : corner) text += std::to_string(value) + ' ';
    text += '\n';
  }
  for (const auto& face : kFaces) {
    append(binary, std::uint8_t{3});
    append(binary, face);
    text += '3';
    for (const auto corner : face) text += ' ' + std::to_string(corner);
    text += '\n';
  }
  const std::string rich =
      "ply\r\nformat ascii 1.0\r\nobj_info made\r\nelement vertex 4\r\nproperty double x\r\n"
      "property double y\r\nproperty double z\r\nproperty float nx\r\nproperty float ny\r\n"
      "property float nz\r\nproperty uchar red\r\nelement other 1\r\nproperty list int float a\r\n"
      "element face 1\r\nproperty short b\r\nproperty list ushort uint vertex_index\r\n"
      "end_header\r\n0 0 0 0 0 1 9\r\n1 0 0 0 0 1 9\r\n1 1 0 0 0 1 9\r\n0 1 0 0 0 1 9\r\n"
      "2 0.5 1e3\r\n7 3 0 1 2\r\n";
  return {{"binary.ply", binary}, {"text.ply", text}, {"rich.ply", rich}};
}

std::vector<SampleFile> stl_samples() {
  std::string binary(80, ' ');
  append(binary, std::uint32_t{kFaces.size()});
  std::string text = "solid made\n";
  for (const auto& face : kFaces) {
    append(binary, std::array<float, 3>{0, 0, 1});
    text += "facet normal 0 0 1\n outer loop\n";
    for (const auto corner : face) {
      append(binary, kCorners[corner]);
      text += "  vertex";
      for (const float value : kCorners[corner]) text += ' ' + std::to_string(value);
      text += '\n';
    }
    append(binary, std::uint16_t{0});
    text += " endloop\nendfacet\n";
  }
  std::string colored = binary;
  colored.replace(0, 10, "COLOR=\xff\x80\x40\xff");
  colored[colored.size() - 1] = '\x80';
  return {{"binary.stl", binary},
          {"colored.stl", colored},
          {"text.stl", text + "endsolid made\n"},
          {"two.stl", text + "endsolid made\n" + text + "endsolid\n"},
          {"unended.stl", text}};
}

std::vector<SampleFile> obj_samples() {
  std::string plain = "# SPACE=LPS\no made\n";
  for (const auto& corner : kCorners) {
    plain += "v";
    for (const float value : corner) plain += ' ' + std::to_string(value);
    plain += '\n';
  }
  std::string with_normals = plain + "vn 0 0 1\nvt 0.5 0.5\ng part\nusemtl skin\n";
  for (const auto& face : kFaces) {
    plain += 'f';
    with_normals += 'f';
    for (const auto corner : face) {
      plain += ' ' + std::to_string(corner + 1);
      with_normals += ' ' + std::to_string(corner + 1) + "/1/1";
    }
    plain += '\n';
    with_normals += '\n';
  }
  const std::string rich =
      "mtllib gone.mtl\nv 0 0 0 1 0.5 0.25\nv 1 0 0 1 0.5 0.25\nv 1 1 0 1 0 0\nv 0 1e0 0 0 1 1\n"
      "vt 0 0 0\nvt 1\nvn 0 0 1\ns 1\ng a b\nf -4/-2/-1 -3//1 -2/1 \\\n -1\ns off\no two\n"
      "usemtl none\nf 1 2 3\r\nl 1 2 3\np 1 4\n";
  const std::string curved =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nvp 0 0\ncstype bspline\ndeg 2\ncurv 0 1 1 2 3\n"
      "parm u 0 0 0 1 1 1\nend\nf 1 2 3\n";
  return {{"plain.obj", plain},
          {"normals.obj", with_normals},
          {"rich.obj", rich},
          {"curved.obj", curved}};
}

std::vector<SampleFile> vtp_samples() {
  std::vector<SampleFile> files;
  const auto add = [&](const char* name, const VtpStyle& style) {
    files.push_back({std::string(name) + ".vtp", box_vtp_file(style)});
  };
  add("text", {});
  add("letters", {.format = "binary"});
  add("packed_letters", {.format = "binary", .compressed = true, .wide_heads = true});
  add("raw", {.format = "appended", .wide_heads = true});
  add("packed_raw", {.format = "appended", .compressed = true});
  add("big_endian", {.format = "appended", .big_endian = true});
  add("appended_letters", {.format = "appended", .encoding = "base64", .compressed = true});
  return files;
}

}  // namespace mor::testing_files
