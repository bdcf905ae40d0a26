// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Reads a CT that nobody vouches for and hands it to the process that started it. See
// morgagni/ct/import_protocol.h.
#include <cstdio>
#include <exception>
#include <filesystem>

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "dicom_folder.h"
#include "image_file.h"
#include "messages.h"

namespace {

using mor::Result;
using mor::import::ImportedVolume;

/// The file's parser may want any amount of memory and time: this is what it gets.
void set_limits() {
  const auto limit = [](auto resource, rlim_t value) {
    const rlimit both = {value, value};
    (void)::setrlimit(resource, &both);
  };
  constexpr rlim_t kMaxCpuSeconds = 300;
  limit(RLIMIT_CPU, kMaxCpuSeconds);
  limit(RLIMIT_CORE, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // A sanitizer reserves terabytes of addresses for itself.
  constexpr rlim_t kMaxMemoryBytes = rlim_t{7} << 30;
  limit(RLIMIT_AS, kMaxMemoryBytes);
#endif
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
}

Result<ImportedVolume> read_any(const std::filesystem::path& path) {
  try {
    if (std::filesystem::is_directory(path)) return mor::import::read_dicom_folder(path);
    return mor::import::read_image_file(path);
  } catch (const std::bad_alloc&) {
    return mor::make_error(mor::ErrorCode::kIo,
                           path.string() +
                               " asks for more memory than an import may use: it is "
                               "damaged or too large");
  } catch (const std::exception& failure) {
    return mor::make_error(mor::ErrorCode::kIo,
                           path.string() + " cannot be read: " + failure.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  struct stat info {};
  if (argc != 2 || ::fstat(mor::kImportVoxelsFd, &info) != 0) {
    std::fputs("morgagni-import is started by morgagni, it is of no use alone.\n", stderr);
    return 2;
  }
  set_limits();
  const auto volume = read_any(argv[1]);
  if (!volume) {
    mor::import::say_error(volume.error());
    return 1;
  }
  if (const auto handed = mor::import::hand_over(*volume); !handed) {
    mor::import::say_error(handed.error());
    return 1;
  }
  return 0;
}
