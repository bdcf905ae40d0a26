// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "morgagni/ct/volume_import.h"

namespace mor {

/// A test that imports files of its own making from a folder of its own.
class ImportFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "_" + info->name();
    for (char& letter : name)
      if (letter == '/') letter = '_';
    folder_ = std::filesystem::temp_directory_path() /
              ("morgagni_" + name + "_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  static std::string error_of(const std::filesystem::path& path, const std::string& series = {}) {
    const auto volume = import_volume(path, {series}, {});
    return volume ? "no error" : volume.error().message;
  }

  std::filesystem::path folder_;
};

}  // namespace mor
