// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_heads.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>

#include "morgagni/ct/import_protocol.h"

#include "head_checks.h"

namespace mor::import {

namespace fs = std::filesystem;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return text;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

Result<void> check_sides(const std::string& name, std::span<const std::int64_t> sides) {
  constexpr std::int64_t kFewest = 2;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(sides.size(), 3); ++axis) {
    if (sides[axis] >= kFewest && sides[axis] <= kMaxVolumeSide) continue;
    return make_error(ErrorCode::kInvalidArgument,
                      name + " has " + std::to_string(sides[axis]) + " voxels along " +
                          "xyz"[axis] + ", the limits are " + std::to_string(kFewest) + " and " +
                          std::to_string(kMaxVolumeSide));
  }
  return {};
}

Result<void> refuse_dimensions(const fs::path& path, long num_dimensions) {
  return make_error(ErrorCode::kUnsupported,
                    path.filename().string() + " has " + std::to_string(num_dimensions) +
                        " dimensions, a CT has 3: give a volume");
}

ImageFormat image_format_of(const fs::path& path) {
  const std::string name = lower_case(path.filename().string());
  const auto is_any = [&](std::string_view a, std::string_view b) {
    return name.ends_with(a) || name.ends_with(b);
  };
  if (is_any(".nii", ".nii.gz")) return ImageFormat::kNifti;
  if (is_any(".nrrd", ".nhdr")) return ImageFormat::kNrrd;
  if (is_any(".mha", ".mhd")) return ImageFormat::kMetaImage;
  return ImageFormat::kNone;
}

Result<void> check_head(const fs::path& path, ImageFormat format) {
  switch (format) {
    case ImageFormat::kNifti:
      return check_nifti_head(path);
    case ImageFormat::kNrrd:
      return check_nrrd_head(path);
    case ImageFormat::kMetaImage:
      return check_meta_head(path);
    case ImageFormat::kNone:
      break;
  }
  return {};
}

std::uintmax_t bytes_for_voxels(const fs::path& path) {
  const std::string ending = lower_case(path.extension().string());
  std::error_code failure;
  const auto own = fs::file_size(path, failure);
  if (failure) return 0;
  if (ending != ".mhd" && ending != ".nhdr") return own;
  constexpr int kMaxFiles = 20000;
  int num_files = 0;
  std::uintmax_t all = 0;
  const auto folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure)) {
    if (++num_files > kMaxFiles) break;
    std::error_code no_file;
    const auto bytes = fs::file_size(it->path(), no_file);
    if (!no_file) all += bytes;
  }
  return all;
}

Result<void> check_length(const fs::path& path,
                          ImageFormat format,
                          std::uintmax_t num_voxels,
                          std::uintmax_t num_bytes) {
  if (format == ImageFormat::kNifti) return check_nifti_length(path, num_voxels);
  if (format == ImageFormat::kNrrd) return check_nrrd_length(path, num_bytes);
  if (format == ImageFormat::kMetaImage) return check_meta_length(path, num_bytes);
  return {};
}

}  // namespace mor::import
