#include "shell/run/profile.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <vector>

#include <omp.h>
#include <nlohmann/json.hpp>

#include "shell/io/vtp.h"
#include "shell/mechanics/operations.h"

namespace sunder::shell {
namespace {

constexpr double kNumber = sizeof(double);
constexpr double kTried = 0.01;                            // [s], of one trial of the machine
constexpr int kTrials = 5;                                 // the best counts
constexpr double kLook = 1e-4;                             // between two looks at the clock [s]
constexpr double kLeastArrays = 3e4, kMostArrays = 256e6;  // [bytes]: registers are no memory; more is no other memory

// A narrow function has five derivatives of 32 bits, and a quarter of the number of its control point.
constexpr double kFunctionBytes = 5 * 4 + 2;
// Of a gathered point beside its functions: stamps, places, masks, area and metric.
constexpr double kPointBytes = 12 * kNumber;

std::size_t in_rows(const ShellState& s) {
  return static_cast<std::size_t>(
      std::count_if(s.cracked.gathered.begin(), s.cracked.gathered.end(), [](const auto& g) { return g.in_rows; }));
}

StageWork force_work(const ShellModel& m, const ShellState& s) {
  const RowTables& t = s.cracked.tables;
  const double gauss = t.gauss_points(), gathered = static_cast<double>(s.cracked.gathered.size() - in_rows(s));
  StageWork work;
  work.operations = (gauss - gathered) * operations_of_row_point(t);
  // tables once, positions once, forces twice: as parts of rows and as their sum
  work.bytes = kNumber * static_cast<double>(t.metric.size() + t.basis_u.size() + t.basis_v.size() +
                                             t.denominator.size() + t.thickness.size() + 9 * t.component_stride);
  if (s.yields()) work.bytes += kNumber * 2.0 * kFormFields * gauss;              // read and written
  if (!s.caches.over.empty()) work.bytes += kNumber * 2.0 * 6.0 * gauss;          // stress of the faces
  const double bare = gathered > 0.0 ? operations_of_gathered_point(t, 0) : 0.0;  // counted once
  const double each = gathered > 0.0 ? operations_of_gathered_point(t, 1) - bare : 0.0;
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.in_rows || g.kind == PointKind::kDead) continue;
    work.operations += bare + each * static_cast<double>(g.functions.size());
    work.bytes += kPointBytes + kFunctionBytes * static_cast<double>(g.functions.size());
  }
  if (m.laminated()) {
    const RowTables& core = s.cracked.interlayer;
    work.operations += core.gauss_points() * operations_of_row_point(core);
    work.bytes += kNumber * static_cast<double>(core.metric.size() + 12 * core.component_stride);
  }
  return work;
}

// Calls f(first, count) for parts of the range of `size` numbers, on `threads` threads.
template <class F>
void in_parts(int threads, std::size_t size, F&& f) {
#pragma omp parallel num_threads(threads)
  {
    const std::size_t k = omp_get_thread_num(), n = omp_get_num_threads();
    f(k * size / n, (k + 1) * size / n);
  }
}

// Most of `amount` per second over trials of `once` on `threads` threads. Processor time counts: another program takes
// turns with the threads, and the limits are those of the machine alone.
double fastest(double amount, int threads, const std::function<void()>& once) {
  double best = 0.0;
  once();
  const double first = wall_clock();
  once();
  // A look at the clock can take as long as a pass over small arrays.
  const int batch = std::clamp(static_cast<int>(kLook / std::max(wall_clock() - first, 1e-9)), 1, 1000);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double start = wall_clock();
    const std::clock_t before = std::clock();
    int rounds = 0;
    while (wall_clock() - start < kTried) {
      for (int k = 0; k < batch; ++k) once();
      rounds += batch;
    }
    const double each = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / threads;
    best = std::max(best, rounds * amount / std::max(each, 1e-6));
  }
  return best;
}

// Keeps what is computed although nobody reads it.
template <class T>
void keep(T& value) {
  asm volatile("" : "+m"(value) : : "memory");
}

}  // namespace

StageWork force_work(const State& state) {
  StageWork sum;
  for (const ShellPart& part : state.shells) {
    if (!part.state) continue;
    const StageWork one = force_work(part.model(), *part.state);
    sum.bytes += one.bytes, sum.operations += one.operations;
  }
  return sum;
}

StageWork kick_drift_work(const State& state) {
  StageWork sum;
  for (const ShellPart& part : state.shells) {
    if (!part.state) continue;
    const double numbers = 3.0 * part.model().tables.component_stride;
    // kick: velocity and force are read, velocity is written, an inverse mass for three components;
    // drift: velocity and position are read, position is written
    sum.bytes += kNumber * numbers * (3.0 + 1.0 / 3.0 + 3.0);
    sum.operations += numbers * (4.0 + 2.0);
  }
  return sum;
}

double measure_peak(int threads) {
  constexpr int kChains = 12, kRounds = 20000;
  const auto once = [] {
    Pack x[kChains];
    for (int i = 0; i < kChains; ++i) x[i] = splat<Pack>(1.0 + 0.01 * i);
    const Pack a = splat<Pack>(0.999999), c = splat<Pack>(1e-6);
    for (int r = 0; r < kRounds; ++r)
      for (int i = 0; i < kChains; ++i) x[i] = x[i] * a + c;
    keep(x);
  };
  return fastest(2.0 * kLanes * kChains * kRounds * threads, threads,
                 [&] { in_parts(threads, threads, [&](std::size_t, std::size_t) { once(); }); });
}

double measure_bandwidth(int threads, double bytes) {
  const std::size_t size = static_cast<std::size_t>(std::clamp(bytes, kLeastArrays, kMostArrays) / (3.0 * kNumber));
  std::vector<double> x(size, 1.0), y(size, 2.0), z(size, 3.0);
  return fastest(3.0 * kNumber * static_cast<double>(size), threads, [&] {
    in_parts(threads, size, [&](std::size_t first, std::size_t last) {
      double* to = x.data();
      const double *from = y.data(), *by = z.data();
#pragma omp simd
      for (std::size_t i = first; i < last; ++i) to[i] = from[i] + 0.5 * by[i];
      keep(*to);
    });
  });
}

Profile::Profile(const Simulation& simulation) : simulation_(simulation), before_(simulation.scratch.times) {}

void Profile::count(int substeps) {
  const auto add = [](Sum& sum, const StageWork& work, double passes) {
    sum.work.bytes += passes * work.bytes, sum.work.operations += passes * work.operations, sum.passes += passes;
  };
  for (const ShellPart& part : simulation_.state.shells)  // one with a local time step is left out of some substeps
    if (part.state) {
      const StageWork work = force_work(part.model(), *part.state);
      const double times = static_cast<double>(substeps) / part.local.every + 1.0;
      force_.work.bytes += times * work.bytes, force_.work.operations += times * work.operations;
    }
  force_.passes += substeps + 1.0;
  add(kick_drift_, kick_drift_work(simulation_.state), substeps);
  substeps_ += substeps, threads_ += substeps * static_cast<double>(simulation_.scratch.pace.threads());
}

void Profile::write(const std::string& folder) const {
  using Json = nlohmann::ordered_json;
  // Beside other programs a run takes fewer threads than it may.
  const int threads = substeps_ > 0.0 ? std::max(1, static_cast<int>(std::lround(threads_ / substeps_))) : 1;
  const double peak = measure_peak(threads);
  Json stages = Json::array();
  for (std::size_t k = 0; k < kStageNames.size(); ++k) {
    const double seconds = simulation_.scratch.times.seconds[k] - before_.seconds[k];
    if (!(seconds > 0.0)) continue;
    Json one = {{"stage", kStageNames[k]}, {"seconds", seconds}};
    const Stage stage = static_cast<Stage>(k);
    const Sum* sum = stage == Stage::kInternalForce ? &force_ : stage == Stage::kKickDrift ? &kick_drift_ : nullptr;
    if (sum && sum->passes > 0.0) {
      const double bytes = sum->work.bytes / sum->passes, bandwidth = measure_bandwidth(threads, bytes);
      const double by_memory = sum->work.bytes / bandwidth, by_operations = sum->work.operations / peak;
      one["passes"] = sum->passes, one["bytes"] = bytes, one["operations"] = sum->work.operations / sum->passes;
      one["memory_gb_per_s"] = 1e-9 * bandwidth;
      one["memory_s"] = by_memory, one["operations_s"] = by_operations;
      one["limit"] = by_memory > by_operations ? "memory" : "operations";
      one["times_limit"] = seconds / std::max(by_memory, by_operations);
    }
    stages.push_back(std::move(one));
  }
  const Json all = {{"schema", 1},
                    {"threads", threads},
                    {"substeps", substeps_},
                    {"fma_peak_gflops", 1e-9 * peak},
                    {"stages", stages}};
  write_atomically(folder + "/profile.json", all.dump(2) + "\n");
}

}  // namespace sunder::shell
