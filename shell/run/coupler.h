#pragma once
// How the shell shares a window with the rigid side: exported contacts, predicted states, the engine's answer, and the
// ledger of impulses that closes each window.
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "coupler/link/rigid_link.h"
#include "shell/run/mass_ratio.h"
#include "shell/run/nearness.h"
#include "shell/run/simulation.h"

namespace sunder::shell {

constexpr double kBirthTolerance = 1e-10;  // of a new body's mass, momentum and angular momentum [-]

/// Largest relative errors of bodies at birth [-]. Plain numbers, so a checkpoint stores them as bytes.
struct BirthErrors {
  double mass = 0.0, momentum = 0.0, angular_momentum = 0.0;
};
/// Records the relative errors of a birth in `most`. Throws Error (ledger) where one is above `tolerance` or not a
/// number. `where` it was born and `whose` mass and momentum the errors are shares of are words of the message.
void check_birth(BirthErrors& most, const RigidBody& body, const BirthErrors& found, double tolerance,
                 const char* where, const char* whose, std::int64_t window);

/// Throws Error where the engine lacks a capability that the scene needs; the message names both.
void check_engine(const RunSetup& setup, const link::EngineInfo& peer);
/// Lists capabilities that the engine lacks and the run can go without, one sentence each. Without them it comes out
/// differently: they are warnings of run.json.
std::vector<std::string> engine_notes(const RunSetup& setup, const link::EngineInfo& peer);

/// Couples the shells to the rigid side, window by window, and keeps the ledger.
class Coupler {
 public:
  /// All references must outlive the coupler. Tests use `tamper`, which is called before a window's ledger is checked.
  Coupler(const RunSetup& setup, Simulation& simulation, Clock& clock,
          std::function<void(std::int64_t, std::vector<Proxy>&)> tamper);

  void connect(link::RigidLink& rigid) { rigid_ = &rigid; }
  /// Loads the scene's bodies, contact laws and joints into the engine.
  void load();
  /// Loads bodies from a checkpoint into the engine, then its `caches`.
  void restore(const std::string& caches);

  /// Opens a window of this length [s]: stores the starting states and fetches the engine's rows that substeps solve.
  /// Throws Error where the engine fails.
  void open_window(double window);
  /// Runs the scheme ITERATED: repeats the window's n substeps of `dt` [s] until both sides agree. `last` is the
  /// preceding substep [s]; `look` is as for Simulation::take_substeps.
  void iterate_window(int n, double dt, double last, const std::function<void()>& look);
  /// Checks that each body has gained what the shells lost, to round-off. `dt` is the substep [s]. Throws Error
  /// (ledger).
  void check_ledger(double window, double dt);
  /// Sends predicted states and new bodies, takes over the engine's states, and closes the window. Throws Error
  /// (ledger) for a wrong birth.
  void exchange(int ticks, double window, const std::vector<RigidBody>& births);
  /// Halves or doubles the next window by this window's energy residual, where the scene gives a tolerance.
  void adapt_window(double energy_scale);

  int window_ticks() const { return window_ticks_; }
  void limit_window(std::int64_t ticks) {
    window_ticks_ = static_cast<int>(std::min<std::int64_t>(window_ticks_, ticks));
  }
  int shortest_window() const { return shortest_window_; }  // [ticks]
  /// Largest stiffness ratio k H^2 / M that was measured [-].
  double stiffest_ratio() const { return stiffest_; }
  std::size_t exported_bodies() const { return ever_exported_.size(); }
  std::int64_t exported_windows() const { return exported_windows_; }
  std::int64_t passes() const { return passes_; }
  double residual_sum() const { return residual_sum_; }  // [J]
  double residual_max() const { return residual_max_; }  // [J]
  double ledger_linear() const { return ledger_linear_; }
  double ledger_angular() const { return ledger_angular_; }
  /// Time at which each joint was released [s]; negative while it holds.
  const std::vector<double>& released_at() const { return released_at_; }
  /// The worst pair of a heavy body on a light one, where the engine does not hold any.
  const HeavyPair& heavy_pair() const { return heavy_pair_; }
  /// The first body with a prescribed motion that was pressed on what does not give way, and when [s]; 0: none.
  const std::pair<BodyId, double>& blocked() const { return blocked_; }
  /// How near moving bodies have come to shells, as far as it was looked at.
  const Nearness& near() const { return near_; }
  BirthErrors& birth_errors() { return birth_errors_; }
  const BirthErrors& birth_errors() const { return birth_errors_; }

  template <class A>
  friend void archive(A& a, Coupler& c) {
    archive_all(a, c.window_ticks_, c.shortest_window_, c.held_until_, c.exported_until_, c.ever_exported_, c.released_,
                c.released_at_, c.exported_windows_, c.passes_, c.most_passes_, c.stiffest_, c.window_residual_,
                c.residual_sum_, c.residual_max_, c.ledger_linear_, c.ledger_angular_, c.birth_errors_, c.heavy_pair_,
                c.blocked_, c.engine_motions_, c.near_);
  }

 private:
  /// The bodies of the list, in the order of State::bodies, whose shape does not change.
  std::vector<RigidBody> held_by_engine(const std::vector<RigidBody>& bodies) const;
  std::vector<link::Motion> motions() const;
  /// Largest speed of any point of a moving body in a window [m/s].
  double fastest_body(double window) const;
  /// The body with a prescribed motion that the engine has slowed down most, beyond what free bodies take; 0: none.
  /// `kept`: motions of such bodies as the scene says, in order. `fastest`: largest speed before [m/s].
  BodyId blocked_body(const std::vector<BodyMotion>& kept, double fastest) const;
  void choose_exported();
  void add_stiffness_ratio(ShellPart& part, std::vector<double>& ratio);  // adds k H^2 / M of each body [-]
  void add_soft_stiffness_ratio(std::vector<double>& ratio) const;
  /// Predicted states of the first `count` bodies. `substeps` is the number that kicks were spread over; 0: no kicks.
  std::vector<link::Motion> predicted_states(double window, std::size_t count, int substeps) const;
  void check_births(const std::vector<RigidBody>& births, const std::vector<link::State>& states);
  void release_joints();

  const RunSetup& setup_;
  Simulation& simulation_;
  State& state_;
  Clock& clock_;
  std::function<void(std::int64_t, std::vector<Proxy>&)> tamper_;
  link::RigidLink* rigid_ = nullptr;

  int window_ticks_ = 1, shortest_window_ = 1;
  std::vector<link::Motion> starts_;                            // moving bodies at the start of this window
  std::vector<BodyId> solved_;                                  // bodies whose contacts and joints the substeps solve
  std::map<BodyId, std::int64_t> held_until_, exported_until_;  // number of a window
  std::set<BodyId> ever_exported_;
  std::vector<std::uint32_t> released_;  // released joints, sorted by id
  std::vector<double> released_at_;
  std::vector<link::Motion> sent_;  // predicted states of the last pass; the engine's answer is in agreed_
  std::vector<link::State> agreed_;
  std::int64_t exported_windows_ = 0, passes_ = 0;
  int most_passes_ = 0;
  double stiffest_ = 0.0, window_residual_ = 0.0, residual_sum_ = 0.0, residual_max_ = 0.0;
  double ledger_linear_ = 0.0, ledger_angular_ = 0.0;
  BirthErrors birth_errors_;
  HeavyPair heavy_pair_;
  std::pair<BodyId, double> blocked_{0, 0.0};
  Nearness near_;
  std::map<BodyId, BodyMotion> engine_motions_;  // the engine's last ones, of bodies with a prescribed motion
};

}  // namespace sunder::shell
