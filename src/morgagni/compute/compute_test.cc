// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/compute/compute_context.h"

namespace mor {
namespace {

using testing::HasSubstr;

const std::vector<ComputeDevice>& two_devices() {
  static const std::vector<ComputeDevice> kDevices = {
      {.name = "NVIDIA GeForce GTX 560", .type = ComputeDeviceType::kGpu},
      {.name = "pthread-AMD EPYC", .type = ComputeDeviceType::kCpu}};
  return kDevices;
}

TEST(ChooseComputeDevice, TakesTheFirstForOpenclAndOthersByAPartOfTheirName) {
  EXPECT_EQ(choose_compute_device(two_devices(), "opencl"), 0U);
  EXPECT_EQ(choose_compute_device(two_devices(), "geforce"), 0U);
  EXPECT_EQ(choose_compute_device(two_devices(), "amd epyc"), 1U);
}

TEST(ChooseComputeDevice, SaysWhatThereIsWhenNothingFits) {
  for (const char* choice : {"radeon", ""}) {
    const auto refused = choose_compute_device(two_devices(), choice);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(refused.error().message,
                HasSubstr("\"NVIDIA GeForce GTX 560\", \"pthread-AMD EPYC\""));
  }
}

TEST(ChooseComputeDevice, SaysWhatToInstallWhereThereIsNone) {
  const auto refused = choose_compute_device({}, "opencl");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(refused.error().message, HasSubstr("pocl-opencl-icd"));
}

constexpr const char* kAddKernel = R"(
__kernel void add(const uint count, const int step, __global const int* in, __global int* out) {
  const uint i = get_global_id(0);
  if (i < count) out[i] = in[i] + step;
})";

/// The first device; a test is skipped where there is none.
class OnADevice : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = ComputeContext::open("opencl");
    if (!opened) GTEST_SKIP() << opened.error().message;
    context_.emplace(*std::move(opened));
  }
  std::optional<ComputeContext> context_;
};

TEST_F(OnADevice, IsDescribed) {
  const ComputeDevice& device = context_->device();
  EXPECT_FALSE(device.name.empty());
  EXPECT_FALSE(device.platform.empty());
  EXPECT_GE(device.num_units, 1);
  EXPECT_GT(device.memory_bytes, std::uint64_t{1} << 20);
  EXPECT_EQ(list_compute_devices().front().name, device.name);
}

TEST_F(OnADevice, RunsAKernelOverAnyNumberOfItems) {
  auto kernel = *context_->build(kAddKernel, "")->kernel("add");
  for (const std::size_t count : {1, 2, 3, 7, 64, 4097}) {
    std::vector<std::int32_t> in(count);
    std::iota(in.begin(), in.end(), 5);
    auto device_in = *context_->allocate(count * sizeof(std::int32_t));
    auto device_out = *context_->allocate(count * sizeof(std::int32_t));
    ASSERT_TRUE(context_->write<std::int32_t>(device_in, in));
    ASSERT_TRUE(context_->run(kernel,
                              WorkSize::at_least(count, 64),
                              static_cast<std::uint32_t>(count),
                              std::int32_t{-3},
                              device_in,
                              device_out));
    std::vector<std::int32_t> out(count);
    ASSERT_TRUE(context_->read<std::int32_t>(device_out, out));
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(out[i], in[i] - 3) << i;
  }
}

TEST_F(OnADevice, ReportsWhatTheCompilerSays) {
  const auto failed = context_->build("__kernel void broken() { undeclared = 1; }", "");
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kDevice);
  EXPECT_THAT(failed.error().message, HasSubstr("undeclared"));
  const auto missing = context_->build(kAddKernel, "")->kernel("subtract");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("subtract"));
}

TEST_F(OnADevice, ReportsWhatItRefusesToDo) {
  const auto too_much = context_->allocate(std::size_t{1} << 50);
  ASSERT_FALSE(too_much);
  EXPECT_EQ(too_much.error().code, ErrorCode::kDevice);
  EXPECT_THAT(too_much.error().message, HasSubstr("allocate 1125899906842624 bytes"));

  auto kernel = *context_->build(kAddKernel, "")->kernel("add");
  auto buffer = *context_->allocate(64);
  const auto uneven = context_->run(kernel, {10, 3}, std::uint32_t{0}, 0, buffer, buffer);
  ASSERT_FALSE(uneven);
  EXPECT_EQ(uneven.error().code, ErrorCode::kDevice);
  EXPECT_THAT(uneven.error().message, HasSubstr("run add"));
  const auto wrong_type = context_->run(kernel, {64, 64}, 0.0, 0, buffer, buffer);
  ASSERT_FALSE(wrong_type);
  EXPECT_THAT(wrong_type.error().message, HasSubstr("argument 0 of add"));
}

TEST_F(OnADevice, NeverReadsOrWritesBeyondABuffer) {
  auto buffer = *context_->allocate(16);
  std::vector<float> values(5);
  EXPECT_FALSE(context_->write<float>(buffer, values));
  EXPECT_FALSE(context_->read<float>(buffer, values));
  ComputeBuffer none;
  EXPECT_FALSE(context_->write<float>(none, values));
  EXPECT_FALSE(context_->read<float>(none, values));
}

}  // namespace
}  // namespace mor
