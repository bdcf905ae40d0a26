// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// One DICOM connection, in a process of its own: morgagni/pacs/dimse_protocol.h.

#include <cstdio>
#include <cstdlib>
#include <string>

#include <openssl/ssl.h>

#include "morgagni/pacs/dimse_protocol.h"

#include "confine.h"
#include "dcmtk/config/osconfig.h"
#include "dcmtk/dcmdata/dcdict.h"
#include "dcmtk/oflog/oflog.h"
#include "messages.h"
#include "services.h"
#include "task.h"

namespace mor::dimse {
namespace {

std::string read_task() {
  std::string text;
  char buffer[4096];
  for (std::size_t count; (count = std::fread(buffer, 1, sizeof(buffer), stdin)) > 0;)
    text.append(buffer, count);
  return text;
}

/// What the libraries read from files of their own, while they still may.
void load_own_files() {
  (void)dcmDataDict.rdlock();
  dcmDataDict.rdunlock();
  (void)OPENSSL_init_ssl(0, nullptr);
}

Result<int> run(const Task& task) {
  load_own_files();
  MOR_CHECK(confine(task));
  if (task.name == kEcho) return echo(task);
  if (task.name == kFind) return find(task);
  if (task.name == kGet) return get(task);
  if (task.name == kMove) return move(task);
  if (task.name == kReceive) return receive(task);
  return make_error(ErrorCode::kInvalidArgument, "no such task: " + task.name);
}

}  // namespace
}  // namespace mor::dimse

int main() {
  using namespace mor::dimse;
  ::setenv("TCP_NODELAY", "1", 1);  // Else each object waits for a delayed acknowledgement.
  OFLog::configure(OFLogger::OFF_LOG_LEVEL);
  const auto task = parse_task(read_task());
  if (!task) {
    std::fputs("morgagni-dimse is started by morgagni, with a task on standard input.\n", stderr);
    return 2;
  }
  const auto outcome = run(*task);
  if (!outcome) {
    say_failed(outcome.error());
    return 1;
  }
  say_done(*outcome);
  return 0;
}
