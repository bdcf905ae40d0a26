// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Writes what fuzzing begins with, the small whole files of the tests: FOLDER/FORMAT/NAME.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "morgagni/camera/internal/ros/messages.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/core/image_png.h"
#include "morgagni/ct/testing/sample_files.h"

namespace {

namespace fs = std::filesystem;

/// The same slice through the tools that compress for an archive; without a tool without its seed.
void compress(const fs::path& slice) {
  struct Tool {
    const char* name;
    const char* command;
  };
  for (const Tool& tool : {Tool{"rle", "dcmcrle"},
                           Tool{"jpeg", "dcmcjpeg +e1"},
                           Tool{"jpeg_ls", "dcmcjpls +el"},
                           Tool{"jpeg_2000", "gdcmconv --j2k"}}) {
    const auto to = slice.parent_path() / (std::string(tool.name) + ".dcm");
    const std::string command = std::string(tool.command) + " '" + slice.string() + "' '" +
                                to.string() + "' >/dev/null 2>&1";
    if (std::system(command.c_str()) != 0) std::printf("no seed %s\n", tool.name);
  }
}

void record(const fs::path& path, mor::ColorCoding color) {
  if (const auto done = mor::internal::record_samples(path, 3, {.color = color}); !done)
    std::printf("no seed %s: %s\n", path.c_str(), done.error().message.c_str());
}

/// What a device pushes, behind the byte that push_fuzzer.cc reads first.
void push(const fs::path& folder,
          const char* name,
          char kind,
          const std::vector<std::byte>& message) {
  std::ofstream out(folder / name, std::ios::binary);
  out.put(kind);
  out.write(reinterpret_cast<const char*>(message.data()),
            static_cast<std::streamsize>(message.size()));
}

void push_all(const fs::path& folder) {
  namespace ros = mor::internal::ros;
  fs::create_directories(folder);
  const ros::Header header{1'000'000'002, "camera"};
  const mor::Image<std::uint16_t> depth(8, 6, 700);
  push(folder, "depth", 0, ros::encode_depth(header, depth.view()));
  push(folder, "png", 1, ros::encode_compressed(header, "png", mor::encode_png(depth.view())));
  push(folder,
       "info",
       2,
       ros::encode_camera_info(header, mor::internal::sample_calibration()->depth));
  push(folder,
       "transform",
       3,
       ros::encode_transform(header, "depth", Eigen::Isometry3d::Identity()));
  std::ofstream(folder / "advertise")
      << '\x08' << R"({"op":"advertise","channels":[{"id":1,"topic":"/a",
"encoding":"cdr","schemaName":"sensor_msgs/msg/Image"}]})";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_seeds FOLDER\n", stderr);
    return 2;
  }
  const fs::path folder = argv[1];
  for (const char* format : {"dicom", "nifti", "nrrd", "mha", "ply", "stl", "obj"}) {
    fs::create_directories(folder / format);
    for (const auto& file : mor::testing_files::sample_files(format))
      std::ofstream(folder / format / file.name, std::ios::binary) << file.bytes;
  }
  compress(folder / "dicom" / "explicit.dcm");
  push_all(folder / "push");
  fs::create_directories(folder / "mcap");
  record(folder / "mcap" / "jpeg.mcap", mor::ColorCoding::kJpeg);
  record(folder / "mcap" / "lossless.mcap", mor::ColorCoding::kLossless);
  return 0;
}
