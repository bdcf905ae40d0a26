// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// One file of the format that MOR_FUZZ_ENDING names, read as MOR_FUZZ_TASK (import_protocol.h); of
// a file of several maps the first and the second.
#include <string>

#include "import_job.h"
#include "surroundings.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  std::string name = "input" MOR_FUZZ_ENDING;
  const bool is_gzip = size > 2 && data[0] == 0x1f && data[1] == 0x8b;
  if (is_gzip && name == "input.nii") name += ".gz";
  const auto path = mor::fuzz::write(name, bytes);
  (void)mor::import::do_job({MOR_FUZZ_TASK, path, {}});
  mor::fuzz::take_over();
  if (name == "input.dcm") {
    (void)mor::import::do_job({MOR_FUZZ_TASK, path, "2"});
    mor::fuzz::take_over();
  }
  return 0;
}
