// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// A DICOM connection's process that a hostile peer has taken over: it gives up its rights as
// morgagni-dimse does and then tries what its task names. What works nevertheless is told.
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include <fcntl.h>
#include <netdb.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "confine.h"
#include "messages.h"
#include "task.h"

namespace {

namespace fs = std::filesystem;

void tell(long result) {
  const std::string why = std::strerror(errno);
  mor::dimse::say_failed({mor::ErrorCode::kInternal, result < 0 ? "refused: " + why : "IT WORKED"});
}

long call(long number, long a = 0, long b = 0, long c = 0, long d = 0, long e = 0, long f = 0) {
  return ::syscall(number, a, b, c, d, e, f);
}

void receive(const mor::dimse::Task& task) {
  const auto part = fs::path(task.parts) / "1.part";
  const auto folder = fs::path(task.folder) / "1.2" / "3.4";
  std::error_code status;
  fs::create_directories(folder, status);
  const int fd = ::open(part.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
  if (fd < 0) return tell(-1);
  tell(::rename(part.c_str(), (folder / "5.6.dcm").c_str()));
}

void find_host() {
  addrinfo* found = nullptr;
  errno = EACCES;
  tell(::getaddrinfo("localhost", nullptr, nullptr, &found) == 0 ? 0 : -1);
}

}  // namespace

int main() {
  std::string text(1 << 16, ' ');
  text.resize(std::fread(text.data(), 1, text.size(), stdin));
  const auto task = mor::dimse::parse_task(text);
  if (!task) return 2;
  const long parent = ::getppid();
  const std::string secret = (fs::path(task->folder).parent_path() / "secret").string();
  siginfo_t info{};
  info.si_code = SI_QUEUE;
  const rlimit none = {0, 0};
  std::array<char, 8> here{};
  const iovec local = {here.data(), here.size()};
  const auto address = [](const auto& of) { return reinterpret_cast<long>(&of); };
  const std::map<std::string, std::function<void()>> attempts = {
      {"receive", [&] { receive(*task); }},
      {"find a host", find_host},
      {"kill", [&] { tell(call(SYS_kill, parent, 0)); }},
      {"tgkill", [&] { tell(call(SYS_tgkill, parent, parent, 0)); }},
      {"own tgkill", [&] { tell(call(SYS_tgkill, ::getpid(), ::getpid(), 0)); }},
      {"rt_sigqueueinfo", [&] { tell(call(SYS_rt_sigqueueinfo, parent, 0, address(info))); }},
      {"rt_tgsigqueueinfo",
       [&] { tell(call(SYS_rt_tgsigqueueinfo, parent, parent, 0, address(info))); }},
      {"pidfd_open", [&] { tell(call(SYS_pidfd_open, parent)); }},
      {"pidfd_send_signal", [] { tell(call(SYS_pidfd_send_signal, 0)); }},
      {"process_vm_writev",
       [&] { tell(call(SYS_process_vm_writev, parent, address(local), 1, address(local), 1)); }},
      {"prlimit64", [&] { tell(call(SYS_prlimit64, parent, RLIMIT_CPU, address(none))); }},
      {"io_uring_setup", [] { tell(call(SYS_io_uring_setup, 1)); }},
      {"open_tree", [] { tell(call(SYS_open_tree, AT_FDCWD, 0)); }},
      {"move_mount", [] { tell(call(SYS_move_mount, AT_FDCWD, 0, AT_FDCWD, 0)); }},
      {"fsopen", [] { tell(call(SYS_fsopen, reinterpret_cast<long>("tmpfs"), 0)); }},
      {"execve", [] { tell(call(SYS_execve, reinterpret_cast<long>("/bin/true"), 0, 0)); }},
      {"truncate", [&] { tell(::truncate(secret.c_str(), 0)); }},
      {"read another file", [&] { tell(::open(secret.c_str(), O_RDONLY)); }},
      {"write another file", [&] { tell(::open(secret.c_str(), O_WRONLY)); }},
      {"remove another file", [&] { tell(::unlink(secret.c_str())); }},
      {"make a file", [&] { tell(::open((secret + "2").c_str(), O_CREAT | O_WRONLY, 0600)); }},
      {"read passwords", [] { tell(::open("/etc/passwd", O_RDONLY)); }},
      {"look into processes", [] { tell(::open("/proc/1/environ", O_RDONLY)); }},
  };
  if (const auto done = mor::dimse::confine(*task); !done) {
    mor::dimse::say_failed(done.error());
    return 1;
  }
  attempts.at(task->name)();
  return 0;
}
