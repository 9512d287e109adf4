#pragma once
// A piece of a curved or bent surface: convex parts that are flat, and a drawn mesh with inner vertices.
#include <functional>

#include "shell/fracture/outline.h"
#include "shell/fracture/triangulation.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// [tau]: a piece further off a plane is drawn with inner vertices. Less than a pixel where the thickness is ten.
constexpr double kDrawnFlat = 0.05;

/// The two faces of a shell and its unit normal at one parameter, in the coordinates of a body [m].
struct Faces {
  Vec3 low, high, normal;
  bool finite() const { return low.allFinite() && high.allFinite(); }
};

/// The surface that a piece lies on.
struct PieceSurface {
  std::function<Faces(const Vec2& parameter)> at;
  /// [of its length in the parameter plane]: longer edges are no surface; infinity where nothing is torn.
  double torn;
};

/// Tells whether a vertex of a piece is further than `most` [m] off the mean plane of all of them.
bool is_bent(const PieceSurface& surface, const Triangulation& t, int piece, double most);

/// Appends convex parts: those of the outline, halved until each is flat to kBentPiece. A part no larger than half a
/// spacing is taken as it is, and left out where it is torn.
void add_flat_parts(const ShellModel& model, const PieceSurface& surface, const Outline& outline, ConvexShape& shape);

/// Draws a prism for each triangle of a piece. Prisms of one piece share their corners and have no walls between them.
void draw_prisms(const PieceSurface& surface, const Triangulation& t, int piece, double thickness, DrawnMesh& drawn);

}  // namespace sunder::shell
