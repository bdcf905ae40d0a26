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
#include "morgagni/ct/testing/dicom_writer.h"
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
                           Tool{"jpeg_lossy_12", "dcmcjpeg +ee"},
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

/// What a PACS answers, behind the byte that pacs_fuzzer.cc reads first.
void answer_all(const fs::path& folder) {
  fs::create_directories(folder);
  const auto answer = [&](const char* name, unsigned char kind, const std::string& text) {
    for (const unsigned char piece : {1, 63}) {
      std::ofstream out(folder / (name + std::to_string(piece)), std::ios::binary);
      out.put(static_cast<char>(piece << 2U | kind));
      out << text;
    }
  };
  const auto slice = mor::testing_files::sample_files("dicom").front().bytes;
  answer("multipart",
         0,
         "multipart/related; type=\"application/dicom\"; boundary=\"b\"\npreamble\r\n--b\r\n"
         "Content-Type: application/dicom\r\n\r\n" +
             slice + "\r\n--b \r\n\r\nmore\r\n--b--\r\nepilogue");
  answer("json",
         1,
         R"([{"0020000D":{"vr":"UI","Value":["1.2.3"]},"00100010":{"vr":"PN","Value":)"
         R"([{"Alphabetic":"A^B"}]},"00201209":{"vr":"IS","Value":[138]},"00081030":)"
         R"({"vr":"LO"},"00080061":{"vr":"CS","Value":["CT","SEG",1.5,null]}},{}])");
  answer("dimse",
         2,
         "{\"match\":{\"0020000D\":\"1.2.3\",\"00080061\":\"CT\\\\MR\"}}\n"
         "{\"stored\":{\"file\":\"a.dcm\",\"bytes\":5,\"tags\":{\"00080018\":\"1.2\"}}}\n"
         "{\"caller\":\"MODALITY\"}\n{\"refused\":\"too large\"}\n"
         "{\"failed\":\"no route\",\"code\":2}\n{\"done\":3}\n");
  answer("part10", 3, slice);
}

/// Several files as one, and a file that names others.
void bundle(const fs::path& folder) {
  mor::testing_dicom::DicomWriter record;
  record.text(0x0004'1500, "CS", "SERIES\\0");
  mor::testing_dicom::DicomWriter directory;
  directory.sequence(0x0004'1220, {record.data()});
  std::ofstream(folder / "directory", std::ios::binary) << directory.file();
  const std::string zip = (folder / "archive.zip").string();
  const std::string command = "cd '" + folder.string() + "' && rm -f '" + zip + "' && zip -q '" +
                              zip + "' explicit.dcm implicit.dcm big_endian.dcm >/dev/null 2>&1";
  if (std::system(command.c_str()) != 0) std::printf("no seed archive.zip\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_seeds FOLDER\n", stderr);
    return 2;
  }
  const fs::path folder = argv[1];
  for (const char* format :
       {"dicom", "nifti", "nrrd", "mha", "ply", "stl", "obj", "vtp", "rtstruct"}) {
    fs::create_directories(folder / format);
    for (const auto& file : mor::testing_files::sample_files(format))
      std::ofstream(folder / format / file.name, std::ios::binary) << file.bytes;
  }
  compress(folder / "dicom" / "explicit.dcm");
  bundle(folder / "dicom");
  push_all(folder / "push");
  answer_all(folder / "pacs");
  fs::create_directories(folder / "mcap");
  record(folder / "mcap" / "jpeg.mcap", mor::ColorCoding::kJpeg);
  record(folder / "mcap" / "lossless.mcap", mor::ColorCoding::kLossless);
  return 0;
}
