#pragma once
// Model and state of all shells, soft bodies and copies of rigid bodies, and their start. substep() advances them.
#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <vector>

#include "coupler/core/ticks.h"
#include "coupler/link/held_rows.h"
#include "shell/io/build.h"
#include "shell/run/pace.h"
#include "shell/run/part.h"
#include "shell/run/stages.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/shell_contact.h"
#include "shell/solver/joining/seam_damage.h"
#include "shell/solver/joining/seam_strength.h"

namespace sunder::shell {

/// Counts ticks and windows. Time is computed from ticks, never summed.
struct Clock {
  Ticks ticks;
  std::int64_t tick = 0, windows = 0;
  double time() const { return ticks.time(tick); }  // [s]
};

/// The constant part of a simulation.
struct Model {
  const RunSetup& setup;
  int threads = 1;         // threads of each shell
  int shells_at_once = 1;  // shells that are solved at the same time, by one thread each
  std::vector<char> tips;  // of each shell: 1 where cracks run at tips
  const ShellSetup& shell(std::size_t k) const { return setup.shells[k]; }
};

/// Force evaluations since the start, each weighted by the layer points of its shell, where local time steps are in
/// use.
struct LocalWork {
  double done = 0.0, without = 0.0;  // that were made; that one step for all shells would have made
  std::int64_t largest = 1;          // most substeps of one step of a shell
};

/// Impulses of the engine on a body that the next pass spreads over its substeps (scheme ITERATED).
struct Kick {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // [N s], [N m s]
};

/// The part of a simulation that substeps change.
struct State {
  std::vector<ShellPart> shells;
  Stitching stitching;                    // of the shells, along seams
  SeamStrength seam_strength;             // of seams that open at a force
  SeamDamage seam_damage;                 // of seams that open where damage is complete
  std::unique_ptr<ShellContact> contact;  // between shells; null where they cannot meet
  // What each shell has got from each other one by contact since the start [shell][other][3] [N s]; empty: not
  // measured.
  std::vector<double> shell_impulse;
  std::unique_ptr<Fibres> fibres;  // null where no shell has any
  SoftBodies soft;
  int soft_left = 0, soft_most = 0;  // substeps until the soft bodies' step ends; until the window ends
  int in_window = 0;                 // number of the present substep in its window
  LocalWork local_work;              // what local time steps have saved so far
  std::vector<Proxy> bodies;         // moving and static bodies of the scene, then shards, by id
  link::HeldRows rows;               // contacts and joints of the engine that substeps solve
  std::vector<Kick> kicks;           // of each moving body
  std::uint64_t random = 0;
  std::int64_t substeps = 0;
  double engine_loss = 0.0;             // energy taken by contacts and joints between bodies [J]
  double driven_work = 0.0;             // of driven bodies, on other bodies [J]
  double frozen_potential = 0.0;        // of the held part, after freezing [J]
  double kinetic = 0.0, elastic = 0.0;  // of shells and bodies, when last summed [J]

  /// Kinetic energy of driven bodies [J]. Rows and the engine change it by the work that keeps them on their way.
  double driven_energy() const;
  /// True where a body changes its shape. The engine does not hold it, so shells go on to the end.
  bool deforms() const {
    return std::any_of(bodies.begin(), bodies.end(), [](const Proxy& p) { return p.deforms(); });
  }
  /// True while shells are solved. With soft bodies the shells are never frozen.
  bool solving() const { return !soft.empty() || (!shells.empty() && shells.front().state); }
};

/// Reused memory of substeps, the wall time of their stages, and their threads.
struct Scratch {
  StageTimes times;
  Pace pace;
  std::vector<ShellRef> refs;
  std::vector<std::exception_ptr> errors;
};

/// Returns model and state of each shell; valid until the next call.
const std::vector<ShellRef>& refs(State& state, Scratch& scratch);

/// Calls f with the number of each shell, `at_once` of them at the same time. Throws the first exception on.
template <class F>
void side_by_side(const State& state, Scratch& scratch, int at_once, F&& f) {
  const std::size_t shells = state.shells.size();
  if (at_once == 1) {
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
#pragma omp parallel for schedule(dynamic, 1) num_threads(at_once)
  for (std::size_t k = 0; k < shells; ++k) one(k);
  for (const std::exception_ptr& e : scratch.errors)
    if (e) std::rethrow_exception(e);
}

/// Steps all shells, soft bodies and copies of rigid bodies.
class Simulation {
 public:
  /// `setup` must outlive it. `threads` is the largest number that it may use.
  Simulation(RunSetup& setup, int threads);

  /// Makes empty shells, seams, contact and soft bodies. Call it before start_shells() or before loading a checkpoint.
  void prepare();
  /// Makes the states of shells that have none, at time zero, at rest in their reference shape or with their initial
  /// velocity.
  void make_states();
  /// Moves all shells that ask for it to equilibrium, at load step `step` where nothing moves; those that seams join
  /// are in equilibrium together. Throws Error (equilibrium), and leaves shells that fail in the last equilibrium that
  /// was found on the way.
  void find_equilibria(int step, const std::function<void()>& look);
  /// Gravity [m/s^2] on a shell at the present load step.
  Vec3 gravity_on(const ShellPart& part) const;
  /// Makes the states of all shells at time zero, in equilibrium where the scene asks for it. Throws Error where the
  /// scene's steps are too long or an equilibrium is not found. `look` is called now and then; it may throw.
  void start_shells(const std::function<void()>& look);
  /// Takes n substeps of `dt` [s]; `last` is the substep before them [s]. `look` is called after each. Throws Error
  /// where physics fails.
  void take_substeps(int n, double dt, double last, const Clock& clock, const std::function<void()>& look);
  /// Returns the energy of all shells and bodies [J]. Kinetic energies are those of the time of positions, for substeps
  /// of `dt` [s].
  double total_energy(double dt);
  /// Kinetic and potential energy of the bodies [J].
  double bodies_energy() const;
  /// Returns the length [s] of a substep that is stable for the shells, by the scene's rules.
  double substep_length(std::int64_t window);
  /// Returns the whole number of substeps of at most `substep` [s] in a tick. Throws Error (substeps) above
  /// kMostSubsteps in a window.
  double substeps_of_tick(double substep, std::int64_t window) const;

  /// Chooses the local time steps of a window of `ticks` ticks of `tick` [s], each of which needs `least` substeps.
  /// Returns the number of substeps in the window. A tick holds a whole number of every shell's steps, so the substep
  /// does not depend on the window. Where the scene does not ask for them, it is `least` in each tick.
  int choose_local_steps(double tick, int least, int ticks);

  /// Releases supports that are due up to `span` [s] after `now` [s]. `dt` [s] is the last substep. Returns whether
  /// any was due.
  bool release_supports(double now, double span, double dt);
  /// Gives models the supports that states from a checkpoint have. Call it after loading one.
  void restore_supports();

  EnergyBook shell_book();  // of shells and soft bodies that are solved [J]
  double crack_length();    // of shells that are solved [m]
  /// Returns the contact law of a shell and a body, without Hertz stiffness.
  ContactCoefficients contact_law(const ShellModel& shell, const RigidBody& body) const;
  const std::vector<ShellRef>& refs() { return shell::refs(state, scratch); }
  int soft_particles() const;
  /// Returns the energy that all soft bodies store at this strain [J].
  double soft_energy(double strain) const;
  /// Centre and mean velocity of each soft body.
  std::vector<BodyMotion> soft_motions() const;

  Model model;
  State state;
  Scratch scratch;

 private:
  void make_state_of(ShellPart& part) const;
  void find_equilibrium(const std::vector<int>& group, const std::function<void()>& look);
  /// An equilibrium is found without fibres. Throws Error (equilibrium) where layers overlap in it, so that fibres
  /// would have borne something.
  void require_layers_apart();
  double soft_substeps(double needed) const;
  // Multiplies the forces of shells with a local time step, as in a kick. Returns forces and loads as they were, of
  // each shell; nothing where none has such a step.
  std::vector<std::vector<double>> weigh_forces(double dt);
  void restore_forces(const std::vector<std::vector<double>>& plain);
  void share_kick(double share);
  RunSetup& setup_;
};

}  // namespace sunder::shell
