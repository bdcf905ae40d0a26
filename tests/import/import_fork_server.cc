// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// Thousands of import processes in little time: what morgagni-import is once its libraries are
// loaded, forked for each job. The child does what apps/morgagni-import/main.cc does, with the same
// readers, limits and rights; only exec and the dynamic linker's work are saved.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include "fork_server.h"
#include "import_job.h"
#include "messages.h"
#include "packet.h"
#include "sandbox.h"

namespace {

using mor::fork_server::ImportEnd;
using mor::fork_server::ImportPeaks;

/// "TASK\0PATH\0SERIES"
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t start = 0; start <= text.size();) {
    const auto end = std::min(text.find('\0', start), text.size());
    words.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  words.resize(3);
  return words;
}

[[noreturn]] void import_here(const std::vector<std::string>& words, std::array<int, 2> files) {
  // First out of the way of the two numbers, then onto them, and nothing else stays open.
  for (int& fd : files) fd = ::fcntl(fd, F_DUPFD, 64);
  ::dup2(files[0], mor::kImportMessagesFd);
  ::dup2(files[1], mor::kImportVoxelsFd);
  ::close_range(mor::kImportVoxelsFd + 1, ~0U, 0);
  auto done = mor::import::give_up_rights(words[1]);
  if (done) done = mor::import::do_job({words[0], words[1], words[2]});
  if (!done) {
    mor::import::say_error(done.error());
    std::_Exit(1);
  }
  std::_Exit(0);
}

/// Whoever kills the launcher means the import.
void kill_with_launcher(int connection, pid_t child) {
  const int end_of_child = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  std::array<pollfd, 2> waiting = {{{connection, 0, 0}, {end_of_child, POLLIN, 0}}};
  while (::poll(waiting.data(), waiting.size(), -1) < 0 && errno == EINTR) {
  }
  if (waiting[1].revents == 0) ::kill(child, SIGKILL);
  ::close(end_of_child);
}

ImportEnd import(int connection, const std::string& text, const std::array<int, 2>& files) {
  const pid_t child = ::fork();
  if (child == 0) import_here(words_of(text), files);
  for (const int fd : files) ::close(fd);
  kill_with_launcher(connection, child);
  ImportEnd end;
  rusage used{};
  int status = 0;
  while (::wait4(child, &status, 0, &used) < 0 && errno == EINTR) {
  }
  end.status = status;
  end.max_rss_kib = used.ru_maxrss;
  end.cpu_us = 1'000'000LL * (used.ru_utime.tv_sec + used.ru_stime.tv_sec) + used.ru_utime.tv_usec +
               used.ru_stime.tv_usec;
  return end;
}

void count(const ImportEnd& end, ImportPeaks& peaks) {
  ++peaks.num_imports;
  if (WIFSIGNALED(end.status)) ++peaks.num_killed;
  peaks.max_rss_kib = std::max(peaks.max_rss_kib, end.max_rss_kib);
  peaks.max_cpu_us = std::max(peaks.max_cpu_us, end.cpu_us);
  peaks.sum_cpu_us += end.cpu_us;
}

void serve(int connection, ImportPeaks& peaks) {
  std::string text(mor::fork_server::kMaxPacketBytes, '\0');
  mor::fork_server::Packet packet(text.data(), text.size());
  const ssize_t got = ::recvmsg(connection, &packet.head, MSG_CMSG_CLOEXEC);
  if (got <= 0) return;
  text.resize(static_cast<std::size_t>(got));
  std::array<int, 2> files{};
  if (!packet.detach(files)) {
    (void)::send(connection, &peaks, sizeof(peaks), MSG_NOSIGNAL);
    return;
  }
  const ImportEnd end = import(connection, text, files);
  count(end, peaks);
  (void)::send(connection, &end, sizeof(end), MSG_NOSIGNAL);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: import_fork_server SOCKET\n", stderr);
    return 2;
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);  // It goes with the test that started it.
  const int listener = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  const sockaddr_un address = mor::fork_server::address_of(argv[1]);
  if (::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::listen(listener, 8) != 0) {
    std::perror("import_fork_server");
    return 1;
  }
  ImportPeaks peaks;
  for (;;) {
    const int connection = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection < 0) continue;
    serve(connection, peaks);
    ::close(connection);
  }
}
