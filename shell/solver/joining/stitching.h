#pragma once
// Shells that hang together along seams: control points that follow others, and creases that keep their angle.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "coupler/core/archive.h"
#include "shell/geometry/seams.h"
#include "shell/solver/state.h"

namespace sunder::shell {

class Stitching {
 public:
  Stitching() = default;
  /// Patches of `stitches` are the models of `shells`, in their order. Throws Error where a support holds a seam along
  /// one shell only.
  Stitching(const Stitches& stitches, const std::vector<const ShellModel*>& shells);

  bool empty() const { return ties_.empty(); }
  /// Control points that follow give their mass to those that they follow; at the start, after make_state.
  void tie(const std::vector<ShellRef>& shells);
  /// After compute_forces of all shells: hands the forces of control points that follow, and what cracks have changed
  /// of them, to those that they follow, and leaves them what makes them accelerate alike.
  void share_forces(const std::vector<ShellRef>& shells);
  /// After kick, before contact: what velocities are without impulses.
  void mark(const std::vector<ShellRef>& shells);
  /// After contact: impulses on control points that follow act on those that they follow. What that changes in the
  /// work of contact is booked.
  void share_impulses(const std::vector<ShellRef>& shells);
  /// After that, before drift: impulses that let creases have their angle after a drift of `dt`. They act along lines
  /// between the control points that they move (SHAKE), so that momentum and angular momentum stay, and do no work.
  void keep_angles(const std::vector<ShellRef>& shells, double dt);

  /// Velocities of control points that follow, from those that they follow.
  void follow(const std::vector<ShellRef>& shells) const;
  /// Calls back (shell, slot, shell, slot) for each pair that still hangs together.
  template <class F>
  void each_link(F&& callback) const {
    for (const Tie& t : ties_)
      for (std::size_t k = 0; t.holds && k < t.on.size(); ++k)
        if (std::abs(t.on[k].weight) > kLooseWeight) callback(t.shell, t.slot, t.on[k].shell, t.on[k].slot);
  }
  /// Control points that `leaves(shell, slot)` go free again, and so do those that follow them; each takes its mass
  /// back with its velocity, which keeps momentum and angular momentum and loses some kinetic energy. Returns whether
  /// any was let go.
  template <class F>
  bool release(const std::vector<ShellRef>& shells, F&& leaves) {
    bool any = false;
    for (Tie& t : ties_) {
      bool out = leaves(t.shell, t.slot);
      for (const Master& m : t.on) out = out || leaves(m.shell, m.slot);
      if (t.holds && out) let_go(shells, t), any = true;
    }
    for (Brace& b : braces_) {
      for (const Term& m : b.ends) b.holds = b.holds && !leaves(m.shell, m.slot);
      for (const Term& m : b.terms) b.holds = b.holds && !leaves(m.shell, m.slot);
    }
    return any;
  }

  /// Crack edges of a shell that have been asked whether they leave it over a seam.
  std::vector<std::int64_t>& edges_seen() { return edges_seen_; }
  /// Where a crack crosses a seam, at share `t` of its first edge: control points that follow others beyond it are let
  /// go.
  void part(const std::vector<ShellRef>& shells, const Seam& seam, double t);
  /// Where a crack of `shell` runs along a seam, from share `low` of its first edge to `high`: what hangs on control
  /// points that it has hidden from the seam is let go.
  void part_beside(const std::vector<ShellRef>& shells, const Seam& seam, int shell, double low, double high);
  /// Lets go of all that a seam ties from share `low` of its first edge to `high`.
  void open(const std::vector<ShellRef>& shells, const Seam& seam, double low, double high);
  /// After these: at a corner of patches the shells that meet there stay together while seams that go out from it, each
  /// to its next control points, hold them together.
  void settle_corners(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams);
  /// Something has been let go.
  bool parted() const {
    return std::any_of(ties_.begin(), ties_.end(), [](const Tie& t) { return !t.holds; });
  }

  template <class A>
  friend void archive(A& a, Stitching& s) {
    for (Tie& t : s.ties_) archive_one(a, t.holds);
    for (Brace& b : s.braces_) archive_one(a, b.holds);
    archive_one(a, s.edges_seen_);
  }

 private:
  static constexpr double kLooseWeight = 1e-9;  // round-off
  struct Term {
    int shell, slot;
    double weight;
  };
  struct Master : Term {
    double share = 0.0;  // of the mass of what follows; none where the weight is negative, or masses could vanish
    Vec3 before = Vec3::Zero();  // velocity without impulses
  };
  struct Tie {
    int shell, slot;
    std::vector<Master> on;
    bool holds = true;
    Vec3 before = Vec3::Zero();  // velocity without impulses
  };
  void share(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&));
  /// Keeps the length of a weighted sum of control points beside a crease (weights sum to 0), which is its angle.
  struct Brace {
    std::vector<Term> ends;   // as the geometry has it
    std::vector<Term> terms;  // what moves them
    double length = 0.0;      // at rest [m]
    bool holds = true;
  };
  /// Of a control point of the rows that a seam ties: where it is beside it as a share of the first edge, whether it
  /// sees that place, and whether it is there itself.
  struct Foot {
    int side = 0;  // 1: of the first patch, 2: of the second, 0: of no such row
    bool clear = true, on_seam = false;
    double share = 0.0;
  };
  static Foot foot_of(const std::vector<ShellRef>& shells, const Seam& seam, const Term& term, bool look);
  static bool ties_both(const std::vector<ShellRef>& shells, const Seam& seam, const std::vector<Term>& terms);
  static std::vector<Term> named(const Tie& tie);
  static bool at_corner(const std::vector<ShellRef>& shells, const Tie& tie);
  static void book_lost(const std::vector<ShellRef>& shells, int shell, double lost);
  template <class F>
  void part_where(const std::vector<ShellRef>& shells, const Seam& seam, F&& across);
  /// Returns the kinetic energy that is lost [J].
  double let_go(const std::vector<ShellRef>& shells, Tie& tie);
  static double turn(const std::vector<ShellRef>& shells, const Tie& tie, const Vec3& turning);
  static void refresh(const std::vector<ShellRef>& shells, const Tie& tie);

  std::vector<Tie> ties_;
  std::vector<Brace> braces_;
  std::vector<std::int64_t> edges_seen_;
};

}  // namespace sunder::shell
