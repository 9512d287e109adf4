#pragma once
// The model and the state of all shells, soft bodies and copies of rigid bodies, and how they start. substep() moves
// them on.
#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "coupler/core/ticks.h"
#include "coupler/link/held_rows.h"
#include "shell/io/build.h"
#include "shell/run/part.h"
#include "shell/run/stages.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/shell_contact.h"

namespace sunder::shell {

/// Counts ticks and windows; time is never summed up.
struct Clock {
  Ticks ticks;
  std::int64_t tick = 0, windows = 0;
  double time() const { return ticks.time(tick); }  // [s]
};

/// What does not change during a run.
struct Model {
  const RunSetup& setup;
  int threads = 1;         // of each shell
  int shells_at_once = 1;  // shells that are solved at the same time, each then by one thread
  std::vector<char> tips;  // of each shell: cracks run at its tips
  const ShellSetup& shell(std::size_t k) const { return setup.shells[k]; }
};

/// Impulses of the engine on a body that the next pass of a window spreads over its substeps (scheme ITERATED).
struct Kick {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // [N s], [N m s]
};

/// What substeps change.
struct State {
  std::vector<ShellPart> shells;
  Stitching stitching;                    // of the shells along seams
  std::unique_ptr<ShellContact> contact;  // between shells; null: they cannot meet
  std::unique_ptr<Fibres> fibres;         // null: no shell has any
  SoftBodies soft;
  int soft_left = 0, soft_most = 0;  // substeps until the step of the soft bodies ends, and until the window does
  std::vector<Proxy> bodies;         // moving and static bodies of the scene, and shards, by id
  link::HeldRows rows;               // contacts and joints of the engine that substeps solve in its place
  std::vector<Kick> kicks;           // of each body that is not static
  std::uint64_t random = 0;
  std::int64_t substeps = 0;
  double engine_loss = 0.0;             // energy that contacts and joints between bodies took [J]
  double frozen_potential = 0.0;        // of the part that a support holds, once the shell is frozen [J]
  double kinetic = 0.0, elastic = 0.0;  // of shells and bodies, as last summed [J]

  /// Shells are not frozen yet; with soft bodies they never are.
  bool solving() const { return !soft.empty() || (!shells.empty() && shells.front().state); }
};

/// Memory that substeps reuse, and the wall time of their stages.
struct Scratch {
  StageTimes times;
  std::vector<ShellRef> refs;
  std::vector<std::exception_ptr> errors;
};

/// Model and state of each shell, until the next call.
const std::vector<ShellRef>& refs(State& state, Scratch& scratch);

/// Calls f with the number of each shell, of several at once. The first exception is thrown on.
template <class F>
void side_by_side(const Model& model, const State& state, Scratch& scratch, F&& f) {
  const std::size_t shells = state.shells.size();
  if (model.shells_at_once == 1) {
    for (std::size_t k = 0; k < shells; ++k) f(k);
    return;
  }
  scratch.errors.assign(shells, nullptr);
  const auto one = [&](std::size_t k) noexcept {
    try {
      f(k);
    } catch (...) {
      scratch.errors[k] = std::current_exception();
    }
  };
#pragma omp parallel for schedule(dynamic, 1) num_threads(model.shells_at_once)
  for (std::size_t k = 0; k < shells; ++k) one(k);
  for (const std::exception_ptr& e : scratch.errors)
    if (e) std::rethrow_exception(e);
}

class Simulation {
 public:
  /// `setup` outlives it. `threads` is the most that it may use.
  Simulation(RunSetup& setup, int threads);

  /// Empty shells, seams, contact and soft bodies of the scene; before start_shells() or a checkpoint.
  void prepare();
  /// States of all shells at time zero, in equilibrium where the scene asks for it. Throws Error where the scene's
  /// steps do not fit. `look` is called now and then; it may throw.
  void start_shells(const std::function<void()>& look);
  /// n substeps of `dt` [s], the first of which follows one of `last`; `now` is the time at their start [s]. `look` is
  /// called after each. Throws Error.
  void take_substeps(int n, double dt, double last, const Clock& clock, const std::function<void()>& look);
  /// Energy of all shells and bodies [J], with kinetic energies at the time of positions for substeps of `dt`.
  double total_energy(double dt);
  /// Kinetic and potential energy of the bodies [J].
  double bodies_energy() const;
  /// Length of a substep that shells are stable with, by the scene's rules [s].
  double substep_length(std::int64_t window);
  /// Substeps of such a length in a tick: a whole number. Throws Error (substeps) where they are too many.
  double substeps_of_tick(double substep, std::int64_t window) const;

  EnergyBook shell_book();  // of shells and soft bodies that are still solved [J]
  double crack_length();    // of shells that are still solved [m]
  /// How shell and body push one another, without Hertz's law.
  ContactCoefficients against(const ShellModel& shell, const RigidBody& body) const;
  const std::vector<ShellRef>& refs() { return shell::refs(state, scratch); }
  int soft_particles() const;
  /// Energy that soft bodies store at such a strain [J].
  double soft_energy(double strain) const;
  std::vector<BodyMotion> soft_motions() const;

  Model model;
  State state;
  Scratch scratch;

 private:
  void find_equilibrium(ShellPart& part, const std::function<void()>& look);
  double soft_substeps(double needed) const;
  void share_kick(double share);
  RunSetup& setup_;
};

}  // namespace sunder::shell
