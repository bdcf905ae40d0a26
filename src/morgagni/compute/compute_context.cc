// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/compute/compute_context.h"

#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/compute/internal/opencl.h"

namespace mor {
namespace internal {

struct BufferImpl {
  cl::Buffer buffer;
  std::size_t num_bytes = 0;
};

struct KernelImpl {
  cl::Kernel kernel;
  std::string name;
};

struct ProgramImpl {
  cl::Program program;
};

struct ContextImpl {
  OpenclDevice device;
  cl::Context context;
  cl::CommandQueue queue;
};

}  // namespace internal

using internal::check_opencl;

ComputeBuffer::ComputeBuffer() = default;
ComputeBuffer::ComputeBuffer(std::unique_ptr<internal::BufferImpl> impl) : impl_(std::move(impl)) {}
ComputeBuffer::ComputeBuffer(ComputeBuffer&&) noexcept = default;
ComputeBuffer& ComputeBuffer::operator=(ComputeBuffer&&) noexcept = default;
ComputeBuffer::~ComputeBuffer() = default;

std::size_t ComputeBuffer::num_bytes() const {
  return impl_ ? impl_->num_bytes : 0;
}

ComputeKernel::ComputeKernel(std::unique_ptr<internal::KernelImpl> impl) : impl_(std::move(impl)) {}
ComputeKernel::ComputeKernel(ComputeKernel&&) noexcept = default;
ComputeKernel& ComputeKernel::operator=(ComputeKernel&&) noexcept = default;
ComputeKernel::~ComputeKernel() = default;

Result<void> ComputeKernel::set_argument(unsigned idx, const void* value, std::size_t num_bytes) {
  return check_opencl(impl_->kernel.setArg(idx, num_bytes, value),
                      fmt::format("take argument {} of {}", idx, impl_->name));
}

Result<void> ComputeKernel::set_argument(unsigned idx, const ComputeBuffer& buffer) {
  const cl_mem handle = buffer.impl_ ? buffer.impl_->buffer() : nullptr;
  return set_argument(idx, &handle, sizeof(handle));
}

ComputeProgram::ComputeProgram(std::unique_ptr<internal::ProgramImpl> impl)
    : impl_(std::move(impl)) {}
ComputeProgram::ComputeProgram(ComputeProgram&&) noexcept = default;
ComputeProgram& ComputeProgram::operator=(ComputeProgram&&) noexcept = default;
ComputeProgram::~ComputeProgram() = default;

Result<ComputeKernel> ComputeProgram::kernel(const std::string& name) const {
  cl_int status = CL_SUCCESS;
  cl::Kernel kernel(impl_->program, name.c_str(), &status);
  MOR_CHECK(check_opencl(status, fmt::format("find the kernel {}", name)));
  return ComputeKernel(
      std::make_unique<internal::KernelImpl>(internal::KernelImpl{std::move(kernel), name}));
}

ComputeContext::ComputeContext(std::unique_ptr<internal::ContextImpl> impl)
    : impl_(std::move(impl)) {}
ComputeContext::ComputeContext(ComputeContext&&) noexcept = default;
ComputeContext& ComputeContext::operator=(ComputeContext&&) noexcept = default;
ComputeContext::~ComputeContext() = default;

Result<ComputeContext> ComputeContext::open(std::string_view choice) {
  auto found = internal::find_opencl_devices();
  std::vector<ComputeDevice> listed;
  for (const auto& device : found) listed.push_back(device.listed);
  MOR_TRY(const auto chosen, choose_compute_device(listed, choice));
  auto impl = std::make_unique<internal::ContextImpl>();
  impl->device = std::move(found[chosen]);
  cl_int status = CL_SUCCESS;
  impl->context = cl::Context(impl->device.handle, nullptr, nullptr, nullptr, &status);
  MOR_CHECK(check_opencl(status, "make a context"));
  impl->queue = cl::CommandQueue(impl->context, impl->device.handle, 0, &status);
  MOR_CHECK(check_opencl(status, "make a queue"));
  return ComputeContext(std::move(impl));
}

const ComputeDevice& ComputeContext::device() const {
  return impl_->device.listed;
}

Result<ComputeProgram> ComputeContext::build(std::string_view source,
                                             const std::string& compiler_options) const {
  cl_int status = CL_SUCCESS;
  cl::Program program(impl_->context, std::string(source), /*build=*/false, &status);
  MOR_CHECK(check_opencl(status, "take the kernels' text"));
  const std::vector<cl::Device> devices = {impl_->device.handle};
  std::string options = "-cl-std=CL1.2 " + compiler_options;
  const auto can_do = devices.front().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
  if ((can_do & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0) {
    options += " -cl-fp32-correctly-rounded-divide-sqrt";
  }
  if (const auto built = check_opencl(program.build(devices, options.c_str()), "compile kernels");
      !built) {
    return make_error(ErrorCode::kDevice,
                      fmt::format("{}\n{}",
                                  built.error().message,
                                  program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(devices.front())));
  }
  return ComputeProgram(
      std::make_unique<internal::ProgramImpl>(internal::ProgramImpl{std::move(program)}));
}

Result<ComputeBuffer> ComputeContext::allocate(std::size_t num_bytes) const {
  // NVIDIA's driver promises any size and fails at the first use.
  const std::uint64_t most = impl_->device.handle.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
  if (num_bytes > most) {
    return make_error(
        ErrorCode::kDevice,
        fmt::format(
            "the OpenCL device failed to allocate {} bytes: it gives {} at most", num_bytes, most));
  }
  cl_int status = CL_SUCCESS;
  cl::Buffer buffer(impl_->context, CL_MEM_READ_WRITE, num_bytes, nullptr, &status);
  MOR_CHECK(check_opencl(status, fmt::format("allocate {} bytes", num_bytes)));
  return ComputeBuffer(
      std::make_unique<internal::BufferImpl>(internal::BufferImpl{std::move(buffer), num_bytes}));
}

Result<void> ComputeContext::write_bytes(ComputeBuffer& buffer, std::span<const std::byte> bytes) {
  if (bytes.size() > buffer.num_bytes()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("{} bytes do not fit a device buffer of {}", bytes.size(), buffer.num_bytes()));
  }
  if (bytes.empty()) return {};
  return check_opencl(
      impl_->queue.enqueueWriteBuffer(buffer.impl_->buffer, CL_TRUE, 0, bytes.size(), bytes.data()),
      fmt::format("take {} bytes", bytes.size()));
}

Result<void> ComputeContext::read_bytes(const ComputeBuffer& buffer, std::span<std::byte> bytes) {
  if (bytes.size() > buffer.num_bytes()) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("{} bytes are not in a device buffer of {}", bytes.size(), buffer.num_bytes()));
  }
  if (bytes.empty()) return {};
  return check_opencl(
      impl_->queue.enqueueReadBuffer(buffer.impl_->buffer, CL_TRUE, 0, bytes.size(), bytes.data()),
      fmt::format("give {} bytes back", bytes.size()));
}

Result<void> ComputeContext::enqueue(ComputeKernel& kernel, const WorkSize& size) {
  return check_opencl(impl_->queue.enqueueNDRangeKernel(kernel.impl_->kernel,
                                                        cl::NullRange,
                                                        cl::NDRange(size.num_items),
                                                        cl::NDRange(size.group_size)),
                      fmt::format("run {}", kernel.impl_->name));
}

}  // namespace mor
