#pragma once
// The cracks of a shell and the Gauss points that they have touched: the part of its state that only cracks change.
#include <array>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "shell/fracture/mls.h"
#include "shell/mechanics/point_force.h"
#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

/// A running end of a crack.
struct Tip {
  Vec2 p, direction;
  int vertex = 0, edge = -1, crack = 0;
  int sibling = -1;           // crack of the other arm of the last branch
  int face = 0;               // tension side, -1 or +1
  double pending = 0.0;       // length that it may advance [m]
  double since_branch = 0.0;  // [m]
  double grown = 0.0;         // since it was born [m]
  double strength = 1e300;    // of the flaw that it was born from [Pa]; falls until `grown` is `flaw`
  double flaw = 0.0;          // half the critical length of that flaw [m]
  double first_turn = 0.0;    // largest turn of its first edge [rad]
  // Sums while `pending` grew, weighted by speed: weight, turn [rad], drive.
  double weight = 0.0, turn = 0.0, ratio = 0.0;
  bool alive = true;
  bool crossed = false;  // dead, and already asked whether it goes on beyond a seam
};

/// The two faces of a fresh crack edge bear on one another at its middle (solver/interlock.h).
struct Interlock {
  int edge = 0;
  double area = 0.0;         // [m^2]
  double stiffness = 1e300;  // [Pa/m]; never rises
  std::vector<GatheredFunction> plus, minus;
  // Caches, found again after a checkpoint: what each side sees, which control points its functions use, and whether
  // the functions reproduce planes only.
  std::array<Sight, 2> sights{}, uses{};
  std::array<bool, 2> planes{};
  bool looked = false;       // the caches are filled
  Vec3 rest = Vec3::Zero();  // gap without force: across, along, normal [m]
  double rest_area = 1.0;    // of the tangents' parallelogram when it was fastened
  bool holds = true;
  // As the last force found them: opening [m], shear traction of springs of full stiffness [Pa], energy [J], and
  // whether the faces still fit.
  double opening = 0.0, shear = 0.0, energy = 0.0;
  bool sound = true;
  double was_open = 0.0;  // opening at the start of the last substep [m]
  double depth = 0.0;     // of closing, where more than the least [m]
};

/// Cracks: their graph, their running ends, their faces, and the force discontinuity that they have left.
struct Cracks {
  CrackGraph graph{Vec2::Zero(), Vec2::Ones(), 1.0, 0.01};
  std::vector<Tip> tips;
  std::vector<Interlock> interlocks;
  std::vector<int> interlock_of;  // of each crack edge, -1: none
  std::vector<char> cut_done;     // prescribed cuts that have been made
  double last_crack_time = -1.0;  // [s]
  double interlock_energy = 0.0;  // as the last force found it [J]
  // [3][component stride], internal force before the cracks of this moment less that after [N]; empty: none.
  std::vector<double> force_discontinuity;
  double released = 0.0;  // stored energy that went with it, booked as fracture [J]

  /// Calls f with all members that a checkpoint keeps.
  template <class F>
  void saved(F&& f) {
    f(graph, tips, interlocks, interlock_of, cut_done, last_crack_time, interlock_energy, force_discontinuity,
      released);
  }
};

/// Gauss points that a crack has touched or that damage may weaken, and what the row kernel still sums.
struct CrackedPoints {
  RowTables tables;                     // as the model's, areas of gathered points taken out
  RowTables interlayer;                 // as the model's, areas of detached points taken out
  std::vector<GatheredPoint> gathered;  // summed point by point
  std::vector<int> point_of;            // [block][lane]: index into `gathered`, -1: none
  std::vector<char> kind_of;  // [block][lane]: PointKind of the entry in `gathered`, kQuadratic where there is none
  std::vector<PointDamage> damage;  // of each gathered point where damage drives the cracks, else empty
  std::vector<char> watched;        // [block][lane]: damage may weaken the point, the rows sum it; empty: none
  // [block][lane]: distance of the furthest control point that the functions beside a crack use, the larger of the two
  // coordinates [spacings]; 0: functions are those of the patch.
  std::vector<float> reach;

  /// Calls f with all members that a checkpoint keeps; `kind_of` follows from `gathered`.
  template <class F>
  void saved(F&& f) {
    f(tables.metric, interlayer.metric, gathered, point_of, damage, watched, reach);
  }
  PointKind kind(std::size_t gauss) const { return static_cast<PointKind>(kind_of[gauss]); }
  void note_kind(const GatheredPoint& g) {
    kind_of[static_cast<std::size_t>(g.block) * tables.lanes + g.lane] = static_cast<char>(g.kind);
  }
};

}  // namespace sunder::shell
