#pragma once
// Shells that are joined along seams: dependent control points, ties along trims, and creases that keep their angle.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "coupler/core/archive.h"
#include "shell/geometry/seams.h"
#include "shell/solver/joining/seam_ties.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// Joins shells along seams. A dependent control point moves with the weighted mean of independent ones. Along trims,
/// impulses keep the ties.
class Stitching {
 public:
  Stitching() = default;
  /// `stitches` refers to the patches of `shells`, in their order. Throws Error where a support holds a seam on one of
  /// its shells only.
  Stitching(const Stitches& stitches, const std::vector<const ShellModel*>& shells);

  bool empty() const { return dependent_points_.empty() && ties_.empty(); }
  /// Moves the masses of dependent control points to the independent ones. Call it once, after make_state.
  void move_masses(const std::vector<ShellRef>& shells);
  /// Moves the force of each dependent control point to its independent ones, so that both accelerate alike, and adds
  /// the forces of ties. Does the same with force discontinuities. Call it after compute_forces of all shells.
  void move_forces(const std::vector<ShellRef>& shells);
  /// Stores velocities without contact impulses. Call it after the kick and before contact.
  void store_velocities(const std::vector<ShellRef>& shells);
  /// Moves impulses on dependent control points to the independent ones, and books the change of the work of contact.
  /// Call it after contact.
  void move_impulses(const std::vector<ShellRef>& shells);
  /// Applies impulses so that creases have their angle and ties are kept after a drift of `dt` [s]. Those of creases
  /// act along lines between the control points that they move (SHAKE), so they conserve momentum and angular momentum
  /// and do no work. Call it after move_impulses and before drift.
  void enforce_crease_constraints(const std::vector<ShellRef>& shells, double dt);

  /// Sets velocities of dependent control points from the independent ones.
  void update_dependent_velocities(const std::vector<ShellRef>& shells) const;
  /// As SeamTies::leave_supports_out().
  void leave_supports_out(const std::vector<char>& free) { ties_.leave_supports_out(free); }
  /// Makes velocities such that ties and dependent control points hold.
  void align_velocities(const std::vector<ShellRef>& shells);
  /// Calls back (shell, slot, shell, slot) for each pair of control points that is still joined.
  template <class F>
  void each_link(F&& callback) const {
    each_dependence(callback);
    ties_.each_link(callback);
  }
  /// The same without ties along trims.
  template <class F>
  void each_dependence(F&& callback) const {
    for (const DependentPoint& t : dependent_points_)
      for (std::size_t k = 0; t.holds && k < t.on.size(); ++k)
        if (std::abs(t.on[k].weight) > kLooseWeight) callback(t.shell, t.slot, t.on[k].shell, t.on[k].slot);
  }
  /// Calls back the control points (WeightedSlot) of each tie that holds.
  template <class F>
  void each_tie(F&& callback) const {
    ties_.each_row(callback);
  }
  /// Calls back (shell, slot, list) for each dependent control point that holds. Entries of the list have `shell`,
  /// `slot`, `weight` and `share`, the part of the dependent mass.
  template <class F>
  void each_dependent(F&& callback) const {
    for (const DependentPoint& t : dependent_points_)
      if (t.holds) callback(t.shell, t.slot, t.on);
  }
  /// Calls back (list, sum at rest [m]) for each tie along a trim that holds. Entries have `shell`, `slot` and
  /// `weight`; the sum of weighted positions stays.
  template <class F>
  void each_tied_sum(F&& callback) const {
    ties_.each_constraint([&](const auto& terms, const Vec3& rest, bool crease) {
      if (!crease) callback(terms, rest);
    });
  }
  /// Calls back (list, length [m]) for each crease that holds: the weighted sum of positions keeps its length.
  template <class F>
  void each_crease(F&& callback) const {
    for (const CreaseConstraint& b : crease_constraints_)
      if (b.holds) callback(b.terms, b.length);
    ties_.each_constraint([&](const auto& terms, const Vec3& rest, bool crease) {
      if (crease) callback(terms, rest.norm());
    });
  }
  /// Releases the control points for which `leaves(shell, slot)` is true, and those that depend on them. Each takes
  /// back its mass with its velocity. This conserves momentum and angular momentum and loses some kinetic energy.
  /// Returns whether any was released.
  template <class F>
  bool release(const std::vector<ShellRef>& shells, F&& leaves) {
    bool any = ties_.release(leaves);
    for (DependentPoint& t : dependent_points_) {
      bool out = leaves(t.shell, t.slot);
      for (const IndependentPoint& m : t.on) out = out || leaves(m.shell, m.slot);
      if (t.holds && out) release_dependent(shells, t), any = true;
    }
    for (CreaseConstraint& b : crease_constraints_) {
      for (const Term& m : b.ends) b.holds = b.holds && !leaves(m.shell, m.slot);
      for (const Term& m : b.terms) b.holds = b.holds && !leaves(m.shell, m.slot);
    }
    return any;
  }

  /// True for a control point that depends on others and has not been released.
  bool is_dependent(int shell, int slot) const {
    return std::any_of(dependent_points_.begin(), dependent_points_.end(),
                       [&](const DependentPoint& t) { return t.holds && t.shell == shell && t.slot == slot; });
  }
  /// Number of crack edges of each shell whose crossing of seams has been decided.
  std::vector<std::int64_t>& edges_seen() { return edges_seen_; }
  /// Releases control points that depend on others beyond a crack. The crack crosses the seam at share `t` of its first
  /// edge.
  void part(const std::vector<ShellRef>& shells, const Seam& seam, double t);
  /// Releases control points that depend on others which a crack hides from the seam. The crack belongs to `shell` and
  /// runs along the seam from share `low` of its first edge to share `high`.
  void release_beside(const std::vector<ShellRef>& shells, const Seam& seam, int shell, double low, double high);
  /// Releases all control points that a seam joins from share `low` of its first edge to share `high`.
  void open(const std::vector<ShellRef>& shells, const Seam& seam, double low, double high);
  /// Makes the ties along trims anew that edges of cracks from first[k] on, by shells, concern, and books the kinetic
  /// energy that is lost.
  void renew_ties(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams, const std::vector<int>& first);
  /// Releases corner points, after the functions above. At a corner of patches, shells stay joined while the seams from
  /// that corner still join them at their nearest control points.
  void release_corners(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams);
  /// True where any control point has been released.
  bool parted() const {
    return ties_.parted() || std::any_of(dependent_points_.begin(), dependent_points_.end(),
                                         [](const DependentPoint& t) { return !t.holds; });
  }

  template <class A>
  friend void archive(A& a, Stitching& s) {
    for (DependentPoint& t : s.dependent_points_) archive_one(a, t.holds);
    for (CreaseConstraint& b : s.crease_constraints_) archive_one(a, b.holds);
    archive_one(a, s.edges_seen_);
    archive(a, s.ties_);
  }

 private:
  static constexpr double kLooseWeight = 1e-9;  // round-off
  struct Term {
    int shell, slot;
    double weight;
  };
  struct IndependentPoint : Term {
    double share = 0.0;          // share of the dependent mass; 0 for a negative weight, or masses could vanish
    Vec3 before = Vec3::Zero();  // velocity without impulses
  };
  /// A dependent control point, and the independent ones with their weights.
  struct DependentPoint {
    int shell, slot;
    std::vector<IndependentPoint> on;
    bool holds = true;
    Vec3 before = Vec3::Zero();  // velocity without impulses
  };
  void share(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&));
  /// A crease constraint: keeps the length of a weighted sum of control points beside the crease. The weights sum to 0;
  /// the length measures the angle.
  struct CreaseConstraint {
    std::vector<Term> ends;   // control points, as the geometry has them
    std::vector<Term> terms;  // the independent control points that move them
    double length = 0.0;      // at rest [m]
    bool holds = true;
  };
  /// The position of a control point relative to a seam, in the two rows next to it. `share` is the nearest place of
  /// the seam, as a share of its first edge; `clear`: the point sees that place; `on_seam`: the point is in the edge
  /// row.
  struct Foot {
    int side = 0;  // 1: first patch, 2: second patch, 0: not in these rows
    bool clear = true, on_seam = false;
    double share = 0.0;
  };
  static Foot place_on_seam(const std::vector<ShellRef>& shells, const Seam& seam, const Term& term, bool look);
  static bool joins_both_sides(const std::vector<ShellRef>& shells, const Seam& seam, const std::vector<Term>& terms);
  static std::vector<Term> terms_of(const DependentPoint& dependent);
  static bool at_corner(const std::vector<ShellRef>& shells, const DependentPoint& dependent);
  static void book_lost(const std::vector<ShellRef>& shells, int shell, double lost);
  template <class F>
  void release_where(const std::vector<ShellRef>& shells, const Seam& seam, F&& across);
  /// Releases a dependent control point. Returns the kinetic energy that is lost [J].
  double release_dependent(const std::vector<ShellRef>& shells, DependentPoint& dependent);
  static double turn(const std::vector<ShellRef>& shells, const DependentPoint& dependent, const Vec3& turning);
  static void refresh(const std::vector<ShellRef>& shells, const DependentPoint& dependent);
  std::vector<WeightedSlot> independent_terms(const std::vector<WeightedSlot>& terms) const;
  void tie_trims(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells);

  std::vector<DependentPoint> dependent_points_;
  std::vector<CreaseConstraint> crease_constraints_;
  SeamTies ties_;  // along trims
  std::vector<std::int64_t> edges_seen_;
};

}  // namespace sunder::shell
