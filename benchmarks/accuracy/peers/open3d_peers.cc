// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Open3D on a set of problems: open3d_peers PROBLEMS, see answering.h.
#include <cstdio>

#include <open3d/utility/Logging.h>

#include "open3d_methods.h"

int main(int argc, char** argv) {
  using namespace mor::peers;
  const auto problems = read_problems(argc > 1 ? argv[1] : "");
  if (!problems) {
    std::fprintf(stderr, "open3d_peers: %s\n", problems.error().message.c_str());
    return 1;
  }
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  const auto fixed = std::make_shared<const Open3dFixed>(problems->fixed, problems->is_tracked);
  MethodMakers makers;
  add_open3d_icp(fixed, makers);
  add_open3d_global(fixed, makers);
  return answer_requests(*problems, makers);
}
