// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/texture_evaluation.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/simulated_camera.h"
#include "morgagni/documentation/texture_coverage.h"
#include "morgagni/evaluation/internal/atlas_picture.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/tracking/tracker.h"

namespace mor {
namespace {

using internal::AtlasComparison;
using internal::AtlasPicture;
using internal::AtlasPlace;

constexpr double kFinerTruth = 2.25;  ///< 1440x1080 for 640x480.
constexpr float kOwnBestShare = 0.8F;

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void append(AtlasComparison& all, const AtlasComparison& more) {
  all.num_texels += more.num_texels;
  all.color_difference.insert(
      all.color_difference.end(), more.color_difference.begin(), more.color_difference.end());
  all.misplacement_px.insert(
      all.misplacement_px.end(), more.misplacement_px.begin(), more.misplacement_px.end());
}

TextureQuality quality_of(const AtlasComparison& comparison) {
  const auto& shifts = comparison.misplacement_px;
  const auto num_within =
      std::count_if(shifts.begin(), shifts.end(), [](double shift) { return shift <= 1.0; });
  return {.color_difference = summarize(comparison.color_difference),
          .misplacement_px = summarize(shifts),
          .within_1_px = shifts.empty()
                             ? 0.0
                             : static_cast<double>(num_within) / static_cast<double>(shifts.size()),
          .num_patches = shifts.size()};
}

/// A single tracked picture laid onto the skin, and the same without clutter: a glove's folds are
/// no detail of the skin.
struct SinglePicture {
  AtlasPicture picture;
  AtlasPicture clean;
};

class Study {
 public:
  Study(std::shared_ptr<const FixedSurface> body, const TextureStudyOptions& options)
      : body_(std::move(body)), options_(options) {}

  Result<TextureStudy> run(const Progress& progress) {
    MOR_TRY(auto unwrapped, unwrap_skin(body_->mesh, options_.atlas));
    atlas_ = std::make_shared<const SkinAtlas>(std::move(unwrapped));
    places_ = internal::atlas_places(*atlas_);
    MOR_TRY(auto fusion, TextureFusion::create(atlas_, options_.fusion));
    MOR_CHECK(follow(fusion, progress));
    MOR_TRY(const auto truth, draw_truth(progress));
    study_.texture = fusion.texture();
    compare(truth, progress);
    return std::move(study_);
  }

 private:
  Result<SimulatedCameraOptions> camera_options() const {
    MOR_TRY(auto camera, SimulatedCameraOptions::parse(options_.camera));
    camera.seed = options_.seed;
    camera.num_frames = 0;
    camera.is_real_time = false;
    return camera;
  }

  Result<void> follow(TextureFusion& fusion, const Progress& progress) {
    MOR_TRY(const auto camera_choice, camera_options());
    const auto skin = std::make_shared<const TriangleMesh>(body_->mesh);
    MOR_TRY(const auto camera, SimulatedCamera::create(skin, camera_choice));
    auto clean_choice = camera_choice;
    clean_choice.clutter = SimulatedClutter::kNone;
    MOR_TRY(const auto clean_camera, SimulatedCamera::create(skin, clean_choice));
    MOR_TRY(auto extractor, BodySurfaceExtractor::create(camera->calibration().depth, {}));
    MOR_TRY(auto registration, make_fine_registration(body_, {}));
    MOR_TRY(auto tracker,
            Tracker::create({}, body_, std::move(extractor), std::move(registration)));
    const Eigen::Vector3d center = body_->mesh.bounds().center().cast<double>();
    std::vector<double> errors_mm;
    std::vector<double> cpu_ms;
    bool is_waiting = true;
    for (int i = 0; i < options_.num_frames; ++i) {
      const auto id = static_cast<std::uint64_t>(i);
      const auto frame = (has_clutter(i) ? camera : clean_camera)->frame_at(id);
      const Eigen::Isometry3d truth = camera->ct_from_camera(id);
      // A hand may cover the body at first: it is looked for where it is until it is seen.
      const Eigen::Translation3d off(options_.start_error_mm, 0.0, 0.0);
      if (is_waiting) tracker.start_by_placement(off * truth);
      MOR_TRY(const auto tracked, tracker.process(frame));
      is_waiting = tracked.state == TrackingState::kWaiting || tracked.needs_start;
      progress("melt", static_cast<double>(i + 1) / options_.num_frames);
      const bool is_good = tracked.state == TrackingState::kTracking && tracked.ct_from_depth &&
                           !tracked.is_held && tracked.covariance;
      study_.num_tracked += is_good ? 1 : 0;
      if (i % options_.fuse_every != 0 || !is_good) continue;
      ++study_.num_offered;
      errors_mm.push_back(displacement_mm(
          *tracked.ct_from_depth * truth.inverse(), Eigen::Isometry3d::Identity(), center));
      const double bound_mm = error_bound_mm(*tracked.covariance, center);
      const double before_ms = thread_cpu_ms();
      MOR_TRY(const auto outcome, fusion.add(*frame, *tracked.ct_from_depth, bound_mm, i));
      cpu_ms.push_back(thread_cpu_ms() - before_ms);
      study_.num_melted += outcome == FusionOutcome::kFused ? 1 : 0;
      if (i % options_.single_every == 0) {
        keep_single(*frame, *clean_camera->frame_at(id), *tracked.ct_from_depth);
      }
    }
    study_.pose_error_mm = summarize(errors_mm);
    study_.cpu_ms = summarize(cpu_ms);
    return {};
  }

  [[nodiscard]] bool has_clutter(int frame) const {
    const int period = options_.clutter_period;
    return period == 0 || frame % period >= period / 2;
  }

  void keep_single(const RgbdFrame& frame,
                   const RgbdFrame& clean,
                   const Eigen::Isometry3d& ct_from_depth) {
    const Eigen::Isometry3d color_from_ct =
        frame.calibration->color_from_depth * ct_from_depth.inverse();
    auto& single = singles_.emplace_back(
        SinglePicture{internal::empty_picture(*atlas_), internal::empty_picture(*atlas_)});
    internal::project_onto(frame, color_from_ct, *atlas_, places_, single.picture);
    internal::project_onto(clean, color_from_ct, *atlas_, places_, single.clean);
  }

  Result<AtlasPicture> draw_truth(const Progress& progress) const {
    MOR_TRY(auto camera_choice, camera_options());
    camera_choice.width_px = static_cast<int>(camera_choice.width_px * kFinerTruth);
    camera_choice.height_px = static_cast<int>(camera_choice.height_px * kFinerTruth);
    camera_choice.has_noise = false;
    camera_choice.clutter = SimulatedClutter::kNone;
    camera_choice.exposure_swing = 0.0;
    const auto skin = std::make_shared<const TriangleMesh>(body_->mesh);
    MOR_TRY(const auto camera, SimulatedCamera::create(skin, camera_choice));
    auto truth = internal::empty_picture(*atlas_);
    for (int i = 0; i < options_.num_frames; i += options_.truth_every) {
      const auto id = static_cast<std::uint64_t>(i);
      const auto frame = camera->frame_at(id);
      internal::project_onto(*frame, camera->ct_from_camera(id).inverse(), *atlas_, places_, truth);
      progress("truth",
               std::min(1.0, static_cast<double>(i + options_.truth_every) / options_.num_frames));
    }
    return truth;
  }

  void compare(const AtlasPicture& truth, const Progress& progress) {
    const auto fused = internal::as_picture(study_.texture);
    const auto of_fused = internal::compare_pictures(fused, truth);
    study_.fused = quality_of(of_fused);
    AtlasComparison of_singles;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < singles_.size(); ++i) {
      append(of_singles, internal::compare_pictures(singles_[i].picture, truth));
      const auto& clean = singles_[i].clean;
      const float best =
          *std::max_element(clean.quality.data(), clean.quality.data() + clean.quality.size());
      const auto energy = internal::gradient_energy(fused, clean, kOwnBestShare * best);
      if (energy.num_steps > 2000) ratios.push_back(energy.of_a / energy.of_b);
      progress("compare", static_cast<double>(i + 1) / static_cast<double>(singles_.size()));
    }
    study_.single = quality_of(of_singles);
    if (!ratios.empty()) {
      study_.least_gradient_ratio = *std::min_element(ratios.begin(), ratios.end());
      study_.median_gradient_ratio = summarize(ratios).median;
    }
    study_.coverage = SkinCoverage(atlas_).share(study_.texture);
    std::size_t num_visible = 0;
    study_.truth = Image<Rgb8>(atlas_->width_px, atlas_->height_px, {96, 96, 104});
    for (std::size_t i = 0; i < truth.quality.size(); ++i) {
      if (truth.quality.data()[i] <= 0.0F) continue;
      ++num_visible;
      const auto& color = truth.color.data()[i];
      study_.truth.data()[i] = {static_cast<std::uint8_t>(color.x() + 0.5F),
                                static_cast<std::uint8_t>(color.y() + 0.5F),
                                static_cast<std::uint8_t>(color.z() + 0.5F)};
    }
    if (num_visible > 0) {
      study_.coverage_of_visible =
          static_cast<double>(of_fused.num_texels) / static_cast<double>(num_visible);
    }
  }

  std::shared_ptr<const FixedSurface> body_;
  TextureStudyOptions options_;
  std::shared_ptr<const SkinAtlas> atlas_;
  std::vector<AtlasPlace> places_;
  std::vector<SinglePicture> singles_;
  TextureStudy study_;
};

}  // namespace

Result<void> TextureStudyOptions::check() const {
  const auto refuse = [](std::string_view what, std::string_view limits, double value) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} must be {}, got {}", what, limits, value));
  };
  if (num_frames < 1) return refuse("num_frames", "at least 1", num_frames);
  if (fuse_every < 1) return refuse("fuse_every", "at least 1", fuse_every);
  if (truth_every < 1) return refuse("truth_every", "at least 1", truth_every);
  if (single_every < 1) return refuse("single_every", "at least 1", single_every);
  if (clutter_period < 0) return refuse("clutter_period", "at least 0", clutter_period);
  if (!(start_error_mm >= 0.0)) return refuse("start_error_mm", "at least 0", start_error_mm);
  MOR_CHECK(atlas.check());
  return fusion.check();
}

Result<TextureStudy> run_texture_study(std::shared_ptr<const FixedSurface> body,
                                       const TextureStudyOptions& options,
                                       const Progress& progress) {
  MOR_CHECK(options.check());
  return Study(std::move(body), options).run(progress);
}

std::string to_markdown(const TextureStudy& study) {
  const auto row = [](std::string_view name, const TextureQuality& quality) {
    return fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.0f} % | {} |\n",
                       name,
                       quality.color_difference.median,
                       quality.color_difference.p95,
                       quality.misplacement_px.median,
                       quality.misplacement_px.p95,
                       100.0 * quality.within_1_px,
                       quality.num_patches);
  };
  return "| | CIEDE2000 median | p95 | misplaced px, median | p95 | within 1 px | patches |\n"
         "|---|---|---|---|---|---|---|\n" +
         row("fused", study.fused) + row("single pictures", study.single) +
         fmt::format(
             "\n- gradient energy, fused over single: least {:.0f} %, median {:.0f} %\n"
             "- coverage: {:.1f} % of the skin that could be seen from anywhere, {:.1f} % of what "
             "this pass's camera could see\n"
             "- frames: {} tracked well, {} offered, {} gave texels\n"
             "- the tracker's error at the body's centre: median {:.2f} mm, p95 {:.2f} mm\n"
             "- CPU a frame: median {:.1f} ms, p95 {:.1f} ms\n",
             100.0 * study.least_gradient_ratio,
             100.0 * study.median_gradient_ratio,
             100.0 * study.coverage,
             100.0 * study.coverage_of_visible,
             study.num_tracked,
             study.num_offered,
             study.num_melted,
             study.pose_error_mm.median,
             study.pose_error_mm.p95,
             study.cpu_ms.median,
             study.cpu_ms.p95);
}

}  // namespace mor
