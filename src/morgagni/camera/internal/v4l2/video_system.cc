// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/v4l2/video_system.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace mor::internal {

int VideoSystem::open(const char* path) const {
  return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
}
int VideoSystem::close(int file) const {
  return ::close(file);
}
int VideoSystem::ioctl(int file, unsigned long request, void* argument) const {
  return ::ioctl(file, request, argument);
}
void* VideoSystem::map(std::size_t size, int file, std::size_t offset) const {
  return ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file, static_cast<off_t>(offset));
}
int VideoSystem::unmap(void* at, std::size_t size) const {
  return ::munmap(at, size);
}
int VideoSystem::poll(pollfd* files, nfds_t count, int timeout_ms) const {
  return ::poll(files, count, timeout_ms);
}

std::shared_ptr<const VideoSystem> real_video_system() {
  return std::make_shared<const VideoSystem>();
}

}  // namespace mor::internal
