// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/huge_pages.h"

#include <cstdint>

#include <sys/mman.h>

namespace mor {

void ask_for_huge_pages(void* memory, std::size_t num_bytes) {
  constexpr std::size_t kLeastBytes = 4 << 20;
  constexpr std::uintptr_t kPageBytes = 4096;
  if (num_bytes < kLeastBytes) return;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const auto first_page = (begin + kPageBytes - 1) / kPageBytes * kPageBytes;
  // Where the system refuses, the pages stay ordinary ones.
  (void)::madvise(
      reinterpret_cast<void*>(first_page), begin + num_bytes - first_page, MADV_HUGEPAGE);
}

}  // namespace mor
