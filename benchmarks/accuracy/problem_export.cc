// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "problem_export.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/tum_recording.h"
#include "morgagni/core/files.h"
#include "morgagni/evaluation/ground_truth.h"
#include "morgagni/evaluation/recording_evaluation.h"
#include "morgagni/geometry/depth_levels.h"
#include "morgagni/geometry/triangle_mesh_io.h"
#include "morgagni/registration/start.h"
#include "morgagni/registration/visible_place.h"

#include "peers/problem.h"

namespace mor::peers {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// The files of one set, as they come.
class Writer {
 public:
  explicit Writer(std::filesystem::path out) : out_(std::move(out)) {}

  [[nodiscard]] Result<void> begin(const Case& body,
                                   const std::filesystem::path& recording,
                                   const std::vector<Target>& targets,
                                   StartKind start) {
    std::error_code failed;
    std::filesystem::create_directories(out_, failed);
    if (failed) return make_error(ErrorCode::kIo, out_.string() + ": " + failed.message());
    MOR_CHECK(write_ply(out_ / "fixed.ply", body.skin->mesh));
    json_ = {{"body", body.name},
             {"recording", recording.string()},
             {"tracked", start == StartKind::kTracked},
             {"fixed", "fixed.ply"},
             {"targets", Json::array()},
             {"frames", Json::array()}};
    for (const auto& target : targets) {
      json_["targets"].push_back({target.ct.x(), target.ct.y(), target.ct.z()});
    }
    return {};
  }

  void begin_frame(std::size_t recording_frame, const Eigen::Isometry3d& truth) {
    json_["frames"].push_back({{"recording_frame", recording_frame},
                               {"truth", to_numbers(truth)},
                               {"clouds", Json::array()},
                               {"runs", Json::array()}});
    clouds_.clear();
  }

  /// A cloud that the frame has already is not written again.
  [[nodiscard]] Result<void> add_run(const TriangleMesh& cloud, const Eigen::Isometry3d& start) {
    Json& frame = json_["frames"].back();
    const auto same = std::find_if(clouds_.begin(), clouds_.end(), [&](const TriangleMesh& other) {
      return other.vertices == cloud.vertices;
    });
    const auto idx = static_cast<std::size_t>(same - clouds_.begin());
    if (same == clouds_.end()) {
      const std::string name =
          fmt::format("frame_{:03}_cloud_{:02}.ply", json_["frames"].size() - 1, idx);
      MOR_CHECK(write_ply(out_ / name, cloud));
      frame["clouds"].push_back(name);
      clouds_.push_back(cloud);
    }
    frame["runs"].push_back({{"cloud", idx}, {"start", to_numbers(start)}});
    return {};
  }

  [[nodiscard]] Result<void> finish() const {
    return write_file(out_ / "problems.json", json_.dump() + "\n");
  }

 private:
  std::filesystem::path out_;
  Json json_;
  std::vector<TriangleMesh> clouds_;  ///< Of the frame.
};

Eigen::Vector3d centroid(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point.cast<double>();
  return sum / static_cast<double>(points.size());
}

/// Cuts one frame's surface out as often as it is needed and adds the runs.
class FrameExport {
 public:
  FrameExport(BodySurfaceExtractor& extractor,
              const Case& body,
              const ExportOptions& options,
              Writer& writer)
      : extractor_(extractor),
        skin_(body.skin->mesh),
        options_(options),
        writer_(writer),
        random_(options.seed) {}

  [[nodiscard]] Result<void> add(const RgbdFrame& frame, const Eigen::Isometry3d& truth) {
    writer_.begin_frame(frame.frame_id, truth);
    if (options_.start == StartKind::kNone) {
      MOR_TRY(const auto cloud, surface(frame, truth));
      return writer_.add_run(cloud, Eigen::Isometry3d::Identity());
    }
    MOR_TRY(const auto seen, surface(frame, truth));
    const Eigen::Vector3d center = truth * centroid(seen.vertices);
    for (int i = 0; i < options_.num_starts; ++i) {
      const Eigen::Isometry3d start = perturbed_start(
          truth, center, options_.start_error_mm, options_.start_error_deg * kRadPerDeg, random_);
      MOR_TRY(const auto cloud, surface(frame, start));
      MOR_CHECK(writer_.add_run(cloud, start));
    }
    return {};
  }

 private:
  /// Cut out where `ct_from_depth` expects the body.
  [[nodiscard]] Result<TriangleMesh> surface(const RgbdFrame& frame,
                                             const Eigen::Isometry3d& ct_from_depth) {
    MOR_TRY(auto body,
            extractor_.extract(frame.depth_mm.view(), places_facing_camera(skin_, ct_from_depth)));
    if (body.cloud.empty()) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("frame {} shows no surface in range", frame.frame_id));
    }
    return TriangleMesh{.vertices = std::move(body.cloud.points),
                        .normals = std::move(body.cloud.normals),
                        .triangles = std::move(body.triangles)};
  }

  BodySurfaceExtractor& extractor_;
  const TriangleMesh& skin_;
  const ExportOptions& options_;
  Writer& writer_;
  std::mt19937_64 random_;
};

/// The part of the skin that faces a camera at the origin of frame depth.
TriangleMesh facing_part(const TriangleMesh& skin, const Eigen::Isometry3d& ct_from_depth) {
  constexpr float kMinCosine = 0.3F;
  const Eigen::Isometry3f depth_from_ct = ct_from_depth.inverse().cast<float>();
  constexpr std::uint32_t kHidden = 0xFFFFFFFFU;
  std::vector<std::uint32_t> moved_to(skin.vertices.size(), kHidden);
  TriangleMesh part;
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const Eigen::Vector3f point = depth_from_ct * skin.vertices[i];
    const Eigen::Vector3f normal = depth_from_ct.linear() * skin.normals[i];
    if (-normal.dot(point.normalized()) < kMinCosine) continue;
    moved_to[i] = static_cast<std::uint32_t>(part.vertices.size());
    part.vertices.push_back(point);
    part.normals.push_back(normal);
  }
  for (const auto& [a, b, c] : skin.triangles) {
    if (moved_to[a] != kHidden && moved_to[b] != kHidden && moved_to[c] != kHidden) {
      part.triangles.push_back({moved_to[a], moved_to[b], moved_to[c]});
    }
  }
  return part;
}

}  // namespace

Result<void> export_problems(const std::filesystem::path& out,
                             const Case& body,
                             const std::filesystem::path& recording_folder,
                             const ExportOptions& options) {
  MOR_TRY(const auto recording, TumRecording::open(recording_folder));
  MOR_TRY(auto poses, read_ground_truth(recording_folder / "groundtruth.txt"));
  MOR_TRY(auto targets, read_targets(recording_folder / "targets.csv"));
  MOR_TRY(const auto truth,
          align_truth_to_case(std::move(poses),
                              std::move(targets),
                              TruthFrame::kAuto,
                              body.skin->field,
                              body.ct_center_mm,
                              body.ct_half_voxel_mm));
  MOR_TRY(auto extractor,
          BodySurfaceExtractor::create(recording.calibration()->depth, options.depth));
  Writer writer(out);
  MOR_CHECK(writer.begin(
      body, std::filesystem::absolute(recording_folder), truth.targets, options.start));
  FrameExport frames(extractor, body, options, writer);
  DepthLevels levels;
  const std::size_t num_frames =
      std::min<std::size_t>(recording.size(), static_cast<std::size_t>(options.num_frames));
  for (std::size_t i = 0; i < num_frames; ++i) {
    MOR_TRY(auto sensed, recording.read(i * recording.size() / num_frames));
    const auto frame = depth_corrected(std::move(sensed), levels);
    const auto pose = truth_at(truth.poses, recording.timestamp_s(frame->frame_id));
    if (!pose) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("frame {} has no true pose", frame->frame_id));
    }
    MOR_CHECK(frames.add(*frame, *pose));
  }
  return writer.finish();
}

Result<void> export_exact_problems(const std::filesystem::path& out, const Case& body) {
  constexpr std::uint64_t kSeed = 3;
  constexpr double kShiftMm = 3.0;
  constexpr double kRotationDeg = 1.0;
  const TriangleMesh& skin = body.skin->mesh;
  std::vector<Target> targets;
  constexpr std::size_t kNumTargets = 50;
  for (std::size_t i = 0; i < kNumTargets; ++i) {
    const auto& vertex = skin.vertices[i * skin.vertices.size() / kNumTargets];
    targets.push_back({.name = "skin", .on_skin = true, .ct = vertex.cast<double>()});
  }
  Writer writer(out);
  MOR_CHECK(writer.begin(body, {}, targets, StartKind::kTracked));
  std::mt19937_64 random(kSeed);
  std::size_t number = 0;
  for (const BodySide side : {BodySide::kAnterior, BodySide::kLeft}) {
    MOR_TRY(const auto truth, place_in_front_of_camera(skin.bounds(), {.side = side}));
    const TriangleMesh cloud = facing_part(skin, truth);
    writer.begin_frame(number++, truth);
    MOR_CHECK(writer.add_run(cloud, truth));
    MOR_CHECK(writer.add_run(
        cloud,
        perturbed_start(
            truth, truth * centroid(cloud.vertices), kShiftMm, kRotationDeg * kRadPerDeg, random)));
  }
  return writer.finish();
}

}  // namespace mor::peers
