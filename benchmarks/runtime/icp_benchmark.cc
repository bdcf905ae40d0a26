// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <string>

#include <benchmark/benchmark.h>

#include "morgagni/registration/fine_registration.h"

#include "torso_scene.h"

namespace mor {
namespace {

std::shared_ptr<const FixedSurface> torso_surface() {
  static const auto surface = [] {
    auto made = std::make_shared<FixedSurface>();
    made->mesh = torso_mesh();
    return made;
  }();
  return surface;
}

/// So many of the torso's points, spread over what the camera sees of it.
PointCloud torso_points(std::size_t count) {
  const auto depth = torso_depth(torso_surface()->mesh);
  const PinholeCamera camera = torso_camera();
  PointCloud all;
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const float z = depth(x, y);
      if (z > 0.0F) all.points.push_back(z * camera.ray({x, y}).cast<float>().homogeneous());
    }
  }
  PointCloud some;
  for (std::size_t i = 0; i < count; ++i) some.points.push_back(all.points[i * all.size() / count]);
  return some;
}

/// A tracked frame, 5 mm / 2 degrees off. The device's start, the skin's upload and the first
/// frame's memory are not timed.
void align(benchmark::State& state, RegistrationMethod method, const std::string& device) {
  const auto registration =
      *make_fine_registration(torso_surface(), {.method = method, .device = device});
  if (device != "cpu" && registration->device_name() == "cpu") {
    state.SkipWithError("there is no OpenCL device");
    return;
  }
  const PointCloud moving = torso_points(static_cast<std::size_t>(state.range(0)));
  const Eigen::Isometry3d start =
      Eigen::Translation3d(5.0 * Eigen::Vector3d(0.6, -0.5, 0.6).normalized()) *
      Eigen::AngleAxisd(2.0 * std::numbers::pi / 180.0,
                        Eigen::Vector3d(0.5, 0.4, 0.7).normalized()) *
      torso_from_camera();
  RegistrationResult result = *registration->align(moving, start, StartQuality::kTracked);
  for (auto _ : state) {
    result = *registration->align(moving, start, StartQuality::kTracked);
    benchmark::DoNotOptimize(result);
  }
  state.SetLabel(registration->device_name());
  state.counters["iterations_of_method"] = result.num_iterations;
  state.counters["error_mm"] =
      (result.fixed_from_moving.translation() - torso_from_camera().translation()).norm();
}

void add_benchmarks(const std::string& name, RegistrationMethod method) {
  for (const char* device : {"cpu", "opencl"}) {
    benchmark::RegisterBenchmark(
        ("BM_" + name + "/device:" + device).c_str(),
        [method, device](benchmark::State& state) { align(state, method, device); })
        ->ArgName("points")
        ->Arg(5000)
        ->Arg(20000)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  mor::add_benchmarks("Icp", mor::RegistrationMethod::kIcp);
  mor::add_benchmarks("TrimmedIcp", mor::RegistrationMethod::kTrimmedIcp);
  mor::add_benchmarks("AnisotropicIcp", mor::RegistrationMethod::kAnisotropicIcp);
  mor::add_benchmarks("TrimmedAnisotropicIcp", mor::RegistrationMethod::kTrimmedAnisotropicIcp);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
