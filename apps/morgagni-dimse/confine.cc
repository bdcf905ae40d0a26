// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "confine.h"

#include <array>
#include <cerrno>
#include <csignal>

#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>

namespace mor::dimse {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void limit(__rlimit_resource resource, rlim_t value) {
  const rlimit both = {value, value};
  (void)::setrlimit(resource, &both);
}

/// Calls that no connection needs and an intruder would like.
constexpr std::array kForbidden = {SCMP_SYS(execve),
                                   SCMP_SYS(execveat),
                                   SCMP_SYS(fork),
                                   SCMP_SYS(vfork),
                                   SCMP_SYS(ptrace),
                                   SCMP_SYS(process_vm_readv),
                                   SCMP_SYS(process_vm_writev),
                                   SCMP_SYS(kill),
                                   SCMP_SYS(tkill),
                                   SCMP_SYS(mount),
                                   SCMP_SYS(umount2),
                                   SCMP_SYS(pivot_root),
                                   SCMP_SYS(chroot),
                                   SCMP_SYS(unshare),
                                   SCMP_SYS(setns),
                                   SCMP_SYS(bpf),
                                   SCMP_SYS(perf_event_open),
                                   SCMP_SYS(keyctl),
                                   SCMP_SYS(add_key),
                                   SCMP_SYS(request_key),
                                   SCMP_SYS(userfaultfd),
                                   SCMP_SYS(init_module),
                                   SCMP_SYS(finit_module),
                                   SCMP_SYS(kexec_load),
                                   SCMP_SYS(symlink),
                                   SCMP_SYS(symlinkat),
                                   SCMP_SYS(link),
                                   SCMP_SYS(linkat),
                                   SCMP_SYS(chmod),
                                   SCMP_SYS(fchmod),
                                   SCMP_SYS(fchmodat),
                                   SCMP_SYS(chown),
                                   SCMP_SYS(fchown),
                                   SCMP_SYS(fchownat),
                                   SCMP_SYS(mknod),
                                   SCMP_SYS(mknodat)};

/// Without it (an old kernel, a container that forbids it) the other limits still hold.
void filter_system_calls() {
  scmp_filter_ctx filter = ::seccomp_init(SCMP_ACT_ALLOW);
  if (filter == nullptr) return;
  for (const int call : kForbidden)
    (void)::seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), call, 0);
  // A thread, but no process; clone3() keeps its flags where no filter sees them, and whoever is
  // told that there is none falls back on clone().
  (void)::seccomp_rule_add(filter,
                           SCMP_ACT_ERRNO(EPERM),
                           SCMP_SYS(clone),
                           1,
                           SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0));
  (void)::seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  (void)::seccomp_load(filter);
  ::seccomp_release(filter);
}

}  // namespace

void confine(std::uint64_t max_file_bytes) {
  constexpr rlim_t kMaxDataBytes = 512ULL << 20U;
  constexpr rlim_t kMaxOpenFiles = 64;
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NOFILE, kMaxOpenFiles);
  // A little more than is said to the sender, who is to hear of the limit.
  constexpr rlim_t kSlackBytes = 1U << 20U;
  if (max_file_bytes > 0) limit(RLIMIT_FSIZE, max_file_bytes + kSlackBytes);
  // A file that grows too large is an error of its writing, not this process's end.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  if (kSanitized) return;  // Sanitizers need memory and system calls of their own.
  limit(RLIMIT_DATA, kMaxDataBytes);
  filter_system_calls();
}

}  // namespace mor::dimse
