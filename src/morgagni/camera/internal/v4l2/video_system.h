// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

#include <poll.h>

namespace mor::internal {

/// The kernel's calls that a video device is used by. Tests put a kernel of their own here. Each
/// does and returns what the call of its name does, with errno.
class VideoSystem {
 public:
  VideoSystem() = default;
  virtual ~VideoSystem() = default;
  VideoSystem(const VideoSystem&) = delete;
  VideoSystem& operator=(const VideoSystem&) = delete;

  [[nodiscard]] virtual int open(const char* path) const;  ///< To read and write, not blocking.
  virtual int close(int file) const;
  [[nodiscard]] virtual int ioctl(int file, unsigned long request, void* argument) const;
  /// Shared, to read. @return MAP_FAILED where it failed.
  [[nodiscard]] virtual void* map(std::size_t size, int file, std::size_t offset) const;
  virtual int unmap(void* at, std::size_t size) const;
  [[nodiscard]] virtual int poll(pollfd* files, nfds_t count, int timeout_ms) const;
};

[[nodiscard]] std::shared_ptr<const VideoSystem> real_video_system();

}  // namespace mor::internal
