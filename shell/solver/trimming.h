#pragma once
// Trimmed shells: which control points and Gauss points exist, and the functions beside a trim loop.
#include <utility>
#include <vector>

#include "shell/geometry/trim_loops.h"
#include "shell/mechanics/gathered_point.h"
#include "shell/solver/loads.h"
#include "shell/solver/supports.h"

namespace sunder::shell {

struct Seam;
struct ShellModel;
struct ShellState;

/// A control point of which loops leave next to nothing. It has no mass and is no unknown: it lies where a polynomial
/// through those that stay continues.
struct DroppedPoint {
  int slot = 0;
  std::vector<std::pair<int, double>> on;  // slots of control points that stay; their shares sum to 1
};

/// What loops leave of a shell. Empty: the patch is whole.
struct Trimming {
  TrimLoops loops;
  std::vector<DroppedPoint> dropped;
  std::vector<int> dropped_of;  // [slot]: index into `dropped`; -1: none
  // [control point]: 1 where functions beside a crack leave it out: it is dropped, outside, or light.
  std::vector<char> absent;
  // Place of each control point inside the loops, or just inside for one that stays outside. The piece there owns it.
  std::vector<Vec2> home;
  std::vector<int> outside;             // control points that stay outside of the loops
  std::vector<GatheredPoint> points;    // Gauss points in cut elements, and those that a dropped control point moves
  std::vector<int> point_of;            // [block][lane]: index into `points`; -1: none
  std::vector<std::vector<Vec2>> tied;  // stretches of the loops at which ties hold another shell
  int reach = 0;                        // most columns or rows between two control points of one Gauss point

  bool empty() const { return loops.empty(); }
  bool drops(int slot) const { return !dropped_of.empty() && dropped_of[slot] >= 0; }
};

/// Trims a shell, whose tables are those of the loops: drops control points, moves their masses to others, and finds
/// the functions of Gauss points beside loops. Supports and loads lose what is outside. Throws Error where the
/// loops leave no Gauss point, where a part is too narrow for the control points in it, and where a load lies outside.
void trim_shell(ShellModel& model, const TrimLoops& loops);

/// Notes where seams tie trimmed shells to others in position and angle, once all are known. `models` are the patches
/// of the seams.
void note_ties(const std::vector<Seam>& seams, const std::vector<ShellModel*>& models);

/// Takes dropped control points out of supports. Throws Error where a part of a support holds none of those that stay.
void trim_supports(const Trimming& trim, Constraints& constraints);

/// Replaces dropped control points among `functions` by those that stay. The nearest to `p` comes first.
void without_dropped(const ShellModel& model, const Vec2& p, std::vector<GatheredFunction>& functions);

/// All functions of the uncracked shell at a parameter point inside the loops.
std::vector<GatheredFunction> shell_functions(const ShellModel& model, const Vec2& p);
/// The same at a Gauss point.
void shell_functions(const ShellModel& model, int block, int lane, std::vector<GatheredFunction>& out);

/// Begins the state of a trimmed shell: dropped control points are detached, Gauss points beside loops are gathered,
/// and loops are the first edges of the crack graph.
void trim_state(const ShellModel& model, ShellState& state);

/// Whether no crack has changed a shell: only trims have.
bool is_uncracked(const ShellModel& model, const ShellState& state);

/// Sets `field`, [3][component stride], at dropped control points, which depend on those that stay. Readers of the
/// patch's own functions then see the surface go on a little beyond the loops.
void update_dropped_points(const Trimming& trimming, std::vector<double>& field);

}  // namespace sunder::shell
