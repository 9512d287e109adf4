#pragma once
// A shell in a run: its state, its contacts, its cuts, its stable step, and its pieces.
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "shell/fracture/crack_loops.h"
#include "shell/io/shell_setup.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/relaxation.h"

namespace sunder::shell {

/// Windows for which a step shortened by Hertz contact is kept: the first time, and at most.
constexpr std::int64_t kHertzKept = 64, kHertzKeptMost = 1 << 20;

/// The pieces of a shell at one moment.
struct PartPieces {
  bool whole = true;  // uncracked: one piece, no triangulation
  std::shared_ptr<const Triangulation> triangulation;
  std::vector<Piece> pieces;  // `held` and `interlocked` are those of the whole group
  std::vector<int> group;     // of each piece: equal numbers, over all shells, belong to one group

  /// Piece of a control point; -1: of none.
  int owner(int point) const { return whole ? 0 : triangulation->owner[point]; }
};

/// Local time step of a shell: it evaluates its forces at every n-th substep, counted from the start of a window, and
/// applies n times their impulse. A window holds a whole number of these steps.
struct LocalStep {
  int every = 1;       // n
  int before = 1;      // n of the last window
  int together = 1;    // the largest n of the shells that seams join to it: they are in step at every such substep
  double alone = 0.0;  // stable step without what seams join to it [s]
  std::vector<double> force;  // sum of the forces since all were in step [3][component stride] [N]

  /// True where forces are evaluated at substep k of a window.
  bool due(int k) const { return k % every == 0; }
  /// True where this shell and those that seams join to it end a step with substep k of a window.
  bool in_step(int k) const { return (k + 1) % together == 0; }
  /// Substeps that the last kick was for, at a substep k with a force evaluation.
  double kicked(int k) const { return k > 0 ? every : before; }
  /// Factor of the force at substep k. It makes a kick of (last + dt)/2 one from the middle of the own step before to
  /// the middle of the next.
  double factor(int k, double dt, double last) const {
    return k > 0 || every == before || last == 0.0 ? every : (before * last + every * dt) / (last + dt);
  }
};

/// One shell of a run.
struct ShellPart {
  explicit ShellPart(const ShellSetup& setup) : setup(&setup) {}

  const ShellSetup* setup;
  std::unique_ptr<ShellState> state;              // null before the start and after freezing
  std::vector<ContactCoefficients> coefficients;  // against each proxy, by its index
  ContactCandidates candidates;
  std::map<int, std::int64_t> detached_since;  // lowest control point of a piece -> tick of its detachment
  std::vector<Vec2> rubble;                    // centres of triangles of detached pieces without control points
  std::size_t edges_seen = 0;                  // number of crack edges when the stable step was last updated
  std::int64_t next_measure = 0;               // number of the window from which it may be measured again
  std::vector<Vec2> changed;  // places where shape functions or masses have changed since the last measurement
  // Of each control point: least distance to a neighbour, over that at rest, at which the step was measured; empty: 1.
  std::vector<float> closest;
  std::shared_ptr<const Triangulation> triangulated;  // the last triangulation for counting
  CrackLoops loops;
  double initial_step = 0.0, smallest_step = 0.0;  // stable steps [s]
  LocalStep local;
  RelaxationResult equilibrium;         // the last one, where the scene asks for it
  std::vector<RelaxationResult> steps;  // those of all load steps, where nothing moves
  std::vector<double> seam_force;       // of seams in the last of them [3][component stride] [N]
  double hertz_speed = 0.0;  // largest approach speed of a Hertz contact so far, rounded up to a power of two [m/s]
  double hertz_kept = 0.0;   // step of the last Hertz contact [s], kept for `hertz_windows` after it
  std::int64_t hertz_until = -1, hertz_windows = kHertzKept;

  const ShellModel& model() const { return setup->model; }
  /// Returns the stable step [s], with an allowance for cracks to come where the shell can crack.
  double step() const {
    return setup->can_crack() ? std::min(smallest_step, setup->cracked_step * initial_step) : smallest_step;
  }
  /// The same without what seams join to it, as it was last measured [s].
  double measured_alone() const {
    return smallest_step < initial_step ? std::min(local.alone, smallest_step) : local.alone;
  }
  /// That with the allowance [s].
  double step_alone() const {
    return setup->can_crack() ? std::min(measured_alone(), setup->cracked_step * local.alone) : measured_alone();
  }
  /// Shortens `step` [s] where a sphere with Hertz stiffness may touch the shell within two windows of `window` [s].
  /// The short step is kept for some time after, twice as long at each new contact. Reason: changing the step adds
  /// noise near the stability limit, and many changes in a row make energy grow. `now` is the number of the window.
  double step_with_hertz(double step, const std::vector<Proxy>& proxies, std::size_t bodies, const Vec3& gravity,
                         double window, std::int64_t now);
  /// Criteria that act at the start of a window insert their edges: cuts that are due up to `span` [s] after `now` [s].
  /// Returns the parts of seams that they open.
  std::vector<EdgeCut> cut(double now, double span, std::uint64_t& random);
  /// Measures the stable step again near changes by cracks, and where control points have come closer: what is squeezed
  /// is stiffer and shorter. `window` is the number of the window, `shells` are all of the run, whose fibres this one
  /// may touch.
  void measure_step(std::int64_t window, int threads, const std::vector<const ShellModel*>& shells);
  /// Adds to `changed` where the shell was squeezed since the last measurement. Returns whether it was. Control points
  /// beside cracks are left out: they move past one another.
  bool note_squeezed();
  /// Marks pieces without control points that have been handed off before.
  void mark_rubble(PartPieces& now) const;
  /// Returns a triangulation for counting pieces. Cracks that have grown within a piece may be missing, and knots are:
  /// use drawn() for pieces that are drawn or leave.
  std::shared_ptr<const Triangulation> counted();
  /// Returns a triangulation with all cracks, and with knots in the boxes `leaving`, where pieces are drawn or leave.
  std::shared_ptr<const Triangulation> drawn(std::span<const Eigen::AlignedBox2d> leaving) const;
  /// Remembers the triangles of a piece without control points that is handed off.
  void add_rubble(const Triangulation& t, int piece);
  Eigen::AlignedBox3d box() const;  // of the control points that are not handed off [m]
};

}  // namespace sunder::shell
