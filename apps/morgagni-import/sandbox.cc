// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sandbox.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "morgagni/ct/import_protocol.h"

#include "messages.h"
#include "sight.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MOR_IMPORT_SANITIZED 1
#else
#define MOR_IMPORT_SANITIZED 0
#endif

namespace mor::import {
namespace {

constexpr std::uint64_t kFreeBytes = 256ULL << 20U;
constexpr std::uint64_t kMostBytes = 2 * static_cast<std::uint64_t>(kMaxVolumeBytes) + kFreeBytes;

void limit(int resource, rlim_t soft, rlim_t hard) {
  const rlimit both = {soft, hard};
  (void)::setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

/// Private writable memory that the libraries took before anything was read.
std::uint64_t bytes_at_start() {
  static const std::uint64_t bytes = [] {
    std::ifstream file("/proc/self/statm");
    std::array<std::uint64_t, 6> pages{};
    for (auto& number : pages) file >> number;
    return pages[5] * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  }();
  return bytes;
}

/// The system calls that reading files takes; all others fail with "not permitted".
constexpr std::array kAllowed = {SCMP_SYS(read),
                                 SCMP_SYS(pread64),
                                 SCMP_SYS(readv),
                                 SCMP_SYS(write),
                                 SCMP_SYS(writev),
                                 SCMP_SYS(lseek),
                                 SCMP_SYS(close),
                                 SCMP_SYS(fstat),
                                 SCMP_SYS(stat),
                                 SCMP_SYS(lstat),
                                 SCMP_SYS(newfstatat),
                                 SCMP_SYS(statx),
                                 SCMP_SYS(access),
                                 SCMP_SYS(faccessat),
                                 SCMP_SYS(faccessat2),
                                 SCMP_SYS(readlink),
                                 SCMP_SYS(readlinkat),
                                 SCMP_SYS(getdents64),
                                 SCMP_SYS(getcwd),
                                 SCMP_SYS(fcntl),
                                 SCMP_SYS(ftruncate),
                                 SCMP_SYS(mmap),
                                 SCMP_SYS(munmap),
                                 SCMP_SYS(mremap),
                                 SCMP_SYS(mprotect),
                                 SCMP_SYS(madvise),
                                 SCMP_SYS(brk),
                                 SCMP_SYS(futex),
                                 SCMP_SYS(sched_yield),
                                 SCMP_SYS(sched_getaffinity),
                                 SCMP_SYS(clock_gettime),
                                 SCMP_SYS(gettimeofday),
                                 SCMP_SYS(getrandom),
                                 SCMP_SYS(uname),
                                 SCMP_SYS(sysinfo),
                                 SCMP_SYS(getpid),
                                 SCMP_SYS(gettid),
                                 SCMP_SYS(getuid),
                                 SCMP_SYS(geteuid),
                                 SCMP_SYS(rt_sigaction),
                                 SCMP_SYS(rt_sigprocmask),
                                 SCMP_SYS(rt_sigreturn),
                                 SCMP_SYS(sigaltstack),
                                 SCMP_SYS(setrlimit),
                                 SCMP_SYS(getrlimit),
                                 SCMP_SYS(restart_syscall),
                                 SCMP_SYS(exit),
                                 SCMP_SYS(exit_group)};

/// What no reader ever tries: whoever does has been taken over, and ends at once.
constexpr std::array kDeadly = {SCMP_SYS(socket),
                                SCMP_SYS(socketpair),
                                SCMP_SYS(connect),
                                SCMP_SYS(bind),
                                SCMP_SYS(listen),
                                SCMP_SYS(sendto),
                                SCMP_SYS(execve),
                                SCMP_SYS(execveat),
                                SCMP_SYS(fork),
                                SCMP_SYS(vfork),
                                SCMP_SYS(ptrace),
                                SCMP_SYS(process_vm_readv),
                                SCMP_SYS(process_vm_writev),
                                SCMP_SYS(kill),
                                SCMP_SYS(mount),
                                SCMP_SYS(unlink),
                                SCMP_SYS(unlinkat),
                                SCMP_SYS(rename),
                                SCMP_SYS(renameat2),
                                SCMP_SYS(bpf),
                                SCMP_SYS(io_uring_setup)};

void allow(scmp_filter_ctx filter, int call, const scmp_arg_cmp& only) {
  (void)::seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, only);
}

/// All that a file which takes this process over could still do hangs on this one.
Result<void> filter_system_calls() {
  scmp_filter_ctx filter = ::seccomp_init(SCMP_ACT_ERRNO(EPERM));
  if (filter == nullptr) return make_error(ErrorCode::kInternal, "no memory for the filter");
  for (const int call : kAllowed) (void)::seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0);
  for (const int call : kDeadly) (void)::seccomp_rule_add(filter, SCMP_ACT_KILL_PROCESS, call, 0);
  constexpr scmp_datum_t kWritingFlags = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
  allow(filter, SCMP_SYS(openat), SCMP_A2(SCMP_CMP_MASKED_EQ, kWritingFlags, O_RDONLY));
  allow(filter, SCMP_SYS(open), SCMP_A1(SCMP_CMP_MASKED_EQ, kWritingFlags, O_RDONLY));
  // Of this process alone: its own limits, and its own end by abort().
  const auto self = static_cast<scmp_datum_t>(::getpid());
  allow(filter, SCMP_SYS(prlimit64), SCMP_A0(SCMP_CMP_EQ, 0));
  allow(filter, SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, self));
  (void)::seccomp_attr_set(filter, SCMP_FLTATR_API_SYSRAWRC, 1);  // Why, not only that it fails.
  const int failure = ::seccomp_load(filter);
  ::seccomp_release(filter);
  if (failure == 0) return {};
  return make_error(ErrorCode::kUnsupported,
                    "nothing is read, because the process that reads cannot give up its system "
                    "calls on this machine (seccomp: " +
                        std::generic_category().message(-failure) +
                        "): allow seccomp, in a container too");
}

}  // namespace

Result<void> give_up_rights(const std::filesystem::path& to_read) {
  constexpr rlim_t kMaxCpuSeconds = 300;
  constexpr rlim_t kMaxOpenFiles = 64;
  limit(RLIMIT_CPU, kMaxCpuSeconds, kMaxCpuSeconds);
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_NOFILE, kMaxOpenFiles, kMaxOpenFiles);
  limit(RLIMIT_FSIZE, kMaxVolumeBytes + (1 << 20), kMaxVolumeBytes + (1 << 20));
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  // A sanitizer needs memory and system calls of its own.
  if (MOR_IMPORT_SANITIZED != 0) return {};
  (void)bytes_at_start();  // Asked for while /proc can be seen.
  if (const auto hidden = see_only(to_read); !hidden) {
    say_weakness("the process that reads files can open all that you can (" +
                 hidden.error().message + "): read no files that nobody vouches for");
  }
  limit(RLIMIT_DATA, bytes_at_start() + kFreeBytes, bytes_at_start() + kMostBytes);
  return filter_system_calls();
}

void limit_time_for(std::uint64_t file_bytes) {
  constexpr std::uint64_t kSecondsAtLeast = 5;
  constexpr std::uint64_t kBytesPerSecond = 2'000'000;
  const rlim_t seconds = kSecondsAtLeast + file_bytes / kBytesPerSecond;
  rlimit now{};
  if (::getrlimit(RLIMIT_CPU, &now) != 0) return;
  now.rlim_cur = std::min(seconds, now.rlim_max);
  (void)::setrlimit(RLIMIT_CPU, &now);
}

void allow_memory(std::uint64_t declared_bytes) {
  if (MOR_IMPORT_SANITIZED != 0) return;
  rlimit now{};
  if (::getrlimit(RLIMIT_DATA, &now) != 0) return;
  const rlim_t wanted = bytes_at_start() + kFreeBytes + declared_bytes;
  now.rlim_cur = std::clamp(wanted, now.rlim_cur, now.rlim_max);
  (void)::setrlimit(RLIMIT_DATA, &now);
}

void spend_on_hand_over(std::uint64_t num_bytes) {
  limit(RLIMIT_FSIZE, num_bytes, num_bytes);
  if (MOR_IMPORT_SANITIZED != 0) return;
  rlimit now{};
  if (::getrlimit(RLIMIT_DATA, &now) != 0) return;
  const rlim_t least = bytes_at_start() + kFreeBytes;
  now.rlim_cur = std::max(least, now.rlim_cur - std::min<rlim_t>(num_bytes, now.rlim_cur));
  (void)::setrlimit(RLIMIT_DATA, &now);
}

}  // namespace mor::import
