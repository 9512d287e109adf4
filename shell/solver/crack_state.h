#pragma once
// Cracks of a shell and the Gauss points that they touch: the part of its state that only cracks change.
#include <array>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "shell/fracture/mls.h"
#include "shell/mechanics/point_force.h"
#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

/// A running crack tip.
struct Tip {
  Vec2 p, direction;
  int vertex = 0, edge = -1, crack = 0;
  int sibling = -1;           // number of the crack that is the other arm of the last branch
  int face = 0;               // face in tension, -1 or +1
  double pending = 0.0;       // length that the tip may advance [m]
  double since_branch = 0.0;  // length since the last branch [m]
  double grown = 0.0;         // length since its nucleation [m]
  double strength = 1e300;    // of the flaw at its origin [Pa]; falls until `grown` reaches `flaw`
  double flaw = 0.0;          // half the critical length of that flaw [m]
  double first_turn = 0.0;    // largest turn of its first edge [rad]
  // Sums over the growth of `pending`, weighted by speed: weight, turn [rad], drive.
  double weight = 0.0, turn = 0.0, ratio = 0.0;
  double owed = 0.0;      // what its edges have cost beyond what they released, so far [J]
  double release = -1.0;  // mean of its energy release over the response time [J/m^2]; below 0: not known yet
  int refused = 0;        // edges that it was refused since its last one
  bool alive = true;
  bool seam_decided = false;  // dead, and its propagation over a seam has been decided
};

/// One of the two points at which a pair of faces touches: at the lower and the upper face of the sheet.
struct FacePoint {
  Vec3 rest = Vec3::Zero();  // gap at zero force: across, along, normal [m]; moves as the faces crush and slide
  Vec3 bore = Vec3::Zero();  // traction over the stiffness at the start of the last substep [m]
  double was_open = 0.0;     // opening at the start of the last substep [m]
  double depth = 0.0;        // depth of closing, where above the least depth [m]
};

/// Values and first derivatives of the functions of one side of an edge, as strips of consecutive slots with zeros at
/// slots that it does not use.
struct FaceStrips {
  std::vector<int> slot;  // first slot of each strip
  std::vector<std::array<Pack, 3>> n;
};

/// Contact of the two faces of a fresh crack edge, at its middle (solver/interlock.h).
struct Interlock {
  int edge = 0;
  double area = 0.0;         // [m^2]
  double stiffness = 1e300;  // [Pa/m]; never increases
  std::vector<GatheredFunction> plus, minus;
  // Caches, computed again after a checkpoint: control points visible from each side, and those that its functions use.
  std::array<Visibility, 2> visibility{}, uses{};
  bool looked = false;                 // the caches are valid
  std::array<FaceStrips, 2> strips{};  // of `plus` and `minus`; empty: not packed yet
  std::array<FacePoint, 2> points{};   // at the lower and the upper face
  Vec3 origin = Vec3::Zero();          // gap at the middle of the sheet as the faces were born [m]
  // Area of the tangents' parallelogram of each side at the start of contact.
  std::array<double, 2> rest_area{1.0, 1.0};
  bool holds = true;
  // Results of the last force evaluation: least opening, how far the faces have slid along the edge and along the
  // normal [m], energy [J], and whether the faces still fit.
  double opening = 0.0, along = 0.0, height = 0.0, energy = 0.0;
  bool sound = true;
  double rubbed = 0.0, crushed = 0.0;  // lost to friction and to crushing, not yet booked [J]
};

/// Cracks of a shell: graph, tips, faces in contact, and the force discontinuity that they have caused.
struct Cracks {
  CrackGraph graph{Vec2::Zero(), Vec2::Ones(), 1.0, 0.01};
  std::vector<Tip> tips;
  std::vector<Interlock> interlocks;
  std::vector<int> interlock_of;  // of each crack edge; -1: none
  std::vector<char> cut_done;     // 1 for prescribed cuts that have been made
  double last_crack_time = -1.0;  // [s]
  double interlock_energy = 0.0;  // from the last force evaluation [J]
  // [3][component stride]: internal force before the cracks of this moment minus the force after them [N]; empty: no
  // new cracks.
  std::vector<double> force_discontinuity;
  double released = 0.0;           // stored energy released by them and by released faces, booked already [J]
  double released_by_faces = 0.0;  // the part of it that is booked as friction of faces [J]
  double surplus = 0.0;            // the part of it that tips released beyond what they owe: it stays motion [J]
  double taken = 0.0;              // energy that edges which ran by themselves have taken so far [J]

  /// Calls f with all members that the hash of a run takes.
  template <class Self, class F>
  static void hashed(Self& self, F&& f) {
    f(self.graph);
  }
  /// Calls f with all members that a checkpoint saves.
  template <class F>
  void saved(F&& f) {
    hashed(*this, f);
    f(tips, interlocks, interlock_of, cut_done, last_crack_time, interlock_energy, force_discontinuity, released,
      released_by_faces, surplus, taken);
  }
};

/// Gauss points that a crack has touched or damage may weaken, and the tables of the points that the row kernel sums.
struct CrackedPoints {
  RowTables tables;                          // as the model's, with zero area at gathered points
  RowTables interlayer;                      // as the model's, with zero area at detached points
  std::vector<GatheredPoint> gathered;       // points that are summed one by one
  std::vector<GatheredPoint> of_interlayer;  // the same of an interlayer, beside trims; as the model's until they leave
  std::vector<int> point_of;                 // [block][lane]: index into `gathered`; -1: none
  std::vector<char> kind_of;                 // [block][lane]: PointKind of the gathered point; kQuadratic elsewhere
  std::vector<PointDamage> damage;           // of each gathered point where damage drives cracks; otherwise empty
  std::vector<char> watched;  // [block][lane]: 1 where damage may weaken a point that the rows sum; empty: none
  // [block][lane]: distance of the furthest control point that the functions beside a crack use, as the larger of the
  // two coordinates [spacings]; 0: the functions are those of the patch.
  std::vector<float> reach;

  /// Calls f with all members that a checkpoint saves; `kind_of` is computed from `gathered`. The hash of a run takes
  /// none: where one differs, positions after it do.
  template <class F>
  void saved(F&& f) {
    f(tables.metric, interlayer.metric, of_interlayer, gathered, point_of, damage, watched, reach);
  }
  /// Place of a gathered point, block * lanes + lane.
  std::size_t gauss_of(std::size_t point) const {
    return static_cast<std::size_t>(gathered[point].block) * tables.lanes + gathered[point].lane;
  }
  PointKind kind(std::size_t gauss) const { return static_cast<PointKind>(kind_of[gauss]); }
  void note_kind(const GatheredPoint& g) {
    kind_of[static_cast<std::size_t>(g.block) * tables.lanes + g.lane] = static_cast<char>(g.kind);
  }
};

}  // namespace sunder::shell
