// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "problem.h"

#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "morgagni/core/files.h"
#include "morgagni/geometry/triangle_mesh_io.h"

namespace mor::peers {
namespace {

using Json = nlohmann::json;

constexpr std::uintmax_t kMaxJsonBytes = std::uintmax_t{1} << 28U;

Eigen::Isometry3d to_pose(const Json& numbers) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      pose.matrix()(row, column) = numbers.at(4 * row + column).get<double>();
    }
  }
  return pose;
}

Result<ProblemFrame> read_frame(const Json& json, const std::filesystem::path& folder) {
  ProblemFrame frame;
  frame.recording_frame = json.at("recording_frame").get<std::size_t>();
  for (const auto& name : json.at("clouds")) {
    MOR_TRY(auto cloud, read_ply(folder / name.get<std::string>()));
    frame.clouds.push_back(std::move(cloud));
  }
  for (const auto& run : json.at("runs")) {
    frame.runs.push_back({.cloud_idx = run.at("cloud").get<std::size_t>(),
                          .fixed_from_moving_init = to_pose(run.at("start"))});
    if (frame.runs.back().cloud_idx >= frame.clouds.size()) {
      return make_error(ErrorCode::kInvalidArgument, "a run names a cloud that its frame lacks");
    }
  }
  return frame;
}

}  // namespace

Result<ProblemSet> read_problems(const std::filesystem::path& folder) {
  MOR_TRY(const auto text, read_text_file(folder / "problems.json", kMaxJsonBytes));
  try {
    const Json json = Json::parse(text);
    ProblemSet set;
    set.recording = json.at("recording").get<std::string>();
    set.is_tracked = json.at("tracked").get<bool>();
    MOR_TRY(set.fixed, read_ply(folder / json.at("fixed").get<std::string>()));
    for (const auto& frame : json.at("frames")) {
      MOR_TRY(auto read, read_frame(frame, folder));
      set.frames.push_back(std::move(read));
    }
    return set;
  } catch (const Json::exception& error) {
    return make_error(ErrorCode::kInvalidArgument,
                      (folder / "problems.json").string() + ": " + error.what());
  }
}

PointCloud to_point_cloud(const TriangleMesh& mesh) {
  return {.points = mesh.vertices, .normals = mesh.normals};
}

std::vector<double> to_numbers(const Eigen::Isometry3d& a_from_b) {
  std::vector<double> numbers;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers.push_back(a_from_b.matrix()(row, column));
  }
  return numbers;
}

}  // namespace mor::peers
