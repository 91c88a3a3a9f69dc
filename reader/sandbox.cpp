// System calls are allowed by a list; all others fail with EPERM. [seccomp(2), filter mode]
#include "reader/sandbox.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace turgor {

namespace {

/// Address space of this process [bytes].
rlim_t address_space() {
  unsigned long long pages = 0;
  FILE* file = std::fopen("/proc/self/statm", "r");
  if (!file) return 0;
  if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
  std::fclose(file);
  return rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE));
}

void lower(__rlimit_resource_t what, rlim_t most) {
  rlimit limit{};
  if (getrlimit(what, &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_cur, most);
  limit.rlim_max = std::min(limit.rlim_max, most);
  setrlimit(what, &limit);
}

#if defined(__x86_64__)
constexpr unsigned kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned kMachine = 0;
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // sanitizers use threads and pipes
#else
constexpr bool kIsSanitized = false;
#endif

constexpr unsigned kAllowed[] = {
    SYS_read,          SYS_pread64,      SYS_readv,        SYS_lseek,
    SYS_close,         SYS_fstat,        SYS_newfstatat,   SYS_statx,
    SYS_fcntl,         SYS_flock,        SYS_mmap,         SYS_munmap,
    SYS_mremap,        SYS_mprotect,     SYS_madvise,      SYS_brk,
    SYS_futex,         SYS_getrandom,    SYS_sched_yield,  SYS_sched_getaffinity,
    SYS_clock_gettime, SYS_gettimeofday, SYS_getrusage,    SYS_sysinfo,
    SYS_uname,         SYS_getpid,       SYS_gettid,       SYS_getuid,
    SYS_geteuid,       SYS_getgid,       SYS_getegid,      SYS_getcwd,
    SYS_readlinkat,    SYS_faccessat,    SYS_rt_sigaction, SYS_rt_sigprocmask,
    SYS_rt_sigreturn,  SYS_exit,         SYS_exit_group,
#if defined(__x86_64__)
    SYS_stat,          SYS_lstat,        SYS_access,       SYS_readlink,
    SYS_time,
#endif
};

/// A filter's instructions.
class Filter {
 public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    unless_equal(kMachine, SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
  }
  void allow(unsigned call) {
    add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1);
    add(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }
  /// Allows a call if none of these bits is set in an argument.
  void allow_without(unsigned call, unsigned argument, unsigned bits) {
    decide_by(call, argument, BPF_JSET, bits, SECCOMP_RET_ERRNO | EPERM, SECCOMP_RET_ALLOW);
  }
  /// Allows a call if an argument has this value.
  void allow_with(unsigned call, unsigned argument, unsigned value) {
    decide_by(call, argument, BPF_JEQ, value, SECCOMP_RET_ALLOW, SECCOMP_RET_ERRNO | EPERM);
  }
  void install() {
    add(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
    const sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
  }

 private:
  void add(unsigned code, unsigned value, unsigned char if_true = 0, unsigned char if_false = 0) {
    code_.push_back({static_cast<unsigned short>(code), if_true, if_false, value});
  }
  void load(unsigned offset) { add(BPF_LD | BPF_W | BPF_ABS, offset); }
  /// Ends a call with one of two actions, by a test of an argument.
  void decide_by(unsigned call, unsigned argument, unsigned test, unsigned value, unsigned if_true,
                 unsigned if_false) {
    add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4);
    load(unsigned(offsetof(seccomp_data, args) + 8 * argument));
    add(BPF_JMP | test | BPF_K, value, 0, 1);
    add(BPF_RET | BPF_K, if_true);
    add(BPF_RET | BPF_K, if_false);
  }
  void unless_equal(unsigned value, unsigned action) {
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0);
    add(BPF_RET | BPF_K, action);
  }
  std::vector<sock_filter> code_;
};

void allow_reading_only() {
  constexpr unsigned kChanges = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
  Filter filter;
  for (const unsigned call : kAllowed) filter.allow(call);
  filter.allow_without(SYS_openat, 2, kChanges);
#if defined(__x86_64__)
  filter.allow_without(SYS_open, 1, kChanges);
#endif
  filter.allow_with(SYS_write, 0, STDERR_FILENO);        // messages of libraries
  filter.allow_with(SYS_tgkill, 0, unsigned(getpid()));  // abort()
  filter.install();
}

}  // namespace

void enter_sandbox(std::size_t memory) {
  lower(RLIMIT_AS, address_space() + memory);
  lower(RLIMIT_FSIZE, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  if (kMachine != 0 && !kIsSanitized) allow_reading_only();
}

}  // namespace turgor
