#include "tests/benchmarks/beside.h"

#include <csignal>

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "tests/shell/rig.h"

namespace sunder::bench {
namespace {

constexpr int kAcross = 100, kLayers = 4, kRounds = 8, kSettling = 4;
constexpr double kSlice = 0.4;  // [s], many slices of the scheduler
constexpr double kStep = 1e-9;  // [s]: it must not wander off while it is timed

/// A process that keeps one processor busy for as long as this lives.
class BusyProcess {
 public:
  BusyProcess() : id_(fork()) {
    ensure(id_ >= 0, "cannot start a process");
    if (id_ > 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    volatile bool busy = true;
    while (busy) {
    }
  }
  ~BusyProcess() {
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  BusyProcess(const BusyProcess&) = delete;
  BusyProcess& operator=(const BusyProcess&) = delete;

 private:
  pid_t id_;
};

shell::Rig sheet(int threads) {
  shell::ShellMaterial glass;
  glass.density = 2500, glass.youngs_modulus = 70e9, glass.poisson_ratio = 0.22;
  const double side = 5e-3 * kAcross;
  return shell::Rig(shell::setup_of({{shell::make_shell(
                        "sheet", shell::plate(side, side, kAcross, kAcross, Vec3::Zero(), Quat::Identity()), 4e-3,
                        glass, kLayers, 2, {})}}),
                    threads);
}

// Seconds a substep, over a slice of time.
double seconds_a_substep(shell::Rig& rig) {
  const double start = shell::wall_clock();
  int n = 0;
  double now = start;
  for (; now < start + kSlice; now = shell::wall_clock(), ++n) rig.step(kStep);
  return (now - start) / n;
}

// Two threads over one, in turns. The first rounds are not counted: the threads find their pace in them.
double ratio(shell::Rig& one, shell::Rig& two) {
  double sums[2] = {};
  for (int round = -kSettling; round < kRounds; ++round) {
    const double now[2] = {seconds_a_substep(one), seconds_a_substep(two)};
    for (int k = 0; k < 2 && round >= 0; ++k) sums[k] += now[k];
  }
  return sums[1] / sums[0];
}

void measure(std::map<std::string, double>& out) {
  shell::Rig one = sheet(1), two = sheet(2);
  const double alone = ratio(one, two);
  out["two_threads_time_ratio"] = alone;
  const BusyProcess busy;
  out["two_threads_time_ratio_beside"] = ratio(one, two);
  fmt::print("beside: a substep of {} x {} elements with two threads over one: {:.3f}, beside a busy process {:.3f}\n",
             kAcross, kAcross, alone, out["two_threads_time_ratio_beside"]);
}

}  // namespace

ProcessBenchmark beside_benchmark() {
  return {"beside", {"two_threads_time_ratio", "two_threads_time_ratio_beside"}, measure};
}

}  // namespace sunder::bench
