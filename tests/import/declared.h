// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor {

/// Judges an answer by what the file itself declares, found in the plainest way: not through any
/// reader. @return What contradicts it; empty where nothing does.
[[nodiscard]] std::string contradiction(std::string_view format,
                                        const std::string& bytes,
                                        const Volume& volume);
[[nodiscard]] std::string contradiction(std::string_view format,
                                        const std::string& bytes,
                                        const TriangleMesh& mesh);

}  // namespace mor
