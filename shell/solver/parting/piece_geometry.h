#pragma once
// Geometry of a piece at rest: area, volume, centre and second moments.
#include "shell/fracture/triangulation.h"
#include "shell/solver/model.h"

namespace sunder::shell {

/// Rest geometry of a piece: mid-surface triangles with thickness tau. Where it varies, tau is that of the scene.
struct PieceGeometry {
  double area = 0.0;           // [m^2]
  double volume = 0.0;         // over tau [m^2]
  Vec3 centre = Vec3::Zero();  // [m]
  Mat3 second = Mat3::Zero();  // integral of (x - centre)(x - centre)^T over the volume / tau [m^4]
};

/// Computes the rest geometry of a piece.
PieceGeometry rest_geometry(const ShellModel& model, const Triangulation& t, int piece);

}  // namespace sunder::shell
