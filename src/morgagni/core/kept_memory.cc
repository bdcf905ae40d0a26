// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/kept_memory.h"

#include <malloc.h>

namespace mor {

void keep_freed_memory() {
  constexpr int kLargestKept = 32 << 20;  // The most that glibc takes.
  constexpr int kMostKept = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kLargestKept);
  mallopt(M_TRIM_THRESHOLD, kMostKept);
}

}  // namespace mor
