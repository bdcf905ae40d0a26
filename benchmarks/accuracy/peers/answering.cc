// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "answering.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <unistd.h>

namespace mor::peers {
namespace {

using Json = nlohmann::json;

double cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

double wall_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

Json timed_run(Method& method, const Eigen::Isometry3d& init) {
  const double wall_start_ms = wall_ms();
  const double cpu_start_ms = cpu_ms();
  const std::optional<Eigen::Isometry3d> fixed_from_moving = method.align(init);
  const double cpu_end_ms = cpu_ms();
  const double wall_end_ms = wall_ms();
  return {{"pose", fixed_from_moving ? Json(to_numbers(*fixed_from_moving)) : Json()},
          {"wall_ms", wall_end_ms - wall_start_ms},
          {"cpu_ms", cpu_end_ms - cpu_start_ms}};
}

Json answer(const ProblemSet& problems,
            const MethodMakers& makers,
            std::map<std::string, std::unique_ptr<Method>>& methods,
            const std::string& request) {
  std::istringstream words(request);
  std::string name;
  std::size_t frame_idx = 0;
  std::size_t num_runs = 0;
  words >> name >> frame_idx >> num_runs;
  if (!words || !makers.contains(name) || frame_idx >= problems.frames.size()) {
    throw std::invalid_argument("no such method or frame: " + request);
  }
  auto& method = methods[name];
  if (!method) method = makers.at(name)();
  const ProblemFrame& frame = problems.frames[frame_idx];
  method->set_frame(frame);
  const TriangleMesh* moving = nullptr;
  Json runs = Json::array();
  for (std::size_t i = 0; i < std::min(num_runs, frame.runs.size()); ++i) {
    const TriangleMesh* cloud = &frame.clouds[frame.runs[i].cloud_idx];
    if (cloud != moving) method->set_moving(*cloud);
    moving = cloud;
    runs.push_back(timed_run(*method, frame.runs[i].fixed_from_moving_init));
  }
  return {{"runs", runs}};
}

}  // namespace

int answer_requests(const ProblemSet& problems, const MethodMakers& makers) {
  std::FILE* answers = fdopen(dup(STDOUT_FILENO), "w");
  if (answers == nullptr || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return 1;
  std::map<std::string, std::unique_ptr<Method>> methods;
  for (std::string request; std::getline(std::cin, request);) {
    Json json;
    try {
      json = answer(problems, makers, methods, request);
    } catch (const std::exception& error) {
      json = {{"error", error.what()}};
    }
    std::fprintf(answers, "%s\n", json.dump().c_str());
    std::fflush(answers);
  }
  std::fclose(answers);
  return 0;
}

}  // namespace mor::peers
