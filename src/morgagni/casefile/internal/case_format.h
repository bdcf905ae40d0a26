// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The names that both the writer (prepare.cc) and the reader (case.cc) of case.json use.
namespace mor::internal {

/// Raised when an older program could no longer read the folder.
inline constexpr int kCaseFormat = 1;

inline constexpr const char* kSkinFile = "skin.ply";
inline constexpr const char* kFieldFile = "skin.field";
inline constexpr const char* kPreviewFile = "body.png";
inline constexpr const char* kBoneFile = "bone.ply";
inline constexpr const char* kVolumeFile = "body.volume";

}  // namespace mor::internal
