#pragma once
// A shell as a run solves it: its state, what it may touch, and what the run knows of its pieces.
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "shell/fracture/crack_loops.h"
#include "shell/io/shell_setup.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// Windows that a step shortened for a Hertz contact is kept for, at first and at most.
constexpr std::int64_t kHertzKept = 64, kHertzKeptMost = 1 << 20;

/// What a shell has come apart into.
struct PartPieces {
  bool whole = true;  // uncracked: one piece, and no triangulation
  std::shared_ptr<const Triangulation> triangulation;
  std::vector<Piece> pieces;  // `held` and `interlocked` of all that hangs together with them
  std::vector<int> group;     // of each: pieces of all shells with the same number hang together
};

struct ShellPart {
  explicit ShellPart(const ShellSetup& setup) : setup(&setup) {}

  const ShellSetup* setup;
  std::unique_ptr<ShellState> state;              // none before the start and once frozen
  std::vector<ContactCoefficients> coefficients;  // against each proxy, by index
  ContactCandidates candidates;
  std::map<int, std::int64_t> detached_since;  // lowest control point of a piece -> tick
  std::vector<Vec2> rubble;                    // centres of pieces without control points that have left
  std::size_t edges_seen = 0;                  // crack edges that the stable step knows
  std::int64_t next_measure = 0;               // window from which the stable step may be measured again
  std::vector<Vec2> changed;  // where shape functions or masses have changed since it was last measured
  std::shared_ptr<const Triangulation> triangulated;  // the last one that was counted
  CrackLoops loops;
  double initial_step = 0.0, smallest_step = 0.0;  // stable ones [s]
  double hertz_speed = 0.0;  // fastest that a sphere with Hertz contact and the shell have met [m/s]
  double hertz_kept = 0.0;   // the step that the last one took [s], kept for `hertz_windows` after it has gone
  std::int64_t hertz_until = -1, hertz_windows = kHertzKept;

  const ShellModel& model() const { return setup->model; }
  /// The stable step that cracks to come will leave.
  double step() const {
    return setup->can_crack() ? std::min(smallest_step, setup->cracked_step * initial_step) : smallest_step;
  }
  /// `step` shortened where spheres with a Hertz stiffness are about to be met, within `window` seconds, and for some
  /// time afterwards, twice as long with each that comes back: what steps change with, whatever vibrates near the
  /// stable step gains or loses by chance, and of many such changes there comes a gain. `now` counts windows.
  double with_hertz(double step, const std::vector<Proxy>& proxies, std::size_t bodies, const Vec3& gravity,
                    double window, std::int64_t now);
  /// Criteria that act at the start of a window insert their edges: cuts that are due up to `span` [s] after `now` [s].
  /// Returns what they open of seams.
  std::vector<EdgeCut> cut(double now, double span, std::uint64_t& random);
  /// Measures the stable step again where cracks have changed something; `window` counts windows.
  void measure_step(std::int64_t window, int threads);
  /// Pieces without control points that have left are gone.
  void mark_rubble(PartPieces& now) const;
  /// Whose pieces are those of the present cracks, but cracks that have grown within a piece may be missing, and knots:
  /// not fit to be drawn or to leave.
  std::shared_ptr<const Triangulation> counted();
  /// Of all present cracks, with knots in these boxes: fit to be drawn and to leave there.
  std::shared_ptr<const Triangulation> drawn(std::span<const Eigen::AlignedBox2d> leaving) const;
  void add_rubble(const Triangulation& t, int piece);
  Eigen::AlignedBox3d box() const;  // of the control points that have not left
};

}  // namespace sunder::shell
