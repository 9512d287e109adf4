#pragma once
// The stages of substeps beside a model: the bytes that each has to move, its operations, and what this machine needs
// for them at least.
#include <array>
#include <string>

#include "shell/run/simulation.h"

namespace sunder::shell {

/// What one pass of a stage has to do.
struct StageWork {
  double bytes = 0.0, operations = 0.0;
};
/// Of one evaluation of the internal force, or of one kick and drift, of all shells as they are. Laws with memory add
/// what they read and write; their own operations are not counted.
StageWork force_work(const State& state);
StageWork kick_drift_work(const State& state);

/// Measures multiply-adds of registers by `threads` threads [operations/s].
double measure_peak(int threads);
/// Measures how fast `threads` threads move memory, x = y + a z over three arrays of together `bytes` [bytes/s].
double measure_bandwidth(int threads, double bytes);

/// Sums the work of a run and its times.
class Profile {
 public:
  /// `simulation` must outlive it. Time that stages took before is left out.
  explicit Profile(const Simulation& simulation);
  /// Counts a window of `substeps`, which evaluates the forces once more for its books.
  void count(int substeps);
  /// Measures the machine, and writes profile.json into `folder`; coupler/README.md explains it. Throws Error (io).
  void write(const std::string& folder) const;

 private:
  struct Sum {
    StageWork work;
    double passes = 0.0;
  };
  const Simulation& simulation_;
  StageTimes before_;
  Sum force_, kick_drift_;
  double substeps_ = 0.0, threads_ = 0.0;  // threads of each substep, summed
};

}  // namespace sunder::shell
