#pragma once
// Shells, bodies and soft bodies that a test has made itself, stepped as a run steps them.
#include <memory>
#include <utility>
#include <vector>

#include "shell/run/simulation.h"
#include "shell/run/substep.h"

namespace sunder::shell {

/// A setup of these shells alone: {model, velocity} each.
inline RunSetup setup_of(std::vector<ShellSetup> shells) {
  RunSetup out;
  out.shells = std::move(shells);
  return out;
}

/// A simulation and the setup that it reads. Shells start at rest in their reference shape, but for the velocity that
/// the setup gives them: no equilibrium is sought, and no stable step is measured.
class Rig {
 public:
  explicit Rig(RunSetup setup, int threads = 1) : setup_(std::make_unique<RunSetup>(std::move(setup))) {
    for (ShellSetup& s : setup_->shells) s.hertz.resize(setup_->bodies.size(), 0.0);
    simulation_ = std::make_unique<Simulation>(*setup_, threads);
    simulation_->prepare();
    for (ShellPart& part : now().shells) {
      const ShellSetup& s = *part.setup;
      part.state = std::make_unique<ShellState>(make_state(s.model, s.velocity, setup_->seed));
      part.state->layers.brittleness = s.fracture.damage.brittleness;
      part.state->layers.heals = s.fracture.damage.heals;
      if (s.transfer.kind != Transfer::kDirect) part.state->motion.before = part.state->motion.v;
    }
    if (!now().stitching.empty()) now().stitching.move_masses(refs());
  }

  /// One substep of `dt` [s], after one of the same length.
  void step(double dt) { substep(simulation_->model, now(), simulation_->scratch, dt, dt); }
  /// A window of `n` substeps, with all that a run does between them; `look` after each.
  template <class F>
  void run(int n, double dt, F&& look) {
    simulation_->take_substeps(n, dt, dt, Clock{}, look);
  }
  void run(int n, double dt) {
    run(n, dt, [] {});
  }
  /// Shells touch one another, and themselves, by this law.
  void meet(const SurfaceLaw& law = {}) {
    const std::size_t n = size();
    now().contact =
        std::make_unique<ShellContact>(setup_->models(), setup_->stitches.seams,
                                       std::vector<std::vector<SurfaceLaw>>(n, std::vector<SurfaceLaw>(n, law)));
  }

  std::size_t size() const { return setup_->shells.size(); }
  RunSetup& setup() { return *setup_; }
  const RunSetup& setup() const { return *setup_; }
  State& now() { return simulation_->state; }
  const State& now() const { return simulation_->state; }
  Simulation& simulation() { return *simulation_; }
  StageTimes& times() { return simulation_->scratch.times; }
  const ShellModel& model(std::size_t k = 0) const { return setup_->shells[k].model; }
  ShellState& state(std::size_t k = 0) { return *now().shells[k].state; }
  const ShellState& state(std::size_t k = 0) const { return *now().shells[k].state; }
  Proxy& body(std::size_t k = 0) { return now().bodies[k]; }
  const std::vector<ShellRef>& refs() { return simulation_->refs(); }  // until the next call

 private:
  std::unique_ptr<RunSetup> setup_;
  std::unique_ptr<Simulation> simulation_;
};

}  // namespace sunder::shell
