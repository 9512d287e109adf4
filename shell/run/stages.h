#pragma once
// Stages of a run, and the wall time that each takes.
#include <array>
#include <chrono>
#include <cstddef>
#include <span>

namespace sunder::shell {

/// Stages in the order of their names, which run.json and `sunder run` show.
enum class Stage {
  kCoupling,
  kCrackUpdate,
  kEquilibrium,
  kFibres,
  kInternalForce,
  kIo,
  kKickDrift,
  kRigidContact,
  kShellContact,
  kSoftBodies,
  kTransfer,
};
inline constexpr std::array<const char*, 11> kStageNames = {
    "coupling",   "crack_update",  "equilibrium",   "fibres",      "internal_force", "io",
    "kick_drift", "rigid_contact", "shell_contact", "soft_bodies", "transfer"};

/// Wall time since an arbitrary moment before the run [s].
inline double wall_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Wall time of each stage so far [s].
struct StageTimes {
  std::array<double, kStageNames.size()> seconds{};
  double& operator[](Stage stage) { return seconds[static_cast<std::size_t>(stage)]; }
  double operator[](Stage stage) const { return seconds[static_cast<std::size_t>(stage)]; }
  double total() const {
    double sum = 0.0;
    for (const double s : seconds) sum += s;
    return sum;
  }
};

/// Adds the time of its own lifetime to a sum [s].
struct Stopwatch {
  double& sum;
  double start = wall_clock();
  explicit Stopwatch(double& sum) : sum(sum) {}
  ~Stopwatch() { sum += wall_clock() - start; }
};

}  // namespace sunder::shell
