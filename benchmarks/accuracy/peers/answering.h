// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "problem.h"

namespace mor::peers {

/// One way to register. What concerns the fixed side alone is done before, off the clock.
class Method {
 public:
  virtual ~Method() = default;

  /// The frame that is registered next, for who wants the picture itself. Off the clock.
  virtual void set_frame(const ProblemFrame& /*frame*/) {}

  /// Brings the camera's cloud into the library's own types. Off the clock.
  /// @param moving  With triangles; alive until the next call.
  virtual void set_moving(const TriangleMesh& moving) = 0;

  /// Registers it. On the clock, with all that a new frame asks for: trees, covariances, features.
  /// @return fixed_from_moving; none where the method itself says that it found nothing.
  virtual std::optional<Eigen::Isometry3d> align(
      const Eigen::Isometry3d& fixed_from_moving_init) = 0;
};

/// Made when it is first asked for.
using MethodMakers = std::map<std::string, std::function<std::unique_ptr<Method>()>>;

/// Answers, one line each on stdout, what comes in lines on stdin: `METHOD FRAME RUNS` does the
/// first RUNS runs of a frame and answers
/// {"runs": [{"pose": [16 numbers, row by row] or null, "wall_ms", "cpu_ms"}, ...]} or
/// {"error": "..."}.
/// Processor time is that of the whole process, so that helping threads count too. What libraries
/// print to stdout goes to stderr.
/// @return The program's exit status.
int answer_requests(const ProblemSet& problems, const MethodMakers& makers);

}  // namespace mor::peers
