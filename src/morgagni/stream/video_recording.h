// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "morgagni/core/result.h"

namespace mor {

/// Where a video of what is streamed goes.
struct VideoFiles {
  std::filesystem::path video;  ///< WebM: the VP8 pictures as they are sent, from a key picture on.
  /// One JSON object a line and picture, in the video's order: `picture` (from 0), `time_s` (in the
  /// video), `captured_at` (UTC), and what belongs to the picture (PictureInfo::json).
  std::filesystem::path pictures;
};

struct VideoStatus {
  bool is_running = false;
  double seconds = 0.0;
  std::uint64_t num_pictures = 0;
  std::uint64_t num_bytes = 0;  ///< Of VP8.
  int width_px = 0;
  int height_px = 0;
  std::string problem;  ///< Why it ended by itself, in one sentence. Empty: it did not.
};

/// Copies the pictures of a video that was not ended properly into a new one that has its duration
/// and can be wound. @return How many. @errors kIo: it cannot be read or written; nothing is left
/// of the new one then.
[[nodiscard]] Result<std::uint64_t> repair_video(const std::filesystem::path& from,
                                                 const std::filesystem::path& to);

}  // namespace mor
