#pragma once
// A piece of a curved or bent surface: convex parts that are flat, and a drawn mesh with inner vertices.
#include <functional>

#include "shell/fracture/outline.h"
#include "shell/fracture/triangulation.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// [tau]: a piece further off a plane is drawn by the triangles that its mass is summed over, inner vertices and all.
/// So the centre of what is drawn is that of its mass, to a millionth of its size.
constexpr double kDrawnFlat = 1e-3;
/// Convex parts of a curved piece, or four times those of its outline if that is more: with more, flat is taken less
/// strictly.
constexpr std::size_t kMostFlatParts = 1024;
constexpr int kDoublings = 10;  // of the distance between the planes of a flat part

/// The two faces of a shell and its unit normal at one parameter, in the coordinates of a body [m].
struct Faces {
  Vec3 low, high, normal;
  Vec3 middle() const { return 0.5 * (low + high); }
  bool finite() const { return low.allFinite() && high.allFinite(); }
};

/// The surface that a piece lies on.
struct PieceSurface {
  std::function<Faces(const Vec2& parameter)> at;
  /// [of its length in the parameter plane]: longer edges are no surface; infinity where nothing is torn.
  double torn;
};

/// The thickness [m] that tells what is flat on a piece: its least one.
double least_thickness_of(const ShellModel& model, const Triangulation& t, int piece);

/// Tells whether a vertex of a piece is further than `most` [m] off the mean plane of all of them. Where the thickness
/// varies, its half must also be linear to `most`: faces that have a kink or a curve are bent.
bool is_bent(const ShellModel& model, const PieceSurface& surface, const Triangulation& t, int piece, double most);

/// Appends convex parts: those of the outline, halved until each lies between two planes `most` [m] apart, and half of
/// its thickness is linear to `most`. A part no larger than half a spacing is taken as it is, and left out where it is
/// torn or has no volume. Many parts make contact slow: where there are more than kMostFlatParts, the planes are twice
/// as far apart, and so on.
void add_flat_parts(const ShellModel& model, const PieceSurface& surface, const Outline& outline, double most,
                    ConvexShape& shape);

/// Thickens a piece at its rest shape, turned by `to_body` about `centre` [m]. Appends convex parts for collisions to
/// `shape` and a mesh to `drawn`. A curved piece is made of flat parts and drawn with inner vertices.
void thicken(const ShellModel& model, const Triangulation& t, int piece, const Vec3& centre, const Mat3& to_body,
             ConvexShape& shape, DrawnMesh& drawn);
/// Notes places at rest and parameters of points that were drawn last, from their parameters [m] on the patch.
/// Points come in pairs, the lower face first.
void add_rest(const ShellModel& model, const std::vector<Vec2>& parameters, DrawnMesh& drawn);

}  // namespace sunder::shell
