// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>

#include <benchmark/benchmark.h>

#include "morgagni/depth/body_surface.h"
#include "morgagni/registration/fine_registration.h"

#include "torso_scene.h"

namespace mor {
namespace {

std::shared_ptr<const FixedSurface> torso_surface() {
  static const auto surface = [] {
    auto made = std::make_shared<FixedSurface>();
    made->mesh = torso_mesh();
    made->field = *DistanceField::build(made->mesh);
    return made;
  }();
  return surface;
}

/// The torso's points at a down-sampling of 2.5.
const PointCloud& torso_points() {
  static const PointCloud points = [] {
    auto extractor = *BodySurfaceExtractor::create(torso_camera(), {});
    return extractor.extract(torso_depth(torso_surface()->mesh).view())->cloud;
  }();
  return points;
}

void align(benchmark::State& state,
           RegistrationMethod method,
           StartQuality quality,
           double shift_mm,
           double angle_deg) {
  const auto registration = *make_fine_registration(torso_surface(), {.method = method});
  const Eigen::Isometry3d start =
      Eigen::Translation3d(shift_mm * Eigen::Vector3d(0.6, -0.5, 0.6).normalized()) *
      Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180.0,
                        Eigen::Vector3d(0.5, 0.4, 0.7).normalized()) *
      torso_from_camera();
  RegistrationResult result;
  for (auto _ : state) {
    result = *registration->align(torso_points(), start, quality);
    benchmark::DoNotOptimize(result);
  }
  state.counters["points"] = static_cast<double>(torso_points().size());
  state.counters["iterations_of_method"] = result.num_iterations;
  state.counters["error_mm"] =
      (result.fixed_from_moving.translation() - torso_from_camera().translation()).norm();
}

void BM_FieldTracked(benchmark::State& state) {
  align(state, RegistrationMethod::kField, StartQuality::kTracked, 5.0, 2.0);
}
void BM_FieldRough(benchmark::State& state) {
  align(state, RegistrationMethod::kField, StartQuality::kRough, 30.0, 20.0);
}
void BM_IcpTracked(benchmark::State& state) {
  align(state, RegistrationMethod::kIcp, StartQuality::kTracked, 5.0, 2.0);
}
void BM_TrimmedIcpTracked(benchmark::State& state) {
  align(state, RegistrationMethod::kTrimmedIcp, StartQuality::kTracked, 5.0, 2.0);
}
void BM_BuildField(benchmark::State& state) {
  const TriangleMesh mesh = torso_mesh();
  for (auto _ : state) benchmark::DoNotOptimize(DistanceField::build(mesh));
}

BENCHMARK(BM_FieldTracked)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FieldRough)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_IcpTracked)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_TrimmedIcpTracked)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_BuildField)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace mor
