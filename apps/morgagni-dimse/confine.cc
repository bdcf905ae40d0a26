// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "confine.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>
#include <vector>

#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "morgagni/core/open_paths.h"

#include "messages.h"

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
                                   SCMP_SYS(process_madvise),
                                   SCMP_SYS(kcmp),
                                   SCMP_SYS(kill),
                                   SCMP_SYS(tkill),
                                   SCMP_SYS(rt_sigqueueinfo),
                                   SCMP_SYS(rt_tgsigqueueinfo),
                                   SCMP_SYS(pidfd_open),
                                   SCMP_SYS(pidfd_send_signal),
                                   SCMP_SYS(pidfd_getfd),
                                   SCMP_SYS(io_uring_setup),
                                   SCMP_SYS(io_uring_enter),
                                   SCMP_SYS(io_uring_register),
                                   SCMP_SYS(mount),
                                   SCMP_SYS(umount2),
                                   SCMP_SYS(open_tree),
                                   SCMP_SYS(move_mount),
                                   SCMP_SYS(fsopen),
                                   SCMP_SYS(fsconfig),
                                   SCMP_SYS(fsmount),
                                   SCMP_SYS(fspick),
                                   SCMP_SYS(mount_setattr),
                                   SCMP_SYS(open_by_handle_at),
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
                                   SCMP_SYS(delete_module),
                                   SCMP_SYS(kexec_load),
                                   SCMP_SYS(kexec_file_load),
                                   SCMP_SYS(truncate),
                                   SCMP_SYS(setxattr),
                                   SCMP_SYS(lsetxattr),
                                   SCMP_SYS(fsetxattr),
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

/// All that a peer which takes this process over could still do hangs on this one.
Result<void> filter_system_calls() {
  scmp_filter_ctx filter = ::seccomp_init(SCMP_ACT_ALLOW);
  if (filter == nullptr) return make_error(ErrorCode::kInternal, "no memory for the filter");
  int failure = 0;
  const auto forbid = [&](int call, int error, const std::vector<scmp_arg_cmp>& where = {}) {
    const int added = ::seccomp_rule_add_array(filter,
                                               SCMP_ACT_ERRNO(static_cast<unsigned>(error)),
                                               call,
                                               static_cast<unsigned>(where.size()),
                                               where.data());
    if (failure == 0) failure = added;
  };
  for (const int call : kForbidden) forbid(call, EPERM);
  // Its own end by abort(), its own limits, but no other process's.
  const auto self = static_cast<scmp_datum_t>(::getpid());
  forbid(SCMP_SYS(tgkill), EPERM, {SCMP_A0(SCMP_CMP_NE, self)});
  forbid(SCMP_SYS(prlimit64), EPERM, {SCMP_A0(SCMP_CMP_NE, 0)});
  // A thread, but no process; clone3() keeps its flags where no filter sees them, and whoever is
  // told that there is none falls back on clone().
  forbid(SCMP_SYS(clone), EPERM, {SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, 0)});
  forbid(SCMP_SYS(clone3), ENOSYS);
  (void)::seccomp_attr_set(filter, SCMP_FLTATR_API_SYSRAWRC, 1);  // Why, not only that it fails.
  if (failure == 0) failure = ::seccomp_load(filter);
  ::seccomp_release(filter);
  if (failure == 0) return {};
  return make_error(ErrorCode::kUnsupported,
                    "no DICOM connection is made, because the process for it cannot give up its "
                    "system calls on this machine (seccomp: " +
                        std::generic_category().message(-failure) +
                        "): allow seccomp, in a container too");
}

/// What finding a host by its name and converting texts take: the loader's and the resolver's
/// files. What is received is written below two folders.
std::vector<OpenPath> open_paths(const Task& task) {
  std::vector<OpenPath> paths;
  for (const char* path : {"/lib",
                           "/lib64",
                           "/usr/lib",
                           "/usr/lib64",
                           "/usr/local/lib",
                           "/etc/ld.so.cache",
                           "/etc/nsswitch.conf",
                           "/etc/hosts",
                           "/etc/host.conf",
                           "/etc/resolv.conf",
                           "/etc/gai.conf",
                           "/etc/services",
                           "/etc/localtime"})
    paths.push_back({path});
  for (const auto& path : {task.tls.ca, task.tls.certificate, task.tls.key})
    if (!path.empty()) paths.push_back({path});
  for (const auto& path : {task.folder, task.parts, std::string("/dev/null")})
    if (!path.empty()) paths.push_back({path, /*may_change=*/true});
  return paths;
}

}  // namespace

Result<void> confine(const Task& task) {
  constexpr rlim_t kMaxDataBytes = 512ULL << 20U;
  constexpr rlim_t kMaxOpenFiles = 64;
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_NOFILE, kMaxOpenFiles);
  // A little more than is said to the sender, who is to hear of the limit.
  constexpr rlim_t kSlackBytes = 1U << 20U;
  if (task.max_object_bytes > 0) limit(RLIMIT_FSIZE, task.max_object_bytes + kSlackBytes);
  // A file that grows too large is an error of its writing, not this process's end.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  if (kSanitized) return {};  // Sanitizers need memory and system calls of their own.
  if (const auto hidden = open_only(open_paths(task)); !hidden) {
    say_weakness("the process of a DICOM connection can open and change all files that you can (" +
                 hidden.error().message + "): connect to none but your own PACS");
  }
  limit(RLIMIT_DATA, kMaxDataBytes);
  return filter_system_calls();
}

}  // namespace mor::dimse
