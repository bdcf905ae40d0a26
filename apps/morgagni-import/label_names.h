// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace mor::import {

/// Tells the parent the names and colours that a label map carries: 3D Slicer's keys in a NRRD's
/// head ("Segment0_Name:=liver"), or the label table in a NIfTI's head extension. Files without any
/// say nothing.
void say_label_names(const std::filesystem::path& path);

}  // namespace mor::import
