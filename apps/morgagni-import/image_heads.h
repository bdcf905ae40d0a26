// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor::import {

enum class ImageFormat : std::uint8_t { kNone, kNifti, kNrrd, kMetaImage };

/// The format that a file's name ends with.
[[nodiscard]] ImageFormat image_format_of(const std::filesystem::path& path);

/// Refuses heads that ITK and what is beneath it never end with, or end the process over.
/// @errors kIo: it is not what its name says. kUnsupported: dimensions that no CT has.
[[nodiscard]] Result<void> check_head(const std::filesystem::path& path, ImageFormat format);

/// How many bytes can belong to an image: the file's, and those of all files beside a head that may
/// name them (.mhd, .nhdr).
[[nodiscard]] std::uintmax_t bytes_for_voxels(const std::filesystem::path& path);

/// Whether the file holds the voxels that its head announces: ITK takes what is cut short without a
/// word. @errors kIo.
[[nodiscard]] Result<void> check_length(const std::filesystem::path& path,
                                        ImageFormat format,
                                        std::uintmax_t num_voxels,
                                        std::uintmax_t num_bytes);

}  // namespace mor::import
