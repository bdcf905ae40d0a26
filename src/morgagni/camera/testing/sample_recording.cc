// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Writes a recording for the test that reads it with what Foxglove reads recordings with, or reads
// one that they wrote: sample_recording write|read FILE.

#include "morgagni/camera/testing/sample_recording.h"

#include <iostream>
#include <string>

#include "morgagni/camera/mcap_recording.h"

namespace {

constexpr std::uint64_t kNumFrames = 12;

mor::Result<void> run(const std::string& verb, const std::filesystem::path& path) {
  if (verb == "write") {
    return mor::internal::record_samples(
        path, kNumFrames, {.color = mor::ColorCoding::kLossless, .about = {{"case", "sample"}}});
  }
  MOR_TRY(const auto recording, mor::McapRecording::open(path));
  for (std::size_t i = 0; i < kNumFrames; ++i) {
    MOR_TRY(const auto frame, recording.read(i));
    const auto written = mor::internal::sample_frame(i);
    if (frame->depth_mm != written.depth_mm || frame->color != written.color) {
      return mor::make_error(mor::ErrorCode::kInternal,
                             "frame " + std::to_string(i) + " is another");
    }
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  if (const auto done = run(argv[1], argv[2]); !done) {
    std::cerr << done.error().message << "\n";
    return 1;
  }
  return 0;
}
