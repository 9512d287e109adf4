#pragma once
// Hand-off: detached pieces leave the shell and become rigid bodies.
#include <vector>

#include "coupler/core/body.h"
#include "shell/fracture/outline.h"
#include "shell/solver/parting/pieces.h"

namespace sunder::shell {

/// A straight part of a crack as frames have it.
struct DrawnLine {
  std::array<Vec3, 2> points{};        // [m], of the world, or of the body that carries it
  std::array<Vec3, 2> displacement{};  // [m] from rest
  std::array<Vec3, 2> rest{};          // [m], in the world
  std::array<Vec2, 2> parameter{};     // of the crack's graph
  int crack = -1, shell = -1;          // numbers
  double time = 0.0;                   // [s] at which it was inserted
};

/// The drawn mesh of a body that was a piece, thickened, in body coordinates [m].
struct DrawnMesh {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Vec3> rest{};        // of each point, its place on a face of the shell at rest, in the world [m]
  std::vector<Vec2> uv{};          // and the drawn_parameter() of that place [-]
  std::vector<Vec3> colour{};      // and its drawn_colour(); empty: no part of the piece has one [-]
  std::vector<int> shell{};        // of each triangle, the number of its shell
  std::vector<DrawnLine> lines{};  // cracks of a laminate, whose mesh has no gaps
};

/// Mass, momentum and angular momentum about the origin of all control points, and the sums of the terms' magnitudes,
/// to which round-off is relative.
struct Totals {
  double mass = 0.0, momentum_scale = 0.0, angular_scale = 0.0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  Totals& operator+=(const Totals& o) {
    mass += o.mass, momentum_scale += o.momentum_scale, angular_scale += o.angular_scale;
    momentum += o.momentum, angular += o.angular;
    return *this;
  }
};
/// Computes the totals of one shell.
Totals totals(const ShellModel& model, const ShellState& state);

/// The result of a hand-off.
struct Handoff {
  RigidBody body;
  double area = 0.0;        // [m^2]
  double weighs = 0.0;      // [kg] density times the volume at rest
  double mass_moved = 0.0;  // [kg] moved across the crack so that the piece weighs density times volume
  std::vector<int> donors;  // slots of control points that stay and gave mass
  DrawnMesh drawn;
};

/// Makes a rigid body of a piece. Its shape is that at rest, its pose the best fit to its control points. Its mass is
/// density times volume; its linear and angular momentum are those of its control points exactly. Lumping puts some
/// mass on the wrong side of the crack: it is exchanged with the nearest control points that stay, with its own
/// momentum. The piece is then removed from the shell. `dt` is the substep [s]. The caller books the lost energy.
Handoff hand_off(const ShellModel& model, ShellState& state, const Triangulation& t, const Piece& piece, BodyId id,
                 double dt);

/// Joins pieces of several shells into one body at their present places: adds masses, momenta and angular momenta.
Handoff joined(const std::vector<Handoff>& parts);

/// Finds the rotation and the translation (`from` to `to`, [m]) that best fit rest positions to present ones, weighted
/// by mass.
void fit_pose(const ShellModel& model, const ShellState& state, const std::vector<int>& slots, Mat3& rotation,
              Vec3& from, Vec3& to);
/// Removes a piece: nothing reads or moves its control points and Gauss points any more.
void remove_piece(const ShellModel& model, ShellState& state, const Piece& piece);

}  // namespace sunder::shell
