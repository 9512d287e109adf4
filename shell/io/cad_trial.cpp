#include "shell/io/cad_trial.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sunder::shell {
namespace {

constexpr int kNoMemory = 3;           // exit status of a child whose memory is used up
constexpr rlim_t kGraceS = 5;          // after SIGXCPU, until the system ends the child [s]
constexpr double kMemoryShare = 0.75;  // of the machine's memory that a child may take

// The address space of this process [bytes].
double own_bytes() {
  double pages = 0.0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// Lowers a limit; what this process may not exceed stays.
void lower_limit(int resource, rlim_t soft, rlim_t hard) {
  rlimit now{};
  getrlimit(static_cast<__rlimit_resource>(resource), &now);
  const rlimit lower{std::min(soft, now.rlim_cur), std::min(hard, now.rlim_max)};
  setrlimit(static_cast<__rlimit_resource>(resource), &lower);
}

[[noreturn]] void run_child(const std::function<void()>& work, pid_t parent, double most_cpu_s, rlim_t most_space) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(0);  // it has ended in between
  for (const int signal : {SIGINT, SIGTERM, SIGSEGV, SIGBUS, SIGILL, SIGABRT, SIGFPE, SIGXCPU})
    std::signal(signal, SIG_DFL);
  const auto seconds = static_cast<rlim_t>(std::ceil(most_cpu_s));
  lower_limit(RLIMIT_CORE, 0, 0);
  lower_limit(RLIMIT_CPU, seconds, seconds + kGraceS);
  lower_limit(RLIMIT_AS, most_space, most_space);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
  try {
    work();
  } catch (const std::bad_alloc&) {
    _exit(kNoMemory);
  } catch (...) {  // the caller meets it again and tells it
  }
  _exit(0);
}

}  // namespace

double most_trial_bytes() {
  return kMemoryShare * static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

TrialEnd tried(const std::function<void()>& work, double most_cpu_s, double most_bytes) {
  const pid_t parent = getpid();
  const auto most_space = static_cast<rlim_t>(own_bytes() + most_bytes);
  const pid_t child = fork();
  if (child == 0) run_child(work, parent, most_cpu_s, most_space);
  int status = 0;
  pid_t ended = child;
  if (child > 0) do
      ended = waitpid(child, &status, 0);
    while (ended < 0 && errno == EINTR);
  if (ended < 0) throw std::system_error(errno, std::generic_category());
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return {signal == SIGXCPU ? TrialEnd::kTime : TrialEnd::kSignal, signal};
  }
  const int code = WEXITSTATUS(status);
  if (code == kNoMemory) return {TrialEnd::kMemory, code};
  return {code == 0 ? TrialEnd::kDone : TrialEnd::kStatus, code};
}

std::string trial_fault(const TrialEnd& end, const std::string& reader, double most_cpu_s, double most_bytes) {
  switch (end.kind) {
    case TrialEnd::kDone:
      return {};
    case TrialEnd::kTime:
      return fmt::format("takes {} more than {:g} s of processor time; export it again, simpler or in parts", reader,
                         most_cpu_s);
    case TrialEnd::kMemory:
      return fmt::format("takes {} more than {:.3g} GB of memory; export it again, simpler or in parts", reader,
                         1e-9 * most_bytes);
    case TrialEnd::kStatus:
      return fmt::format("ends {} with status {}; export it again, or simpler", reader, end.number);
    case TrialEnd::kSignal:
      break;
  }
  const char* name = sigabbrev_np(end.number);
  const std::string signal = name ? fmt::format("SIG{}", name) : fmt::format("signal {}", end.number);
  if (end.number == SIGKILL || end.number == SIGTERM || end.number == SIGINT)
    return fmt::format("was not read, as the process of {} was killed by {}; is memory short?", reader, signal);
  return fmt::format("stops {} with {}; export it again, or simpler", reader, signal);
}

}  // namespace sunder::shell
