// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Stands where morgagni-import stands: hands its job to the fork server and ends as that job ended.
// Small and linked statically, for it is started thousands of times.
#include <array>
#include <cstdlib>
#include <string>

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "morgagni/ct/import_protocol.h"

#include "fork_server.h"
#include "packet.h"

int main(int argc, char** argv) {
  const char* socket_path = std::getenv(mor::fork_server::kSocketVariable);
  if (argc != 4 || socket_path == nullptr) return 2;
  std::string text;
  for (int i = 1; i < argc; ++i) text.append(argv[i]).push_back('\0');
  const int server = mor::fork_server::connect_to(socket_path);
  mor::fork_server::Packet packet(text.data(), text.size());
  packet.attach({mor::kImportMessagesFd, mor::kImportVoxelsFd});
  if (server < 0 || ::sendmsg(server, &packet.head, 0) < 0) return 3;
  // The parent hears the end of the messages when the last who can send some has closed them.
  ::close(mor::kImportMessagesFd);
  mor::fork_server::ImportEnd end;
  if (::recv(server, &end, sizeof(end), 0) != sizeof(end)) return 3;
  if (!WIFSIGNALED(end.status)) return WEXITSTATUS(end.status);
  const rlimit no_core = {0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::signal(WTERMSIG(end.status), SIG_DFL);
  ::raise(WTERMSIG(end.status));
  return 3;
}
