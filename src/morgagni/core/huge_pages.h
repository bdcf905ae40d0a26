// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <new>

namespace mor {

/// Asks the system for huge pages. It may have none, or give them to everybody unasked.
void ask_for_huge_pages(void* memory, std::size_t num_bytes);

/// Allocator of arrays of many megabytes. A CT of 512x512x275 lies on 36,000 ordinary pages, each
/// of which the system makes when it is touched first; in a virtual machine that took 0.4 s. Huge
/// ones are 70.
template <class T>
struct HugePages {
  using value_type = T;

  HugePages() = default;
  template <class Other>
  HugePages(const HugePages<Other>& /*other*/) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] T* allocate(std::size_t num) {
    void* memory = ::operator new(num * sizeof(T));
    ask_for_huge_pages(memory, num * sizeof(T));
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t /*num*/) { ::operator delete(memory); }
  bool operator==(const HugePages&) const = default;
};

}  // namespace mor
