// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/ct_series.h"
#include "morgagni/ct/label_map.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor::internal {

/// `morgagni-import` beside the running program, or in the folder `bin` beside that folder.
[[nodiscard]] Result<std::filesystem::path> find_import_program();

/// What the program is asked for (import_protocol.h).
struct ImportJob {
  std::string task;
  std::filesystem::path path;
  std::string series;  ///< Empty: the only one.
};

/// Runs `program` on a job and takes over the volume it hands back, believing nothing: sizes,
/// numbers and lengths are checked here again.
/// @errors What the program says; kIo when it dies, lies or falls silent; kTimeout after
/// `time_limit`.
[[nodiscard]] Result<Volume> run_import_process(const std::filesystem::path& program,
                                                const ImportJob& job,
                                                std::chrono::seconds time_limit,
                                                const Progress& progress);

/// The same for a label map.
[[nodiscard]] Result<LabelMap> run_label_process(const std::filesystem::path& program,
                                                 const ImportJob& job,
                                                 std::chrono::seconds time_limit,
                                                 const Progress& progress);

/// A mesh, and the frame that its file names ("LPS", "RAS" or nothing).
struct ImportedMesh {
  TriangleMesh mesh;
  std::string frame;
};
/// The same for a mesh. Its indices and numbers are checked here.
[[nodiscard]] Result<ImportedMesh> run_mesh_process(const std::filesystem::path& program,
                                                    const ImportJob& job,
                                                    std::chrono::seconds time_limit,
                                                    const Progress& progress);

/// The same for the series that the program finds.
[[nodiscard]] Result<std::vector<CtSeries>> run_series_process(const std::filesystem::path& program,
                                                               const ImportJob& job,
                                                               std::chrono::seconds time_limit,
                                                               const Progress& progress);

/// Which of its limits does not hold on this machine, a sentence; empty: they all do.
[[nodiscard]] Result<std::string> run_limits_process(const std::filesystem::path& program,
                                                     std::chrono::seconds time_limit);

}  // namespace mor::internal
