// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/automatic_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "morgagni/registration/internal/start_finder.h"

namespace mor {

Result<void> AutomaticStartOptions::check() const {
  const auto bad = [](std::string message) {
    return make_error(ErrorCode::kInvalidArgument, std::move(message));
  };
  if (gravity && !(gravity->allFinite() && gravity->norm() > 0.0)) {
    return bad("gravity must be a finite vector other than zero");
  }
  if (lying_on.empty()) return bad("lying_on must name at least one side of the body");
  if (!(max_distance_mm >= 200.0 && max_distance_mm <= 5000.0)) {
    return bad(fmt::format("max_distance_mm must be in [200, 5000], got {}", max_distance_mm));
  }
  if (num_threads < 1 || num_threads > 64) {
    return bad(fmt::format("num_threads must be in [1, 64], got {}", num_threads));
  }
  return {};
}

std::string_view to_string(AutomaticStartStatus status) {
  switch (status) {
    case AutomaticStartStatus::kFound:
      return "found";
    case AutomaticStartStatus::kAmbiguous:
      return "ambiguous";
    case AutomaticStartStatus::kNotFound:
      break;
  }
  return "not found";
}

struct AutomaticStart::Impl {
  [[nodiscard]] Result<void> check(ImageView<const std::uint16_t> depth_mm) const;

  PinholeCamera depth_camera;
  int num_threads;
  internal::StartFinder finder;
};

Result<AutomaticStart> AutomaticStart::create(std::shared_ptr<const FixedSurface> fixed,
                                              const PinholeCamera& depth_camera,
                                              const AutomaticStartOptions& options) {
  MOR_CHECK(options.check());
  MOR_CHECK(depth_camera.check());
  if (!fixed || fixed->mesh.empty() || fixed->field.empty() ||
      fixed->mesh.normals.size() != fixed->mesh.vertices.size()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "an automatic start needs the CT's skin with normals and its distance field: "
                      "prepare the case");
  }
  internal::StartFinder finder(std::move(fixed), depth_camera, options);
  return AutomaticStart(
      std::unique_ptr<const Impl>(new Impl{depth_camera, options.num_threads, std::move(finder)}));
}

AutomaticStart::AutomaticStart(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
AutomaticStart::AutomaticStart(AutomaticStart&&) noexcept = default;
AutomaticStart& AutomaticStart::operator=(AutomaticStart&&) noexcept = default;
AutomaticStart::~AutomaticStart() = default;

Result<void> AutomaticStart::Impl::check(ImageView<const std::uint16_t> depth_mm) const {
  if (depth_mm.width() == depth_camera.width_px && depth_mm.height() == depth_camera.height_px) {
    return {};
  }
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("the depth picture must be {} x {} px as the camera's, got {} x {}",
                                depth_camera.width_px,
                                depth_camera.height_px,
                                depth_mm.width(),
                                depth_mm.height()));
}

Result<AutomaticStartResult> AutomaticStart::find(ImageView<const std::uint16_t> depth_mm,
                                                  std::stop_token stop) const {
  MOR_CHECK(impl_->check(depth_mm));
  tbb::task_arena arena(impl_->num_threads);
  return arena.execute([&] { return impl_->finder.find(depth_mm, stop); });
}

Result<AutomaticStartResult> AutomaticStart::find_next(ImageView<const std::uint16_t> depth_mm,
                                                       StartMemory& memory,
                                                       std::stop_token stop) const {
  MOR_CHECK(impl_->check(depth_mm));
  tbb::task_arena arena(impl_->num_threads);
  return arena.execute([&] { return impl_->finder.find_next(depth_mm, *memory.recall_, stop); });
}

StartMemory::StartMemory() : recall_(std::make_unique<internal::StartRecall>()) {}
StartMemory::StartMemory(StartMemory&&) noexcept = default;
StartMemory& StartMemory::operator=(StartMemory&&) noexcept = default;
StartMemory::~StartMemory() = default;

void StartMemory::forget() {
  *recall_ = {};
}

}  // namespace mor
