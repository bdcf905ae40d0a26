// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/surfaces.h"

#include <cmath>
#include <string>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <tbb/parallel_invoke.h>

#include "morgagni/ct/acvd.h"
#include "morgagni/ct/internal/body_mask.h"
#include "morgagni/ct/internal/body_parts.h"
#include "morgagni/ct/internal/body_preview.h"
#include "morgagni/ct/internal/body_volume.h"
#include "morgagni/ct/internal/doubtful_skin.h"
#include "morgagni/ct/internal/marching_cubes.h"
#include "morgagni/ct/internal/uncovering.h"

namespace mor {

Result<void> SkinOptions::check() const {
  const auto refuse = [](const std::string& sentence) {
    return make_error(ErrorCode::kInvalidArgument, sentence);
  };
  if (!(threshold_hu >= -1024.0 && threshold_hu <= 3071.0))
    return refuse("threshold_hu must be in [-1024, 3071], got " + std::to_string(threshold_hu));
  if (!(upper_hu > threshold_hu && upper_hu <= 32767.0)) {
    return refuse("upper_hu must be above threshold_hu (" + std::to_string(threshold_hu) +
                  ") and at most 32767, got " + std::to_string(upper_hu));
  }
  if (!(closing_mm >= 0.0 && closing_mm <= 30.0))
    return refuse("closing_mm must be in [0, 30], got " + std::to_string(closing_mm));
  if (num_vertices < 100 || num_vertices > 1000000)
    return refuse("num_vertices must be in [100, 1000000], got " + std::to_string(num_vertices));
  constexpr std::size_t kMostMarks = 200;
  for (const auto* marks : {&keep_mm, &cut_mm, &take_off_mm}) {
    if (marks->size() > kMostMarks)
      return refuse("there are more than 200 marks to keep, cut or take off");
    for (const auto& mark : *marks)
      if (!mark.allFinite()) return refuse("a mark to keep, cut or take off is no place");
  }
  return AcvdOptions{num_vertices, sub_sampling, gradation}.check();
}

namespace {

Result<internal::BareCt> bare_ct(const Volume& volume,
                                 const SkinOptions& options,
                                 const Progress& progress) {
  const auto report = [&](double fraction) {
    if (progress) progress("covers", fraction);
  };
  report(0.0);
  auto bare = internal::bare_ct(volume, options.take_off_mm, report);
  for (const auto& mark : options.take_off_mm) {
    if (bare.asked.size() == volume.size && internal::is_near(bare.asked, mark, volume)) continue;
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("there is no thin layer to take off near ({:.1f}, {:.1f}, {:.1f}):"
                    " give a place of a stretch where one may go on (doubtful_skin)",
                    mark.x(),
                    mark.y(),
                    mark.z()));
  }
  report(1.0);
  return bare;
}

BodyPreview preview_of(const Volume& volume,
                       const internal::BareCt& bare,
                       const internal::BodyMask& body) {
  auto doubtful = internal::doubtful_skin(bare, body.body, volume);
  return {internal::cut_parts(volume, body),
          std::move(doubtful.stretches),
          internal::draw_body_preview(volume, body.matter, body.body, doubtful.where)};
}

internal::BodyMaskOptions body_options(const SkinOptions& options) {
  return {
      options.threshold_hu, options.upper_hu, options.closing_mm, options.keep_mm, options.cut_mm};
}

}  // namespace

Result<BodyPreview> preview_body(const Volume& volume,
                                 const SkinOptions& options,
                                 const Progress& progress) {
  MOR_CHECK(options.check());
  MOR_TRY(const auto bare, bare_ct(volume, options, progress));
  MOR_TRY(const auto body, internal::body_mask(volume, bare, body_options(options), progress));
  return preview_of(volume, bare, body);
}

Result<SkinSurfaces> find_skin(const Volume& volume,
                               const SkinOptions& options,
                               const Progress& progress) {
  MOR_CHECK(options.check());
  MOR_TRY(const auto bare, bare_ct(volume, options, progress));
  MOR_TRY(const auto body, internal::body_mask(volume, bare, body_options(options), progress));
  SkinSurfaces surfaces;
  if (progress) progress("surface", 0.0);
  const Volume& seen = bare.volume ? *bare.volume : volume;
  tbb::parallel_invoke(
      [&] { surfaces.full = internal::marching_cubes(seen, body.body, options.threshold_hu); },
      [&] { surfaces.body = internal::body_volume(seen, body.body); },
      [&] { surfaces.preview = preview_of(volume, bare, body); });
  if (progress) progress("surface", 1.0);
  return surfaces;
}

Result<TriangleMesh> remesh_skin(const TriangleMesh& full,
                                 const SkinOptions& options,
                                 const Progress& progress) {
  return remesh_acvd(
      full, {options.num_vertices, options.sub_sampling, options.gradation}, progress);
}

Result<SkinSurfaces> extract_skin(const Volume& volume,
                                  const SkinOptions& options,
                                  const Progress& progress) {
  MOR_TRY(auto surfaces, find_skin(volume, options, progress));
  MOR_TRY(surfaces.remeshed, remesh_skin(surfaces.full, options, progress));
  return surfaces;
}

}  // namespace mor
