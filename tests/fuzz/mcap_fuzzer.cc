// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// A recording: opened, and every frame and pose of it read.
#include "morgagni/camera/mcap_recording.h"

#include "surroundings.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto path = mor::fuzz::write("input.mcap", std::as_bytes(std::span(data, size)));
  const auto recording = mor::McapRecording::open(path);
  if (!recording) return 0;
  for (std::size_t i = 0; i < recording->size(); ++i) {
    (void)recording->read(i);
    (void)recording->pose(i);
    (void)recording->since_start(i);
    (void)recording->wall_time(i);
  }
  return 0;
}
