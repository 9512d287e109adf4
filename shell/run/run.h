#pragma once
// A whole run: windows of substeps against proxies, exchanged with the rigid process.
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "coupler/core/ticks.h"
#include "coupler/link/held_rows.h"
#include "coupler/link/rigid_link.h"
#include "shell/io/build.h"
#include "shell/io/frames.h"
#include "shell/io/trace.h"
#include "shell/run/part.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/contact/shell_contact.h"

namespace sunder::shell {

class Run;

constexpr double kBirthTolerance = 1e-10;  // of a newborn's mass, momentum and angular momentum

struct RunOptions {
  std::string out, scene_hash;
  std::string record, replay, trace;  // files; empty: not
  std::string keys;                   // folder of the keys of an encrypted session; empty: none
  bool resume = false;                // from the checkpoint in `out`
  /// The rigid side. Asked once, at the start.
  std::function<std::unique_ptr<link::RigidLink>(const RunOptions&)> connect;
  std::function<void(const link::TimedReply&)> heard;  // set by the run where it is traced
  // For programs that hold a run in themselves: called after every window; and before a window's ledger is checked.
  std::function<void(const Run&)> observe;
  std::function<void(std::int64_t window, std::vector<Proxy>&)> tamper;
  double until = 0.0;  // [s]; 0: the scene's end
  int threads = 1;
  bool quiet = false;
};

/// A piece that was handed off, as shards.csv has it.
struct ShardRecord {
  BodyId id = 0;
  double birth = 0.0, area = 0.0, mass = 0.0;  // [s], [m^2], [kg]
  double birth_speed = 0.0;                    // [m/s]
  int parts = 0;                               // convex ones
};

/// Seconds of wall time since some moment before the run.
inline double wall_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Stopwatch {
  double& sum;
  double start = wall_clock();
  explicit Stopwatch(double& sum) : sum(sum) {}
  ~Stopwatch() { sum += wall_clock() - start; }
};

class Run {
 public:
  Run(RunSetup setup, RunOptions options);
  /// Returns done or interrupted; throws Error after run.json says why.
  Exit execute(const std::atomic<bool>& interrupted);

  double time() const { return ticks().time(tick_); }               // [s]
  double mechanical_energy() const { return kinetic_ + elastic_; }  // of shell and bodies, as last summed [J]
  const std::vector<Proxy>& bodies() const { return proxies_; }
  double hardest() const { return hardest_; }  // largest k H^2 / M that was measured [-]
  int exported() const { return static_cast<int>(ever_exported_.size()); }

 private:
  void start();
  void start_shells();
  void find_equilibrium(ShellPart& part);
  void shell_window();
  const std::vector<ShellRef>& refs();  // until the next call
  /// Calls f with the number of each shell, of several at once.
  template <class F>
  void side_by_side(F&& f) {
    if (at_once_ == 1) {
      for (std::size_t k = 0; k < parts_.size(); ++k) f(k);
      return;
    }
    errors_.assign(parts_.size(), nullptr);
    const auto one = [&](std::size_t k) noexcept {
      try {
        f(k);
      } catch (...) {
        errors_[k] = std::current_exception();
      }
    };
#pragma omp parallel for schedule(dynamic, 1) num_threads(at_once_)
    for (std::size_t k = 0; k < parts_.size(); ++k) one(k);
    for (const std::exception_ptr& e : errors_)
      if (e) std::rethrow_exception(e);
  }
  // Shells are not frozen yet; with soft bodies they never are.
  bool solving() const { return !soft_.empty() || (!parts_.empty() && parts_.front().state); }
  ContactCoefficients against(const ShellModel& shell, const RigidBody& body) const;
  bool has_grid_transfer() const {
    return std::any_of(setup_.shells.begin(), setup_.shells.end(),
                       [](const ShellSetup& s) { return s.transfer.kind != Transfer::kDirect; });
  }
  EnergyBook book() const;          // of all shells
  double crack_length() const;      // [m]
  double crack_resistance() const;  // by fracture energy and area [J]
  void rigid_window();
  void fly(double window, std::size_t count);  // the first `count` bodies fall freely
  void look_around();                          // at the peer and the progress, by the clock
  void close_books(double energy);             // present and booked energy together [J]
  [[noreturn]] void unstable(double energy) const;
  bool impact_ahead() const;  // a body of the scene flies towards a shell
  bool impact_ahead(const ShellPart& part) const;
  /// Pieces, by shell and index, that hang together.
  struct Group {
    std::vector<std::pair<std::size_t, std::size_t>> members;
    bool empty = true;   // no control point
    bool bends = false;  // is large
    bool torn = false;   // of a shell that is in pieces, or off one that it was joined to
  };
  /// Of each shell, boxes in its parameters.
  using PartBoxes = std::vector<std::vector<Eigen::AlignedBox2d>>;
  /// Fit to leave in the boxes; of shells that have none, and of all where none are given, only counted.
  std::vector<PartPieces> pieces_now(bool all, const PartBoxes& leaving);
  PartBoxes everywhere() const;
  PartBoxes boxes_of(const std::vector<PartPieces>& now, const std::map<int, Group>& groups,
                     const std::vector<int>& roots) const;
  std::map<int, Group> groups_of(const std::vector<PartPieces>& now) const;
  bool is_to_leave(const std::vector<PartPieces>& now, const Group& group, bool all);
  Totals shell_totals();
  /// `totals_now`: those of the shells, which it keeps up to date.
  RigidBody leave(std::vector<PartPieces>& now, const Group& group, Totals& totals_now);
  void check_handoff(const Totals& before, const Totals& after, const RigidBody& body);
  std::int64_t settle_ticks() const;  // length of the next window without a shell
  std::string checkpoint_path() const;
  void save_checkpoint();
  void load_checkpoint();
  template <class A>
  void archive_members(A& a);
  void check_engine() const;  // that it can do what the scene needs
  /// What it cannot do and a run can go without, in sentences.
  std::vector<std::string> engine_notes() const;
  void traced(const char* name, std::int64_t begin_ns) {
    if (!options_.trace.empty()) trace_.add(name, begin_ns, Trace::now_ns(), windows_);
  }
  /// Velocities, half the `last` substep behind positions, go on to half of this one before them; then positions by
  /// `dt`.
  void substep(double dt, double last);
  void crack(ShellPart& part, int k, int n, double dt);  // after substep k of n
  void take_substeps(int n, double dt);
  // soft_run.cpp
  double soft_substeps(double needed) const;  // of a tick, where shells need so many
  void soft_contact(double dt);
  int soft_particles() const;
  double soft_energy(double strain) const;  // that they store at such a strain [J]
  void add_soft_hardness(std::vector<double>& hardness) const;
  std::vector<BodyMotion> soft_motions() const;
  Ticks ticks() const { return {setup_.tick}; }
  std::int64_t end_tick() const { return ticks().nearest(setup_.end_time); }
  // coupling.cpp
  std::vector<link::Motion> motions() const;
  void open_window(double window);
  void choose_exported();
  void add_hardness(ShellPart& part, std::vector<double>& hardness);  // k H^2 / M of each proxy [-]
  void iterate_window(int n, double dt);
  void share_kick(double share);
  /// What the engine is told of the first `count` bodies; `substeps` over which kicks were spread.
  std::vector<link::Motion> handbacks(double window, std::size_t count, int substeps) const;
  void adapt_window();
  std::vector<RigidBody> take_off(bool all);
  void exchange(int ticks, double window, const std::vector<RigidBody>& births);
  void check_ledger(double window);
  /// Relative errors of a birth; throws Error (ledger) where one is too large.
  void check_birth(const RigidBody& body, double mass, double linear, double angular, double tolerance,
                   const char* where);
  /// Joints whose end has come; joint_breaks.cpp.
  void let_joints_go();
  std::string joints_summary() const;  // for run.json
  void check_births(const std::vector<RigidBody>& births, const std::vector<link::State>& states);
  /// Why the shell may be frozen now; empty: it may not.
  std::string cracking_has_ended();
  void freeze_shell(const std::string& why);
  double total_energy(double dt);
  double bodies_energy() const;
  void write_frame();
  void write_series_row();
  void write_probes();
  void write_shards() const;
  std::string shards_summary() const;
  void write_summary(const std::string& status, const Error* error);
  /// What a user should know before trusting the run, in sentences.
  std::vector<std::string> warnings() const;
  void progress();
  std::string state_hash() const;

  /// Impulses of the engine that the next pass of a window spreads over its substeps.
  struct Kick {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // [N s], [N m s]
  };

  RunSetup setup_;
  RunOptions options_;
  FrameWriter frames_;
  Trace trace_;
  std::unique_ptr<link::RigidLink> rigid_;
  std::vector<ShellPart> parts_;
  std::vector<ShellRef> refs_;                   // scratch of refs()
  std::vector<std::exception_ptr> errors_;       // scratch of side_by_side()
  Stitching stitching_;                          // of them
  std::unique_ptr<ShellContact> shell_contact_;  // between them; null: they cannot meet
  std::unique_ptr<Fibres> fibres_;               // null: no shell has any
  SoftBodies soft_;
  int soft_left_ = 0, soft_most_ = 0;  // substeps until their step ends, and until the window does
  int at_once_ = 1;                    // shells that are solved at the same time; each then by one thread
  std::vector<char> tips_;             // which of them crack at tips
  std::vector<Proxy> proxies_;         // moving and static bodies of the scene and shards, by id
  const std::atomic<bool>* interrupted_ = nullptr;
  std::uint64_t random_ = 0;
  std::int64_t tick_ = 0, windows_ = 0, substeps_ = 0;
  BodyId first_shard_ = 1, next_id_ = 1;
  int fragments_ = 0, handed_off_ = 0, rubble_points_ = 0;
  double handed_area_ = 0.0, detached_area_ = 0.0, dt_ = 0.0,
         last_dt_ = 0.0;                                 // substep of this window and the one before [s]
  double last_push_ = -1.0;                              // when a moving body of the scene last touched the shell [s]
  std::deque<std::pair<double, double>> crack_lengths_;  // time [s], total length [m], over the quiet time
  double energy_scale_ = 0.0, reference_energy_ = 0.0, engine_loss_ = 0.0, residual_ = 0.0, support_work_ = 0.0;
  double kinetic_ = 0.0, elastic_ = 0.0;
  double ledger_linear_ = 0.0, ledger_angular_ = 0.0;
  double mass_error_ = 0.0, momentum_error_ = 0.0, angular_error_ = 0.0, geometry_error_ = 0.0;
  double next_frame_ = 0.0, wall_start_ = 0.0, last_progress_ = 0.0, last_look_ = 0.0;
  double frozen_length_ = 0.0, frozen_resistance_ = 0.0;                  // of its cracks [m], [J]
  double frozen_kinetic_ = 0.0;                                           // of the shell, as it was frozen [J]
  double frozen_at_ = -1.0, frozen_potential_ = 0.0, frozen_wall_ = 0.0;  // [s], [J] of what stays where it is
  std::string frozen_why_, frozen_hash_;                                  // hash of the shell as it was frozen
  std::vector<ShardRecord> shards_;
  EnergyBook book_;  // of the shells, kept when they are frozen
  std::map<std::string, double> stage_s_;
  double growing_s_ = 0.0, growing_update_s_ = 0.0;  // of windows in which cracks grew: all, and crack_update
  std::string series_, probes_;
  double next_probe_ = 0.0;       // [s]
  double next_checkpoint_ = 0.0;  // [s]
  // Coupling.
  int window_ticks_ = 1, shortest_window_ = 1;
  double window_start_wall_ = 0.0;
  std::vector<link::Motion> starts_;                            // of the present window
  link::HeldRows rows_;                                         // that its substeps solve
  std::vector<BodyId> solved_;                                  // whose rows they are
  std::map<BodyId, std::int64_t> held_until_, exported_until_;  // window
  std::set<BodyId> ever_exported_;
  std::vector<std::uint32_t> released_;  // joints that have let go, by id
  std::vector<double> let_go_s_;         // when each joint has; negative: it holds
  std::vector<Kick> kicks_;              // of each body that is not static
  std::vector<link::Motion> answered_;   // handbacks of the last pass, and the engine's answer
  std::vector<link::State> agreed_;
  std::int64_t exported_windows_ = 0, passes_ = 0;
  int most_passes_ = 0;
  double contact_taken_ = 0.0, contact_given_ = 0.0;                                        // at most [J]
  double hardest_ = 0.0, window_residual_ = 0.0, residual_sum_ = 0.0, residual_max_ = 0.0;  // [-], [J]
};

}  // namespace sunder::shell
