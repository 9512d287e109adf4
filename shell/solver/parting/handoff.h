#pragma once
// Pieces that have come off leave the shell and become rigid bodies.
#include <vector>

#include "coupler/core/body.h"
#include "shell/fracture/outline.h"
#include "shell/solver/parting/pieces.h"

namespace sunder::shell {

/// What is drawn of a body that was a piece: the thickened outline, body coordinates [m].
struct DrawnMesh {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
};

/// Mass, momentum and angular momentum about the origin of all control points, and the sums of the entries'
/// magnitudes that round-off is relative to.
struct Totals {
  double mass = 0.0, momentum_scale = 0.0, angular_scale = 0.0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  Totals& operator+=(const Totals& o) {
    mass += o.mass, momentum_scale += o.momentum_scale, angular_scale += o.angular_scale;
    momentum += o.momentum, angular += o.angular;
    return *this;
  }
};
Totals totals(const ShellModel& model, const ShellState& state);

/// What became of a piece that left.
struct Handoff {
  RigidBody body;
  double area = 0.0;        // [m^2]
  double mass_moved = 0.0;  // [kg] that crossed the crack so that the piece weighs rho tau area
  std::vector<int> donors;  // slots that gave mass and stay
  DrawnMesh drawn;
};

/// Makes a rigid body of a piece at its rest shape, best fitted to its control points: mass rho tau
/// area, linear and angular momentum of its control points exactly. What lumping put on the wrong side
/// of the crack is exchanged with the nearest control points that stay, each with its own momentum.
/// The piece's control points and Gauss points leave the shell; the caller books the energy that is lost.
Handoff hand_off(const ShellModel& model, ShellState& state, const Triangulation& t, const Piece& piece, BodyId id,
                 double dt);

/// Pieces of several shells that leave as one body: masses, momenta and angular momenta are added, where each stands.
Handoff joined(const std::vector<Handoff>& parts);

/// Rotation and translation of rest positions that fit the present ones best (mass-weighted).
void fit_pose(const ShellModel& model, const ShellState& state, const std::vector<int>& slots, Mat3& rotation,
              Vec3& from, Vec3& to);
/// Thickens a piece at its rest shape, turned by `to_body` about `centre`: convex parts to collide and a mesh to draw.
void thicken(const ShellModel& model, const Triangulation& t, int piece, const Vec3& centre, const Mat3& to_body,
             ConvexShape& shape, DrawnMesh& drawn);
/// The piece's points leave: nothing reads or moves them any more.
void remove_piece(const ShellModel& model, ShellState& state, const Piece& piece);

}  // namespace sunder::shell
