// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/casefile/testing/synthetic_ct.h"

namespace mor::testing_case {

/// A case prepared from the synthetic CT, made once a process.
/// @param name  Of its folder among the tests' files: no two test programs may share one.
inline std::shared_ptr<const Case> synthetic_case(const std::string& name) {
  static const auto kCase = [&name] {
    const auto place = std::filesystem::path(::testing::TempDir()) / name;
    std::filesystem::create_directories(place);
    testing_ct::write_synthetic_ct(place / "egg.mha");
    PrepareOptions options;
    options.skin.num_vertices = 4000;
    options.bone.num_triangles = 2000;
    const auto made =
        prepare_case(place / "egg.mha", place / "case", options, [](std::string_view, double) {});
    EXPECT_TRUE(made) << made.error().message;
    return std::make_shared<const Case>(load_case(place / "case").value());
  }();
  return kCase;
}

}  // namespace mor::testing_case
