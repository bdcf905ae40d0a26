// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"
#include "morgagni/ct/ct_series.h"
#include "morgagni/ct/import_protocol.h"

namespace mor::import {

/// The lines of the protocol (morgagni/ct/import_protocol.h). Sent at once, so that they arrive
/// even when the next step crashes.
void say_progress(double fraction);
void say_file(std::string_view name);
void say_note(std::string_view sentence);
/// Of a limit of this process that does not hold on this machine.
void say_weakness(std::string_view sentence);
void say_series(const CtSeries& series);
/// @param color  Red, green, blue, 0 to 1.
void say_label(int value, const std::array<double, 3>& color, std::string_view name);
/// How many label maps the file holds, of which one is handed over at a time.
void say_num_maps(std::size_t num_maps);
/// The frame that a mesh says it is in: "LPS" or "RAS".
void say_frame(std::string_view frame);
void say_error(const Error& error);

/// A number as people write it: 0.5, 39, 1e+300.
[[nodiscard]] std::string short_text(double number);

/// The first of the names, and how many more there are.
[[nodiscard]] std::string some_of(const std::vector<std::string>& names);

void set_description(ImportHeader& header, std::string_view text);

/// Writes the header to the parent's memory file and gives the place for the voxels behind it: what
/// is written there needs no copy to be handed over. @errors kIo.
[[nodiscard]] Result<std::span<std::int16_t>> open_voxels(const ImportHeader& header);

/// The place for a mesh behind its header: x, y, z of each vertex; three indices a triangle.
struct MeshPlace {
  std::span<float> positions;
  std::span<std::uint32_t> indices;
};
/// The same for a mesh. @errors kIo.
[[nodiscard]] Result<MeshPlace> open_mesh(const ImportMeshHeader& header);

}  // namespace mor::import
