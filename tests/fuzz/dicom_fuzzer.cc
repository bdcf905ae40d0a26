// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// A DICOM file as the third slice of a series; several frames, segmentations and archives alone.
#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/testing/sample_files.h"

#include "import_job.h"
#include "surroundings.h"

namespace {

bool holds(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  std::filesystem::create_directories(mor::fuzz::scratch_folder() / "series");
  for (const auto& slice : mor::testing_files::sample_neighbours())
    mor::fuzz::write("series/" + slice.name, std::as_bytes(std::span(slice.bytes)));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace std::string_view_literals;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const bool is_alone = text.starts_with("PK") || holds(text, "\0\x52\x30\x92"sv) ||
                        holds(text, "\x04\0\x20\x12"sv) || holds(text, "SEG");
  const auto path =
      mor::fuzz::write(is_alone ? "alone" : "series/2", std::as_bytes(std::span(data, size)));
  if (holds(text, "SEG")) {
    (void)mor::import::do_job({mor::kReadLabelsTask, path, {}});
  } else if (is_alone) {
    (void)mor::import::do_job({mor::kReadVolumeTask, path, {}});
  } else {
    (void)mor::import::do_job({mor::kReadVolumeTask, path.parent_path(), {}});
    (void)mor::import::do_job({mor::kListSeriesTask, path.parent_path(), {}});
  }
  mor::fuzz::take_over();
  return 0;
}
