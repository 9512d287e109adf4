#pragma once
// Tie constraints along trimmed seams: linear equations between control points of two shells, and the impulses that
// keep them. None of their control points is eliminated: a dependent one, with no mass of its own, is first replaced by
// its independent ones.
#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "coupler/core/archive.h"
#include "shell/geometry/seams.h"
#include "shell/solver/joining/tie_places.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A control point with a weight.
struct WeightedSlot {
  int shell = 0, slot = 0;
  double weight = 0.0;
};

/// What a row was made of. Without a seam it stays as it is when cracks come.
struct RowOrigin {
  int seam = -1;
  bool slope = false;  // of the differences of slope, not of position
  Hat hat;

  template <class A>
  friend void archive(A& a, RowOrigin& r) {
    archive_all(a, r.seam, r.slope, r.hat);
  }
};

/// The rows of the constraints of one seam. Each is a sum of weighted control points that stays as it is at rest.
struct SeamRows {
  std::vector<std::vector<WeightedSlot>> ties;     // the sum is zero: position, and slope where the seam is smooth
  std::vector<std::vector<WeightedSlot>> creases;  // the length of the sum stays: the angle of a crease
  std::vector<RowOrigin> of_ties, of_creases;      // their `seam` is for the caller to set
};

/// Makes the rows of a trimmed seam. Hat functions along it, an element of the coarser side apart, weigh differences of
/// position and of slope over the places of the seam. Weights of a row sum to 0.
SeamRows seam_rows(const Seam& seam, const std::vector<const ShellModel*>& shells);

/// Keeps ties of all trimmed seams. Impulses along a row move its control points by their weights. They have no sum
/// and, as the tied sum of positions is zero, no moment.
class SeamTies {
 public:
  SeamTies() = default;
  /// `rows` and `creases` (SeamRows) name independent control points only. Throws Error where a support moves one of
  /// them, or ties it to others.
  SeamTies(std::vector<std::vector<WeightedSlot>> rows, std::vector<std::vector<WeightedSlot>> creases,
           const std::vector<const ShellModel*>& shells);
  /// The same with the origins of rows and creases, which let cracks change them. `seams`: to which origins refer.
  SeamTies(SeamRows rows, const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells);

  bool empty() const { return rows_.empty(); }
  /// From now on, what supports of the shells with 1 in `free` hold along some axes counts as free: for a step that is
  /// measured as if it were. An empty list brings all supports back.
  void leave_supports_out(std::vector<char> free);
  /// Adds the forces of ties to `field`, so that tied control points accelerate alike.
  void add_forces(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&));
  /// Takes from the velocities what would part the ties over a drift of `dt` [s]; 0: regardless of positions. What acts
  /// on control points that do not move is passed to supports if `pass`. Returns the kinetic energy that is lost [J].
  double align(const std::vector<ShellRef>& shells, double dt, bool pass);
  /// Changes velocities so that creases have their length after a drift of `dt` [s], by impulses along their sums that
  /// part no tie. All are found together (Newton): creases of one seam share control points. Call it after align.
  void keep_creases(const std::vector<ShellRef>& shells, double dt);
  /// Releases rows with a control point for which `leaves(shell, slot)` is true. Returns whether there was any.
  template <class F>
  bool release(F&& leaves) {
    bool any = false;
    for (Row& row : creases_)
      for (std::size_t k = 0; row.holds && k < row.terms.size(); ++k)
        if (leaves(row.terms[k].shell, row.terms[k].slot)) row.holds = false, any = true;
    for (Row& row : rows_)
      for (std::size_t k = 0; row.holds && k < row.terms.size(); ++k)
        if (leaves(row.terms[k].shell, row.terms[k].slot)) row.holds = false, any = true;
    if (any) solver_.reset();
    return any;
  }
  using Substitute = std::function<std::vector<WeightedSlot>(const std::vector<WeightedSlot>&)>;
  /// Makes rows anew that the cracks' edges from first[k] on, by shells, concern: no row reaches over a crack, and the
  /// functions beside a crack are those that it leaves. A new row holds at the present positions: the least change of
  /// its weights closes the gap that other functions make. `independent` replaces dependent control points. Returns
  /// whether any row has changed; velocities may then not fit.
  bool renew(const std::vector<Seam>& seams, const std::vector<ShellRef>& shells, const std::vector<int>& first,
             const Substitute& independent);
  /// Calls back (shell, slot, shell, slot) for pairs of control points that connect all of each row.
  template <class F>
  void each_link(F&& callback) const {
    for (const Row& row : rows_)
      for (std::size_t k = 1; row.holds && k < row.terms.size(); ++k)
        callback(row.terms[0].shell, row.terms[0].slot, row.terms[k].shell, row.terms[k].slot);
  }
  /// Calls back the control points of each row, with their weights.
  template <class F>
  void each_row(F&& callback) const {
    for (const Row& row : rows_)
      if (row.holds) callback(row.terms);
  }
  /// Calls back each constraint: control points with weights, their sum at rest [m], and whether it is a crease, which
  /// keeps the length of the sum only.
  template <class F>
  void each_constraint(F&& callback) const {
    for (const Row& row : rows_)
      if (row.holds) callback(row.terms, row.rest, false);
    for (const Row& row : creases_)
      if (row.holds) callback(row.terms, row.rest, true);
  }
  bool parted() const {
    return cracked_ || std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return !row.holds; });
  }

  template <class A>
  friend void archive(A& a, SeamTies& s) {
    archive_all(a, s.rows_, s.creases_, s.cracked_);
    for (TiePlaces& places : s.places_) archive_one(a, places);
    s.solver_.reset();
    if constexpr (A::kReading) s.check();
  }

 private:
  struct Row {
    std::vector<WeightedSlot> terms;
    Vec3 rest = Vec3::Zero();  // of the sum, where no change of the weights makes it zero
    bool holds = true;
    RowOrigin origin{};

    template <class A>
    friend void archive(A& a, Row& r) {
      archive_all(a, r.terms, r.rest, r.holds, r.origin);
    }
  };
  struct Solver;
  const Solver& solver(const std::vector<ShellRef>& shells);
  bool free(int shell) const { return !free_.empty() && free_[shell] != 0; }

  static Row row_of(std::vector<WeightedSlot> terms, const std::vector<const ShellModel*>& shells);
  Row renewed(const Seam& seam, const std::vector<ShellRef>& shells, RowOrigin origin,
              const Substitute& independent) const;
  void renew_kind(const Seam& seam, const std::vector<ShellRef>& shells, int number, bool slope,
                  const std::vector<Hat>& hats, const Substitute& independent);
  void check() const;  // throws Error (bad_checkpoint) where rows name control points that are none

  std::vector<Row> rows_, creases_;
  std::vector<TiePlaces> places_;                        // [seam]
  bool cracked_ = false;                                 // cracks have changed rows
  std::vector<std::array<std::vector<char>, 3>> fixed_;  // [shell][axis][slot]: a support holds it along this axis only
  std::vector<char> free_;                               // [shell]: 1 where supports are left out; empty: nowhere
  std::shared_ptr<const Solver> solver_;                 // for the masses of now; made anew where they change
};

}  // namespace sunder::shell
