#include "tests/benchmarks/absent.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <new>

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "coupler/link/host.h"
#include "coupler/scene/load.h"
#include "rigid/engine/engine.h"
#include "shell/run/run.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/temporary_folder.h"

namespace {
std::atomic<std::int64_t> allocations{0};
}  // namespace

// All of this program, so that what a substep allocates is seen.
void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(std::max<std::size_t>(size, 1))) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace sunder::bench {
namespace {

constexpr int kElements = 60, kLayers = 4, kSubsteps = 125, kWindows = 8, kRounds = 4;
constexpr double kStep = 4e-7;  // [s], of a substep: half the stable one with cracks

struct Variant {
  const char* name;
  const char* material;  // what the sheet's material has beside elasticity
  const char* scene;     // what the scene has beside the sheet
  const char* shell = "";
};

// A strength of 1e14 Pa is never reached here, nor is a yield stress of 3.4e9 Pa, a twentieth of E; what is 100 m away
// never meets.
constexpr const char* kFarBall =
    "bodies { name: \"ball\" material: \"glass\" sphere { radius_m: 0.1 } pose { position { z: 100 } } }\n";
const Variant kVariants[] = {
    {"absent", "", ""},
    {"plasticity", "yield_stress: 3.4e9", ""},
    {"tips", "strength: 1e14 fracture_energy: 1e20", "fracture { mode: TIPS }\n"},
    {"damage", "strength: 1e14 fracture_energy: 1e20", "fracture { mode: DAMAGE }\n"},
    {"shell_contact", "", "contacts { first: \"sheet\" second: \"sheet\" }\n"},
    {"fibres", "", "contacts { first: \"sheet\" second: \"sheet\" }\n",
     "fibres { compression_modulus: 1e6 shear_modulus: 1e6 }"},
    {"body", "", kFarBall},
    {"joint", "", "joints { name: \"pin\" kind: BALL first: \"ball\" }\n"},
    {"transfer", "", "transfer { kind: FLIP }\n"},
};

struct Cost {
  double window_s = 1e300;   // of the fastest window
  double allocations = 0.0;  // of a substep, in the last window
  double bytes = 0.0;        // held while it runs
};

class OwningHost final : public link::EngineHost {
 public:
  explicit OwningHost(std::unique_ptr<link::Engine> e) : EngineHost(*e), engine_(std::move(e)) {}

 private:
  std::unique_ptr<link::Engine> engine_;
};

double held_bytes() {
  const struct mallinfo2 m = mallinfo2();
  return static_cast<double>(m.uordblks) + static_cast<double>(m.hblkhd);
}

shell::RunSetup setup(const TemporaryFolder& folder, const Variant& v) {
  const std::string path = folder.path + "/scene.textproto";
  const std::string joined = std::string(v.name) == "joint" ? kFarBall : "";
  std::ofstream(path) << fmt::format(
      "name: \"absent\"\nend_time_s: {:.17g}\nwindow_s: {:.17g}\ntime_step_s: {:.17g}\n"
      "materials {{ name: \"glass\" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 {} }}\n"
      "shells {{ name: \"sheet\" material: \"glass\" thickness_m: 0.004 layers: {} velocity {{ z: 1 }} {}\n"
      "  plate {{ size_x_m: 0.3 size_y_m: 0.3 elements_x: {} elements_y: {} }} }}\n"
      "output {{ frame_interval_s: 1e9 checkpoint_interval_s: 0 }}\n{}{}",
      kWindows * kSubsteps * kStep, kSubsteps * kStep, kStep, v.material, kLayers, v.shell, kElements, kElements,
      joined, v.scene);
  return shell::build(scene::load(path, {}));
}

Cost run_once(const Variant& v) {
  const TemporaryFolder folder;
  Cost cost;
  double before = held_bytes();
  shell::RunOptions options;
  options.out = folder.path, options.quiet = true, options.threads = 1;
  options.connect = [&](const shell::RunOptions&) {
    const double own = held_bytes();
    auto host = std::make_unique<OwningHost>(rigid::make_engine("bullet"));
    before += held_bytes() - own;  // the engine's pools are not the scene's
    return host;
  };
  double last = 0.0;
  std::int64_t counted = 0;
  options.observe = [&](const shell::Run&) {
    const double now = shell::wall_clock();
    if (last > 0.0) {
      cost.window_s = std::min(cost.window_s, now - last);
      cost.allocations = static_cast<double>(allocations - counted) / kSubsteps;
      cost.bytes = held_bytes() - before;
    }
    last = shell::wall_clock(), counted = allocations;
  };
  shell::Run run(setup(folder, v), options);
  const std::atomic<bool> never{false};
  run.execute(never);
  return cost;
}

/// The loop of a substep with nothing around it: by hand, since the `substep` of a run is what is measured against it.
Cost loop_once() {
  const TemporaryFolder folder;
  Cost cost;
  const double before = held_bytes();
  const shell::RunSetup scene = setup(folder, kVariants[0]);
  const shell::ShellModel& m = scene.shells[0].model;
  shell::ShellState s = shell::make_state(m, scene.shells[0].velocity, 0);
  for (int w = 0; w < kWindows; ++w) {
    const double start = shell::wall_clock();
    for (int k = 0; k < kSubsteps; ++k) {
      shell::compute_forces(m, s, false, 0.0, 1);
      shell::kick(m, s, scene.gravity, kStep);
      shell::constrain(m, s, kStep);
      shell::drift(m, s, kStep);
    }
    if (w > 0) cost.window_s = std::min(cost.window_s, shell::wall_clock() - start);
  }
  cost.bytes = held_bytes() - before;
  return cost;
}

void measure(std::map<std::string, double>& out) {
  Cost bare;
  std::map<std::string, Cost> costs;
  const auto keep = [](Cost& best, const Cost& c) {
    best.window_s = std::min(best.window_s, c.window_s), best.allocations = c.allocations, best.bytes = c.bytes;
  };
  for (int round = 0; round < kRounds; ++round) {  // taking turns: a slow moment of the machine meets all of them
    keep(bare, loop_once());
    for (const Variant& v : kVariants) keep(costs[v.name], run_once(v));
  }
  fmt::print(
      "absent: a free sheet of {} x {} elements and {} layers, least of {} rounds; beside the bare loop of a "
      "substep ({:.1f} us, {:.2f} MB)\n",
      kElements, kElements, kLayers, kRounds, 1e6 * bare.window_s / kSubsteps, 1e-6 * bare.bytes);
  for (const Variant& v : kVariants) {
    const Cost& c = costs[v.name];
    const double time = c.window_s / bare.window_s, memory = c.bytes / bare.bytes;
    fmt::print("  {:<14} time {:.3f}, memory {:.3f}, {:.3f} allocations a substep\n", v.name, time, memory,
               c.allocations);
    const std::string key = &v == kVariants ? "absent" : fmt::format("absent_but_idle_{}", v.name);
    out[key + "_time_ratio"] = time, out[key + "_memory_ratio"] = memory;
    out[key + "_allocations_per_substep"] = c.allocations;
  }
}

}  // namespace

ProcessBenchmark absent_benchmark() {
  return {
      "absent",
      {"absent_time_ratio", "absent_memory_ratio", "absent_but_idle_plasticity_time_ratio",
       "absent_but_idle_fibres_time_ratio", "absent_but_idle_fibres_memory_ratio", "absent_allocations_per_substep"},
      measure};
}

}  // namespace sunder::bench
