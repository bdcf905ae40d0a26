// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/dimse_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/core/unique_fd.h"
#include "morgagni/pacs/dimse_protocol.h"

namespace mor::internal {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Above the numbers that the child gets.
constexpr int kFirstFreeFd = dimse::kSocketFd + 1;

UniqueFd above_the_fixed_ones(int fd) {
  const UniqueFd original(fd);
  return UniqueFd(::fcntl(fd, F_DUPFD_CLOEXEC, kFirstFreeFd));
}

/// The task as a file in memory: it needs nobody who writes while the child reads.
UniqueFd file_with(const std::string& text) {
  auto file = above_the_fixed_ones(::memfd_create("morgagni-task", MFD_CLOEXEC));
  std::size_t done = 0;
  while (file.get() >= 0 && done < text.size()) {
    const auto count = ::write(file.get(), text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) return UniqueFd();
    if (count > 0) done += static_cast<std::size_t>(count);
  }
  ::lseek(file.get(), 0, SEEK_SET);
  return file;
}

Result<pid_t> spawn(const fs::path& program, int task_fd, int messages_fd, int socket_fd) {
  const auto socket = above_the_fixed_ones(::dup(socket_fd));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, task_fd, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, messages_fd, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_RDWR, 0);
  if (socket.get() >= 0) posix_spawn_file_actions_adddup2(&actions, socket.get(), dimse::kSocketFd);
  posix_spawn_file_actions_addclosefrom_np(
      &actions, socket.get() >= 0 ? dimse::kSocketFd + 1 : dimse::kSocketFd);
  std::string name = program.string();
  std::array<char*, 2> arguments = {name.data(), nullptr};
  pid_t child = -1;
  const int failure =
      ::posix_spawn(&child, name.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure == 0) return child;
  return make_error(
      ErrorCode::kIo,
      fmt::format("cannot start {}: {}", name, std::generic_category().message(failure)));
}

/// Until the child closes its pipe. False: the time is over.
bool listen_to_child(int pipe_fd, Clock::time_point deadline, DimseTalk& talk) {
  std::array<char, 16384> buffer;
  while (!talk.is_broken()) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return false;
    constexpr long kMaxWaitMs = 60000;
    pollfd waiting{pipe_fd, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(std::min<long>(left.count(), kMaxWaitMs))) <= 0)
      continue;
    const auto count = ::read(pipe_fd, buffer.data(), buffer.size());
    if (count == 0 || (count < 0 && errno != EINTR)) break;
    if (count > 0) talk.hear({buffer.data(), static_cast<std::size_t>(count)});
  }
  return true;
}

/// The child's end, which is hastened where it does not come by itself.
int wait_for(pid_t child, bool kill_it) {
  const UniqueFd handle(static_cast<int>(::syscall(SYS_pidfd_open, child, 0)));
  constexpr int kPatienceMs = 2000;
  pollfd waiting{handle.get(), POLLIN, 0};
  if (kill_it || ::poll(&waiting, 1, kPatienceMs) <= 0) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

Result<fs::path> find_dimse_program() {
  std::error_code failure;
  const auto folder = fs::read_symlink("/proc/self/exe", failure).parent_path();
  for (const auto& candidate :
       {folder / dimse::kProgramName, folder.parent_path() / "bin" / dimse::kProgramName}) {
    if (fs::exists(candidate, failure)) return candidate;
  }
  return make_error(ErrorCode::kNotFound,
                    fmt::format("{} is missing: it belongs beside this program, in {}",
                                dimse::kProgramName,
                                folder.string()));
}

Result<int> run_dimse_process(const fs::path& program,
                              const DimseJob& job,
                              const DimseEvents& events,
                              std::stop_token stop) {
  const auto task = file_with(job.task);
  std::array<int, 2> ends = {-1, -1};
  if (task.get() < 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0)
    return make_error(ErrorCode::kIo, "too many open files to start another connection");
  const UniqueFd messages(ends[0]);
  auto child_end = above_the_fixed_ones(ends[1]);
  MOR_TRY(const auto child, spawn(program, task.get(), child_end.get(), job.socket_fd));
  child_end.reset();
  DimseTalk talk(events);
  bool in_time = true;
  {
    const std::stop_callback kill_child(stop, [child] { ::kill(child, SIGKILL); });
    in_time = listen_to_child(messages.get(), Clock::now() + job.time_limit, talk);
  }
  const int status = wait_for(child, !in_time || talk.is_broken() || stop.stop_requested());
  if (stop.stop_requested()) return make_error(ErrorCode::kCancelled, "stopped");
  if (!in_time) {
    return make_error(ErrorCode::kTimeout,
                      fmt::format("{}: more than {} s", job.peer, job.time_limit.count()));
  }
  if (talk.outcome() && !talk.is_broken()) return *talk.outcome();
  return make_error(
      ErrorCode::kIo,
      fmt::format("{}: the process that talks to it died of what it sent{}",
                  job.peer,
                  WIFSIGNALED(status) ? fmt::format(" (signal {})", WTERMSIG(status)) : ""));
}

}  // namespace mor::internal
