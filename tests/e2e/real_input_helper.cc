// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// What tests/e2e/real_input_test.py needs of the program's inside.
//
//   real_input_helper dump CASE CAMERA COUNT FOLDER   a fakenect dump of a simulated Kinect
//   real_input_helper replay CASE RECORDING FOLDER    tracks a session's recording twice, as JSON

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/internal/kinect/kinect_depth.h"
#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/simulated_camera.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/files.h"
#include "morgagni/core/log.h"
#include "morgagni/session/live_loop.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint32_t kFirstTicks = 1000;
constexpr std::uint32_t kTicksPerFrame = 2000000;  // Of 60 MHz: 30 frames a second.

template <class T>
T value_or_end(Result<T> result) {
  if (!result) {
    fmt::print(stderr, "{}\n", result.error().message);
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

std::shared_ptr<const Case> open_case(const fs::path& folder) {
  return std::make_shared<const Case>(value_or_end(load_case(folder)));
}

std::shared_ptr<const TriangleMesh> skin_of(const std::shared_ptr<const Case>& body) {
  return {body, &body->skin->mesh};
}

/// Of each millimetre the raw value that comes nearest.
std::vector<std::uint16_t> raw_from_mm() {
  const auto mm = internal::kinect_mm_from_raw({});
  std::vector<std::uint16_t> raw(65536, internal::kKinectNoReading);
  for (std::size_t i = 1; i < mm.size(); ++i) {
    if (mm[i - 1] == 0 || mm[i] == 0) continue;
    for (int z = mm[i - 1]; z <= mm[i]; ++z) {
      const bool first_is_nearer = z - mm[i - 1] < mm[i] - z;
      raw[static_cast<std::size_t>(z)] = static_cast<std::uint16_t>(first_is_nearer ? i - 1 : i);
    }
  }
  return raw;
}

void write_binary(const fs::path& path, std::string_view head, const void* data, std::size_t size) {
  std::ofstream out(path, std::ios::binary);
  out << head;
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
}

/// The pose of each frame of the dump, for the comparison: 12 numbers a line, by rows.
void write_truth(std::ofstream& out, const Eigen::Isometry3d& ct_from_camera) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      out << fmt::format("{:.17g} ", ct_from_camera(row, column));
  out << "\n";
}

void dump(const fs::path& case_folder, const std::string& name, int count, const fs::path& folder) {
  const auto body = open_case(case_folder);
  const auto options = value_or_end(SimulatedCameraOptions::parse(name));
  const auto camera = value_or_end(SimulatedCamera::create(skin_of(body), options));
  const auto raw_of = raw_from_mm();
  fs::create_directories(folder);
  std::ofstream index(folder / "INDEX.txt");
  std::ofstream truth(folder / "truth.txt");
  std::vector<std::uint16_t> raw(internal::kKinectPixels);
  for (int i = 0; i < count; ++i) {
    const auto frame = camera->frame_at(static_cast<std::uint64_t>(i));
    for (int y = 0; y < internal::kKinectHeightPx; ++y)
      for (int x = 0; x < internal::kKinectWidthPx; ++x)
        raw[static_cast<std::size_t>(y * internal::kKinectWidthPx + x)] =
            raw_of[frame->depth_mm(x, y)];
    std::vector<Rgb8> colors;
    for (int y = 0; y < internal::kKinectHeightPx; ++y)
      for (int x = 0; x < internal::kKinectWidthPx; ++x) colors.push_back(frame->color(x, y));
    const auto ticks = kFirstTicks + static_cast<std::uint32_t>(i) * kTicksPerFrame;
    const auto time = fmt::format("{:.6f}", 1300000000.0 + i / 30.0);
    const auto color_name = fmt::format("r-{}-{}.ppm", time, ticks);
    const auto depth_name = fmt::format("d-{}-{}.pgm", time, ticks);
    static_assert(sizeof(Rgb8) == 3);
    write_binary(folder / color_name, "P6 640 480 255\n", colors.data(), colors.size() * 3);
    write_binary(folder / depth_name, "P5 640 480 65535\n", raw.data(), raw.size() * 2);
    index << color_name << "\n" << depth_name << "\n";
    write_truth(truth, camera->ct_from_camera(static_cast<std::uint64_t>(i)));
  }
  value_or_end(write_file(folder / "kinect.json", calibration_to_json(camera->calibration())));
}

/// What the tracking made of a recording's frames.
struct Round {
  std::vector<TrackingState> states;
  std::vector<std::optional<Eigen::Isometry3d>> poses;
};

/// As `morgagni serve --camera mcap:FILE,speed=full` does.
Round replay(const std::shared_ptr<const Case>& body, const fs::path& recording, std::size_t size) {
  LiveLoopOptions options;
  options.in_step = true;
  auto camera =
      value_or_end(open_camera("mcap:" + recording.string() + ",speed=full", skin_of(body)));
  const auto loop = value_or_end(LiveLoop::create(body, std::move(camera), options));
  Round round;
  std::mutex mutex;
  std::condition_variable changed;
  loop->observe([&](const TrackedFrame& tracked) {
    const std::lock_guard lock(mutex);
    round.states.push_back(tracked.state);
    round.poses.push_back(tracked.ct_from_depth);
    changed.notify_all();
  });
  value_or_end(loop->run([](ImageView<const Rgba8>, const PictureInfo&) {}));
  std::unique_lock lock(mutex);
  changed.wait_for(lock, std::chrono::minutes(5), [&] { return round.poses.size() >= size; });
  lock.unlock();
  loop->stop();
  return round;
}

/// How far apart two poses bring the skin, on average.
double distance_mm(const Eigen::Isometry3d& a,
                   const Eigen::Isometry3d& b,
                   const TriangleMesh& skin) {
  const Eigen::Isometry3d a_from_b = a * b.inverse();
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < skin.vertices.size(); i += 50) {
    const Eigen::Vector3d vertex = skin.vertices[i].template cast<double>();
    sum += (a_from_b * vertex - vertex).norm();
    ++count;
  }
  return sum / static_cast<double>(count);
}

std::vector<Eigen::Isometry3d> read_truth(const fs::path& folder) {
  std::ifstream in(folder / "truth.txt");
  std::vector<Eigen::Isometry3d> poses;
  std::array<double, 12> numbers{};
  while (true) {
    for (double& number : numbers) in >> number;
    if (!in) return poses;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) pose.matrix()(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
    poses.push_back(pose);
  }
}

bool is_same(const std::optional<Eigen::Isometry3d>& a, const std::optional<Eigen::Isometry3d>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || std::memcmp(a->matrix().data(), b->matrix().data(), sizeof(double) * 16) == 0;
}

Json summary_of(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  return {{"median", values[values.size() / 2]}, {"largest", values.back()}};
}

void compare(const fs::path& case_folder, const fs::path& file, const fs::path& dump_folder) {
  const auto body = open_case(case_folder);
  const auto& skin = body->skin->mesh;
  const auto recording = value_or_end(McapRecording::open(file));
  const auto truth = read_truth(dump_folder);
  const auto first = replay(body, file, recording.size());
  const auto second = replay(body, file, recording.size());
  std::size_t num_same = 0;
  std::size_t num_tracked = 0;
  std::vector<std::size_t> untracked;
  std::vector<double> from_live_mm;
  std::vector<double> live_error_mm;
  std::vector<double> replay_error_mm;
  for (std::size_t i = 0; i < std::min(first.poses.size(), second.poses.size()); ++i) {
    num_same += is_same(first.poses[i], second.poses[i]) && first.states[i] == second.states[i];
    const bool tracked = first.states[i] == TrackingState::kTracking;
    num_tracked += tracked;
    if (!tracked) untracked.push_back(i);
    const auto frame = value_or_end(recording.read(i));
    const auto ticks = static_cast<double>(frame->device_time->count()) * 60e6 / 1e9;
    const auto index = static_cast<std::size_t>(
        std::llround((ticks - kFirstTicks) / static_cast<double>(kTicksPerFrame)));
    const auto live = value_or_end(recording.pose(i));
    const bool was_tracked = live && live->state == "tracking" && live->ct_from_depth;
    if (was_tracked && index < truth.size())
      live_error_mm.push_back(distance_mm(*live->ct_from_depth, truth[index], skin));
    if (tracked && index < truth.size())
      replay_error_mm.push_back(distance_mm(*first.poses[i], truth[index], skin));
    if (tracked && was_tracked)
      from_live_mm.push_back(distance_mm(*first.poses[i], *live->ct_from_depth, skin));
  }
  const Json json = {{"frames", recording.size()},
                     {"replayed", {first.poses.size(), second.poses.size()}},
                     {"same_poses", num_same},
                     {"tracked", num_tracked},
                     {"untracked", untracked},
                     {"live_to_replay_mm", summary_of(from_live_mm)},
                     {"live_error_mm", summary_of(live_error_mm)},
                     {"replay_error_mm", summary_of(replay_error_mm)}};
  fmt::print("{}\n", json.dump());
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  mor::log::set_up(false);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 5 && arguments[0] == "dump") {
    mor::dump(arguments[1], arguments[2], std::stoi(arguments[3]), arguments[4]);
  } else if (arguments.size() == 4 && arguments[0] == "replay") {
    mor::compare(arguments[1], arguments[2], arguments[3]);
  } else {
    fmt::print(stderr, "dump CASE CAMERA COUNT FOLDER | replay CASE RECORDING FOLDER\n");
    return 2;
  }
  return 0;
}
