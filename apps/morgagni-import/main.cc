// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Reads a CT that nobody vouches for and hands it to the process that started it. See
// morgagni/ct/import_protocol.h.
#include <cstdio>
#include <cstdlib>

#include <sys/stat.h>

#include "import_job.h"
#include "messages.h"
#include "sandbox.h"

int main(int argc, char** argv) {
  struct stat info {};
  if (argc != 4 || ::fstat(mor::kImportVoxelsFd, &info) != 0) {
    std::fputs("morgagni-import is started by morgagni, it is of no use alone.\n", stderr);
    return 2;
  }
  auto done = mor::import::give_up_rights(argv[2]);
  if (done) done = mor::import::do_job({argv[1], argv[2], argv[3]});
  if (!done) {
    mor::import::say_error(done.error());
    std::_Exit(1);
  }
  // All is said and handed over. What the libraries would tidy up now takes time, and after a
  // hostile file who knows what it would do.
  std::_Exit(0);
}
