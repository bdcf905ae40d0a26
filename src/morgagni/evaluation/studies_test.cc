// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/studies.h"

#include <cmath>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "morgagni/compute/compute_device.h"
#include "morgagni/evaluation/studies_markdown.h"
#include "morgagni/evaluation/study_plots.h"
#include "morgagni/evaluation/target_sampling.h"
#include "morgagni/geometry/rigid.h"
#include "morgagni/registration/testing/test_body.h"

namespace mor {
namespace {

using testing::HasSubstr;

void silent(std::string_view /*stage*/, double /*fraction*/) {}

const Case& bumpy_case() {
  static const Case kBody = [] {
    Case body;
    body.name = "bumpy";
    body.skin = internal::bumpy_surface(60);
    return body;
  }();
  return kBody;
}

StudiesOptions short_options() {
  StudiesOptions options;
  options.num_poses = 2;
  options.num_many_poses = 1;
  options.down_samplings = {2.5, 4.0};
  options.runs_opencl = false;
  return options;
}

const StudiesReport& short_report() {
  static const StudiesReport kReport = [] {
    auto report = run_studies(bumpy_case(), {}, short_options(), silent);
    if (!report) ADD_FAILURE() << report.error().message;
    return report.value();
  }();
  return kReport;
}

std::vector<StudyPose> poses_with(const TaggingOptions& tagging) {
  const auto& skin = bumpy_case().skin->mesh;
  const std::shared_ptr<const TriangleMesh> shared(bumpy_case().skin, &skin);
  SimulatedCameraOptions options;
  options.path = SimulatedPath::kViews;
  options.has_noise = false;
  const auto camera = SimulatedCamera::create(shared, options).value();
  const auto markers = sample_skin_targets(skin, 22, 1).value();
  return draw_study_poses(skin, *camera, options, markers, tagging, 3).value();
}

/// A column of the device, or the reason why there is none: never the CPU's under its name.
TEST(Studies, RunOnOpenclOrSayWhyNot) {
  auto options = short_options();
  options.runs_opencl = true;
  options.num_poses = 1;
  options.down_samplings = {4.0};
  const auto report = run_studies(bumpy_case(), {}, options, silent);
  ASSERT_TRUE(report) << report.error().message;
  int num_opencl = 0;
  for (const auto& column : report->phantom.columns) {
    if (column.method.device == "cpu") continue;
    ++num_opencl;
    EXPECT_EQ(column.runs.empty(), !column.not_run.empty());
    if (list_compute_devices().empty()) {
      EXPECT_THAT(column.not_run, HasSubstr("no OpenCL device"));
    } else {
      EXPECT_EQ(column.not_run, "");
    }
  }
  EXPECT_GT(num_opencl, 0);
}

TEST(StudyPoses, ExactTaggingMeetsTheTruth) {
  for (const auto& pose : poses_with({.marker_px = 0, .marker_ct_mm = 0, .landmark_mm = 0})) {
    EXPECT_EQ(pose.markers.size(), kMarkersUsed);
    // The depth is read in whole millimetres at a whole pixel, on skin that leans.
    EXPECT_LT(pose.fre_mm, 3.0);
    for (const auto& marker : pose.markers) {
      EXPECT_EQ(marker.tagged_ct, marker.ct);
      EXPECT_LT((pose.ct_from_depth * marker.tagged_depth - marker.ct).norm(), 6.0);
    }
    EXPECT_LT(displacement_mm(pose.start, pose.ct_from_depth, {0.0, 0.0, 600.0}), 1e-6);
  }
}

TEST(StudyPoses, TaggingErrorsShowInFreAndStart) {
  const auto exact = poses_with({.marker_px = 0, .marker_ct_mm = 0, .landmark_mm = 0});
  const auto tagged = poses_with({.marker_px = 1, .marker_ct_mm = 3, .landmark_mm = 8});
  double exact_mm = 0.0;
  double tagged_mm = 0.0;
  for (std::size_t i = 0; i < tagged.size(); ++i) {
    exact_mm += exact[i].fre_mm;
    tagged_mm += tagged[i].fre_mm;
    const double off_mm =
        displacement_mm(tagged[i].start, tagged[i].ct_from_depth, {0.0, 0.0, 600.0});
    EXPECT_GT(off_mm, 0.5);
    EXPECT_LT(off_mm, 60.0);
  }
  EXPECT_GT(tagged_mm, 2.0 * exact_mm);
}

TEST(Studies, MeasureEveryMethodOnTheSamePoses) {
  const auto& report = short_report();
  ASSERT_EQ(report.phantom.columns.size(), 5U);
  ASSERT_EQ(report.down_sampled.size(), 2U);
  for (const auto& column : report.phantom.columns) {
    EXPECT_EQ(column.not_run, "");
    ASSERT_EQ(column.runs.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(column.runs[i].fre_mm, report.phantom.columns[0].runs[i].fre_mm);
      EXPECT_EQ(column.runs[i].start_tre_mm, report.phantom.columns[0].runs[i].start_tre_mm);
      EXPECT_GT(column.runs[i].num_points, 500);
    }
  }
  // Ours, on a body with shape and without bias, beats any start a person would give.
  for (const auto& run : report.phantom.columns.back().runs) {
    EXPECT_LT(run.internal_tre_mm, 1.0);
    EXPECT_LT(run.internal_tre_mm, run.start_tre_mm);
  }
  EXPECT_GT(report.down_sampled.front().columns[0].runs[0].num_points,
            2 * report.down_sampled.back().columns[0].runs[0].num_points);
}

TEST(StudyPoses, AreTheSameForTheSameSeed) {
  const auto first = poses_with({});
  const auto again = poses_with({});
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].fre_mm, again[i].fre_mm);
    EXPECT_TRUE(first[i].start.isApprox(again[i].start, 0.0));
    EXPECT_EQ(first[i].frame->depth_mm, again[i].frame->depth_mm);
  }
}

TEST(Studies, NameWhatIsNotRunAndGoOn) {
  auto report = short_report();
  report.phantom.columns[0].runs.clear();
  report.phantom.columns[0].not_run = "no OpenCL device";
  const auto text = to_markdown(report, "a machine");
  EXPECT_THAT(text, HasSubstr("not run: no OpenCL device"));
  EXPECT_EQ(study_plots(report).size(), 3U);
}

TEST(Studies, ReportSaysThatDataAreSimulatedAndWhatThePaperPrinted) {
  const auto text = to_markdown(short_report(), "a machine");
  EXPECT_THAT(text, HasSubstr("All data here are simulated"));
  EXPECT_THAT(text, HasSubstr("What the simulation leaves out"));
  EXPECT_THAT(text, HasSubstr("*4.2 ± 0.6*"));       // Table 1, ICP.
  EXPECT_THAT(text, HasSubstr("*1428.9 ± 334.6*"));  // Tables 2 and 3.
  EXPECT_THAT(text, HasSubstr("(accuracy.svg)"));
  const auto json = nlohmann::json::parse(to_json(short_report()));
  EXPECT_EQ(json["data"], "simulated");
  EXPECT_EQ(json["studies"].size(), 2U + 2U + 5U);
  EXPECT_EQ(json["studies"][0]["columns"][0]["runs"].size(), 2U);
}

TEST(Studies, PlotsAreWholeSvg) {
  for (const auto& plot : study_plots(short_report())) {
    EXPECT_TRUE(plot.svg.starts_with("<svg ")) << plot.file_name;
    EXPECT_TRUE(plot.svg.ends_with("</svg>\n")) << plot.file_name;
    EXPECT_EQ(plot.svg.find("nan"), std::string::npos) << plot.file_name;
    EXPECT_EQ(plot.svg.find("inf"), std::string::npos) << plot.file_name;
    EXPECT_LT(plot.svg.size(), 100'000U) << plot.file_name;
  }
}

TEST(Studies, RefuseBadOptions) {
  const auto error_of = [](const StudiesOptions& options) {
    const auto report = run_studies(bumpy_case(), {}, options, silent);
    return report ? "ran" : report.error().message;
  };
  auto options = short_options();
  options.num_poses = 0;
  EXPECT_THAT(error_of(options), HasSubstr("num_poses must be >= 1, got 0"));
  options = short_options();
  options.tagging.marker_px = NAN;
  EXPECT_THAT(error_of(options), HasSubstr("tagging must be in [0, 100]"));
  options = short_options();
  options.down_samplings = {5.0};
  EXPECT_THAT(error_of(options), HasSubstr("down-sampling must be in [1, 4], got 5"));
  options = short_options();
  options.bias_mm = 50.0;
  EXPECT_THAT(error_of(options), HasSubstr("bias must be in [0, 20]"));
  options = short_options();
  options.success_mm = 0.0;
  EXPECT_THAT(error_of(options), HasSubstr("success_mm"));
}

}  // namespace
}  // namespace mor
