// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "morgagni/core/result.h"

/// What image_heads.h is put together from: each format's own.
namespace mor::import {

[[nodiscard]] std::string lower_case(std::string text);
[[nodiscard]] std::vector<std::string> words_of(const std::string& text);

/// @param sides  As the file writes them, along x, y and z; those it does not name are not judged.
[[nodiscard]] Result<void> check_sides(const std::string& name,
                                       std::span<const std::int64_t> sides);
[[nodiscard]] Result<void> refuse_dimensions(const std::filesystem::path& path,
                                             long num_dimensions);

[[nodiscard]] Result<void> check_nifti_head(const std::filesystem::path& path);
/// All of it is read through once.
[[nodiscard]] Result<void> check_nifti_length(const std::filesystem::path& path,
                                              std::uintmax_t num_voxels);
[[nodiscard]] Result<void> check_nrrd_head(const std::filesystem::path& path);
/// Of voxels that stand behind the head as they are.
[[nodiscard]] Result<void> check_nrrd_length(const std::filesystem::path& path,
                                             std::uintmax_t num_bytes);
/// MetaIO never ends with a head in which a number is missing or none.
[[nodiscard]] Result<void> check_meta_head(const std::filesystem::path& path);
[[nodiscard]] Result<void> check_meta_length(const std::filesystem::path& path,
                                             std::uintmax_t num_bytes);

}  // namespace mor::import
