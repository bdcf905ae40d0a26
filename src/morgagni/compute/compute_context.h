// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "morgagni/compute/compute_device.h"
#include "morgagni/core/result.h"

namespace mor {

namespace internal {
struct BufferImpl;
struct KernelImpl;
struct ProgramImpl;
struct ContextImpl;
}  // namespace internal

/// Memory on a device. Freed with the object.
class ComputeBuffer {
 public:
  ComputeBuffer();  ///< Of no bytes.
  explicit ComputeBuffer(std::unique_ptr<internal::BufferImpl> impl);
  ComputeBuffer(ComputeBuffer&&) noexcept;
  ComputeBuffer& operator=(ComputeBuffer&&) noexcept;
  ~ComputeBuffer();

  [[nodiscard]] std::size_t num_bytes() const;

 private:
  friend class ComputeContext;
  friend class ComputeKernel;
  std::unique_ptr<internal::BufferImpl> impl_;
};

/// A function that runs on the device, once for each work item.
class ComputeKernel {
 public:
  explicit ComputeKernel(std::unique_ptr<internal::KernelImpl> impl);
  ComputeKernel(ComputeKernel&&) noexcept;
  ComputeKernel& operator=(ComputeKernel&&) noexcept;
  ~ComputeKernel();

 private:
  friend class ComputeContext;
  [[nodiscard]] Result<void> set_argument(unsigned idx, const void* value, std::size_t num_bytes);
  [[nodiscard]] Result<void> set_argument(unsigned idx, const ComputeBuffer& buffer);

  std::unique_ptr<internal::KernelImpl> impl_;
};

/// Kernels compiled for a device.
class ComputeProgram {
 public:
  explicit ComputeProgram(std::unique_ptr<internal::ProgramImpl> impl);
  ComputeProgram(ComputeProgram&&) noexcept;
  ComputeProgram& operator=(ComputeProgram&&) noexcept;
  ~ComputeProgram();

  /// @errors kDevice: the program has no kernel of that name.
  [[nodiscard]] Result<ComputeKernel> kernel(const std::string& name) const;

 private:
  std::unique_ptr<internal::ProgramImpl> impl_;
};

/// How often a kernel runs: `num_items` work items in groups of `group_size`, which divides it.
struct WorkSize {
  std::size_t num_items = 0;
  std::size_t group_size = 1;

  /// At least `num_wanted` items, rounded up to whole groups.
  [[nodiscard]] static WorkSize at_least(std::size_t num_wanted, std::size_t group_size) {
    return {(num_wanted + group_size - 1) / group_size * group_size, group_size};
  }
};

/// One OpenCL device with its queue, which runs one thing after the other in the order asked for.
/// Every error here is kDevice unless said otherwise: the caller may go on without the device.
/// @threads One at a time.
class ComputeContext {
 public:
  /// @param choice  As choose_compute_device() has it. @errors Also that function's.
  [[nodiscard]] static Result<ComputeContext> open(std::string_view choice);
  ComputeContext(ComputeContext&&) noexcept;
  ComputeContext& operator=(ComputeContext&&) noexcept;
  ~ComputeContext();

  [[nodiscard]] const ComputeDevice& device() const;

  /// Compiles OpenCL C 1.2, with divisions and roots rounded as on the CPU where the device can.
  /// @errors Ends with the compiler's words.
  [[nodiscard]] Result<ComputeProgram> build(std::string_view source,
                                             const std::string& compiler_options) const;

  /// @param num_bytes  >= 1. What is in it at first is not defined.
  [[nodiscard]] Result<ComputeBuffer> allocate(std::size_t num_bytes) const;

  /// Returns when `values` may be changed again.
  template <class T>
  [[nodiscard]] Result<void> write(ComputeBuffer& buffer, std::span<const T> values) {
    return write_bytes(buffer, std::as_bytes(values));
  }

  /// Waits for all that was asked for before; its errors appear here as well.
  template <class T>
  [[nodiscard]] Result<void> read(const ComputeBuffer& buffer, std::span<T> values) {
    return read_bytes(buffer, std::as_writable_bytes(values));
  }

  /// Queues a kernel. @param arguments  Buffers and plain values, in the kernel's order.
  template <class... Arguments>
  [[nodiscard]] Result<void> run(ComputeKernel& kernel,
                                 const WorkSize& size,
                                 const Arguments&... arguments) {
    Result<void> set;
    unsigned idx = 0;
    ((set = set ? set_argument(kernel, idx++, arguments) : set), ...);
    MOR_CHECK(set);
    return enqueue(kernel, size);
  }

 private:
  explicit ComputeContext(std::unique_ptr<internal::ContextImpl> impl);

  template <class T>
  static Result<void> set_argument(ComputeKernel& kernel, unsigned idx, const T& argument) {
    if constexpr (std::is_same_v<T, ComputeBuffer>) {
      return kernel.set_argument(idx, argument);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      return kernel.set_argument(idx, &argument, sizeof(T));
    }
  }
  [[nodiscard]] Result<void> write_bytes(ComputeBuffer& buffer, std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> read_bytes(const ComputeBuffer& buffer, std::span<std::byte> bytes);
  [[nodiscard]] Result<void> enqueue(ComputeKernel& kernel, const WorkSize& size);

  std::unique_ptr<internal::ContextImpl> impl_;
};

}  // namespace mor
