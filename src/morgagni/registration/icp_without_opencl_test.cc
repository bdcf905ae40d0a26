// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include "morgagni/core/log.h"
#include "morgagni/registration/fine_registration.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

/// A program of its own: OpenCL looks for its drivers once, and here finds none.
TEST(IcpWithoutOpencl, RunsOnTheCpuAndSaysWhatToInstall) {
  ASSERT_EQ(setenv("OCL_ICD_VENDORS", "/nonexistent", /*replace=*/1), 0);
  std::ostringstream text;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "captured", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)));
  auto surface = std::make_shared<FixedSurface>();
  surface->mesh = internal::bumpy_body(40, Eigen::Vector3f(30.0F, -200.0F, 400.0F));
  const auto registration = make_fine_registration(
      surface, {.method = RegistrationMethod::kTrimmedIcp, .device = "opencl"});
  spdlog::set_default_logger(before);

  ASSERT_TRUE(registration) << registration.error().message;
  EXPECT_EQ((*registration)->device_name(), "cpu");
  EXPECT_THAT(text.str(), HasSubstr("there is no OpenCL device: install a driver"));
  EXPECT_THAT(text.str(), HasSubstr("registration runs on the CPU"));
  const auto truth = internal::camera_before_body();
  const auto result =
      (*registration)
          ->align(internal::seen_by_camera(surface->mesh, truth), truth, StartQuality::kTracked);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, RegistrationStatus::kConverged);
}

}  // namespace
}  // namespace mor
