// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// An import process that a hostile file has taken over: it gives up its rights as morgagni-import
// does and then tries what its third argument names. What works nevertheless is told as an error.
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "messages.h"
#include "sandbox.h"

namespace {

using mor::import::say_error;

void tell(long result) {
  const std::string why = std::strerror(errno);
  say_error({mor::ErrorCode::kInternal, result < 0 ? "refused: " + why : "IT WORKED"});
}

/// Takes memory until there is none; tells how much it was.
void take_memory() {
  constexpr std::size_t kPiece = std::size_t{1} << 20U;
  std::size_t taken_mib = 0;
  for (;;) {
    auto* piece = static_cast<volatile char*>(std::malloc(kPiece));
    if (piece == nullptr) break;
    for (std::size_t i = 0; i < kPiece; i += 4096) piece[i] = 1;
    ++taken_mib;
  }
  rlimit more = {RLIM_INFINITY, RLIM_INFINITY};
  const bool is_raised = ::setrlimit(RLIMIT_DATA, &more) == 0;
  say_error({mor::ErrorCode::kInternal,
             "took " + std::to_string(taken_mib) + " MiB" + (is_raised ? ", AND MORE" : "")});
}

/// A grid of 100 MiB is declared and handed over before.
void take_memory_with_volume() {
  mor::ImportHeader header;
  header.size = {512, 512, 200, 0};
  const auto voxels = mor::import::open_voxels(header);
  if (!voxels) return tell(-1);
  mor::import::allow_memory(voxels->size_bytes());
  take_memory();
}

void grow_memory_file() {
  mor::ImportHeader header;
  header.size = {10, 10, 10, 0};
  if (!mor::import::open_voxels(header)) return tell(-1);
  ::signal(SIGXFSZ, SIG_IGN);
  tell(::ftruncate(mor::kImportVoxelsFd, 1 << 30));
}

void spin() {
  mor::import::limit_time_for(0);
  for (volatile bool on = true; on;) {
  }
}

void start_thread() {
  try {
    std::thread([] {}).join();
    tell(0);
  } catch (const std::exception&) {
    errno = EPERM;
    tell(-1);
  }
}

void run_program() {
  std::array<char*, 2> arguments = {const_cast<char*>("/bin/true"), nullptr};
  tell(::execv("/bin/true", arguments.data()));
}

/// As on a machine that does not have these system calls.
void forbid(std::initializer_list<int> calls) {
  scmp_filter_ctx filter = ::seccomp_init(SCMP_ACT_ALLOW);
  for (const int call : calls) (void)::seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), call, 0);
  (void)::seccomp_load(filter);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::filesystem::path path = argv[2];
  const std::string sibling = (path.parent_path() / "secret").string();
  const std::map<std::string, std::function<void()>> attempts = {
      {"take memory", take_memory},
      {"take memory with a volume", take_memory_with_volume},
      {"grow the memory file", grow_memory_file},
      {"spin", spin},
      {"wait for ever",
       [] {
         for (;;) ::sched_yield();
       }},
      {"open a socket", [] { tell(::socket(AF_INET, SOCK_STREAM, 0)); }},
      {"make a file", [&] { tell(::open((sibling + "2").c_str(), O_CREAT | O_WRONLY, 0600)); }},
      {"write the file", [&] { tell(::open(path.c_str(), O_RDWR)); }},
      {"read the file", [&] { tell(::open(path.c_str(), O_RDONLY)); }},
      {"read another file", [&] { tell(::open(sibling.c_str(), O_RDONLY)); }},
      {"read passwords", [] { tell(::open("/etc/passwd", O_RDONLY)); }},
      {"look into processes", [] { tell(::open("/proc/1/environ", O_RDONLY)); }},
      {"remove the file", [&] { tell(::unlink(path.c_str())); }},
      {"make a folder", [&] { tell(::mkdir((sibling + "3").c_str(), 0700)); }},
      {"run a program", run_program},
      {"fork", [] { tell(::fork()); }},
      {"start a thread", start_thread},
      {"trace the parent", [] { tell(::ptrace(PTRACE_ATTACH, ::getppid(), 0, 0)); }},
      {"kill the parent", [] { tell(::kill(::getppid(), SIGKILL)); }},
      {"abort the parent", [] { tell(::syscall(SYS_tgkill, ::getppid(), ::getppid(), SIGKILL)); }},
      {"limit the parent",
       [] {
         const rlimit none = {0, 0};
         tell(::prlimit(::getppid(), RLIMIT_CPU, &none, nullptr));
       }},
      {"crash", [] { std::raise(SIGSEGV); }},
      {"end well with nothing", [] {}},
      {"no Landlock", [] { tell(::open("/etc/passwd", O_RDONLY)); }},
      {"no seccomp", [] { tell(0); }},
  };
  mor::import::say_file(path.string());
  const std::string machine = argv[3];
  if (machine == "no Landlock") forbid({SCMP_SYS(landlock_create_ruleset)});
  if (machine == "no seccomp") forbid({SCMP_SYS(seccomp), SCMP_SYS(prctl)});
  if (const auto done = mor::import::give_up_rights(path); !done) {
    say_error(done.error());
    return 1;
  }
  attempts.at(argv[3])();
  return 0;
}
