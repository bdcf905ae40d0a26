// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/ground_truth.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/statistics.h"
#include "morgagni/evaluation/summary.h"

namespace mor {
namespace {

constexpr std::uintmax_t kMaxFileBytes = 64U << 20U;
constexpr double kMillimetresPerMetre = 1000.0;
constexpr double kMaxOffSkinMm = 10.0;
constexpr double kMaxOffSkinAfterShiftMm = 3.0;
/// RAS and LPS differ by half a turn about the body's long axis; it is its own inverse.
const Eigen::DiagonalMatrix<double, 3> kLpsFromRas(-1.0, -1.0, 1.0);

/// The parts of a line between separators; runs of blanks count as one.
std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = line.find(separator);
    const std::string_view part = line.substr(0, end);
    if (separator != ' ' || !part.empty()) parts.push_back(part);
    if (end == std::string_view::npos) return parts;
    line.remove_prefix(end + 1);
  }
}

std::optional<double> parse_number(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

template <std::size_t N>
std::optional<std::array<double, N>> parse_numbers(const std::vector<std::string_view>& parts,
                                                   std::size_t first) {
  if (parts.size() != first + N) return std::nullopt;
  std::array<double, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto number = parse_number(parts[first + i]);
    if (!number) return std::nullopt;
    numbers[i] = *number;
  }
  return numbers;
}

std::optional<TimedPose> parse_pose(std::string_view line) {
  const auto numbers = parse_numbers<8>(split(line, ' '), 0);
  if (!numbers) return std::nullopt;
  const auto& [time, tx, ty, tz, qx, qy, qz, qw] = *numbers;
  const Eigen::Quaterniond rotation(qw, qx, qy, qz);
  if (std::abs(rotation.norm() - 1.0) > 1e-3) return std::nullopt;
  TimedPose pose;
  pose.timestamp_s = time;
  pose.ct_from_depth.linear() = kLpsFromRas * rotation.normalized().toRotationMatrix();
  pose.ct_from_depth.translation() =
      kLpsFromRas * (kMillimetresPerMetre * Eigen::Vector3d(tx, ty, tz));
  return pose;
}

std::optional<Target> parse_target(std::string_view line) {
  const auto parts = split(line, ',');
  const auto numbers = parse_numbers<3>(parts, 2);
  if (!numbers || parts[0].empty()) return std::nullopt;
  if (parts[1] != "skin" && parts[1] != "internal") return std::nullopt;
  Target target;
  target.name = parts[0];
  target.on_skin = parts[1] == "skin";
  target.ct = kLpsFromRas * Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  return target;
}

/// Parses each line that says something. `what` names a line's form for the error.
template <class T, class Parse>
Result<std::vector<T>> read_lines(const std::filesystem::path& path,
                                  const Parse& parse,
                                  std::string_view header,
                                  std::string_view what) {
  MOR_TRY(const std::string text, read_text_file(path, kMaxFileBytes));
  std::vector<T> values;
  std::size_t number = 0;
  for (std::string_view line : split(text, '\n')) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.front() == '#' || line == header) continue;
    auto value = parse(line);
    if (!value) {
      return make_error(ErrorCode::kInvalidArgument,
                        fmt::format("{}, line {}: expected {}", path.string(), number, what));
    }
    values.push_back(*std::move(value));
  }
  if (values.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} holds no line of {}", path.string(), what));
  }
  return values;
}

/// Distances of the skin targets to the skin when they are moved by `shift`; a target beyond the
/// field counts as at its edge.
std::vector<double> off_skin_mm(const std::vector<Target>& targets,
                                const DistanceField& skin,
                                const Eigen::Vector3d& shift) {
  std::vector<double> distances_mm;
  for (const auto& target : targets) {
    if (!target.on_skin) continue;
    const Eigen::Vector3f p = (target.ct + shift).cast<float>();
    FieldSample sample;
    const bool known = DistanceField::look_up(skin.fine(), p, sample) ||
                       DistanceField::look_up(skin.coarse(), p, sample);
    distances_mm.push_back(
        static_cast<double>(known ? std::abs(sample.distance_mm) : skin.coarse().band_mm));
  }
  return distances_mm;
}

/// The centre among the conventions that leaves the targets nearest to the skin, on average.
Eigen::Vector3d best_center(const std::vector<Target>& targets,
                            const DistanceField& skin,
                            const Eigen::Vector3d& volume_center,
                            const Eigen::Vector3d& half_voxel) {
  Eigen::Vector3d best = volume_center;
  double best_mm = summarize(off_skin_mm(targets, skin, volume_center)).mean;
  const Eigen::Vector3d in_plane(half_voxel.x(), half_voxel.y(), 0.0);
  const Eigen::Vector3d along_slices(0.0, 0.0, half_voxel.z());
  for (const Eigen::Vector3d& shift :
       {in_plane, along_slices, Eigen::Vector3d(in_plane + along_slices)}) {
    const double mean_mm = summarize(off_skin_mm(targets, skin, volume_center + shift)).mean;
    if (mean_mm >= best_mm) continue;
    best_mm = mean_mm;
    best = volume_center + shift;
  }
  return best;
}

}  // namespace

Result<std::vector<TimedPose>> read_ground_truth(const std::filesystem::path& path) {
  return read_lines<TimedPose>(path, parse_pose, "", "time tx ty tz qx qy qz qw");
}

Result<std::vector<Target>> read_targets(const std::filesystem::path& path) {
  return read_lines<Target>(
      path, parse_target, "name,kind,x_mm,y_mm,z_mm", "name,skin|internal,x_mm,y_mm,z_mm");
}

std::optional<Eigen::Isometry3d> truth_at(const std::vector<TimedPose>& truth, double time_s) {
  const TimedPose* best = nullptr;
  double best_lag_s = kMaxTruthLagS;
  for (const auto& pose : truth) {
    const double lag_s = std::abs(pose.timestamp_s - time_s);
    if (lag_s > best_lag_s) continue;
    best_lag_s = lag_s;
    best = &pose;
  }
  if (best == nullptr) return std::nullopt;
  return best->ct_from_depth;
}

Result<AlignedTruth> align_truth_to_case(std::vector<TimedPose> poses,
                                         std::vector<Target> targets,
                                         TruthFrame frame,
                                         const DistanceField& skin,
                                         const Eigen::Vector3d& volume_center,
                                         const Eigen::Vector3d& half_voxel) {
  const Eigen::Vector3d center = best_center(targets, skin, volume_center, half_voxel);
  const double as_given_mm = quantile(off_skin_mm(targets, skin, Eigen::Vector3d::Zero()), 0.5);
  const double shifted_mm = quantile(off_skin_mm(targets, skin, center), 0.5);
  const bool shift =
      frame == TruthFrame::kCentred || (frame == TruthFrame::kAuto && as_given_mm > kMaxOffSkinMm &&
                                        shifted_mm < kMaxOffSkinAfterShiftMm);
  const double found_mm = shift ? shifted_mm : as_given_mm;
  const double limit_mm = shift ? kMaxOffSkinAfterShiftMm : kMaxOffSkinMm;
  if (found_mm > limit_mm) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("the skin targets are {:.1f} mm off the case's skin (median, at most {} mm "
                    "allowed): do they belong to another case?",
                    found_mm,
                    limit_mm));
  }
  AlignedTruth aligned{std::move(poses), std::move(targets), {}};
  if (!shift) return aligned;
  for (auto& pose : aligned.poses) pose.ct_from_depth.pretranslate(center);
  for (auto& target : aligned.targets) target.ct += center;
  aligned.warning = fmt::format(
      "truth and targets have their origin at the centre of the CT volume: both were shifted by "
      "({:.2f}, {:.2f}, {:.2f}) mm, which puts the skin targets {:.2f} mm off the skin (median)",
      center.x(),
      center.y(),
      center.z(),
      found_mm);
  return aligned;
}

}  // namespace mor
