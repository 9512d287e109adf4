#include "shell/solver/parting/remains.h"

#include <algorithm>

#include "shell/fracture/constants.h"
#include "shell/solver/cracking/crack_sides.h"
#include "shell/solver/parting/bent_piece.h"

namespace sunder::shell {
namespace {

// The surface where it stands, with the functions of the uncut patch.
SurfacePoint surface(const ShellModel& m, const ShellState& s, const Vec2& p) {
  const ShapeFunctions f = m.patch.shape_functions(p);
  SurfacePoint out{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int k = 0; k < f.count(); ++k) {
    const Vec3 x = s.position(f.row(k) * m.tables.stride + f.column(k));
    out.x += f.value[k] * x, out.u += f.u[k] * x, out.v += f.v[k] * x;
  }
  return out;
}

// Where the shell stands now. Control points of rubble fly off: what they span is no surface.
PieceSurface present_surface(const ShellModel& m, const ShellState& s) {
  const auto faces_at = [&m, &s](const Vec2& p) -> Faces {
    const SurfacePoint q = surface(m, s, p);
    const Vec3 n = q.u.cross(q.v).normalized();
    const double half = 0.5 * m.thickness_at(p);
    return {q.x - half * n, q.x + half * n, n};
  };
  return {faces_at, kNoSurface};
}

// Draws a piece where it stands, as frames draw the shell: both sides of an open crack have their own points, and its
// faces stand. Returns the parameter [m] of each pair of new points.
std::vector<Vec2> draw_present(const ShellModel& m, const ShellState& s, const Triangulation& t,
                               const SideCorners& sides, int piece, DrawnMesh& drawn) {
  const std::size_t count = sides.corners.size();
  std::vector<Vec3> x(count), normal(count, Vec3::Zero());
  std::vector<char> known(count, 0), whole(t.triangles.size(), 0);
  for (const int i : t.triangles_of(piece)) {
    const auto& c = sides.of[i];
    for (const int k : c)
      if (known[k] == 0) known[k] = 1, x[k] = side_point(m, s, sides.corners[k].at, sides.corners[k].near).x;
    whole[i] = std::all_of(c.begin(), c.end(), [&](int k) { return x[k].allFinite(); });
    for (int k = 0; k < 3 && whole[i]; ++k) {
      const int a = c[k], b = c[(k + 1) % 3];
      const double at_rest = (sides.corners[a].at - sides.corners[b].at).norm();
      whole[i] = !((x[a] - x[b]).norm() > kNoSurface * at_rest + m.largest_thickness());
    }
    if (!whole[i]) continue;
    const Vec3 twice = (x[c[1]] - x[c[0]]).cross(x[c[2]] - x[c[0]]);
    for (const int k : c) normal[k] += twice;
  }
  std::vector<Vec2> parameters;
  std::vector<int> drawn_as(count, -1);  // the lower face's point in the mesh
  for (const int i : t.triangles_of(piece)) {
    if (!whole[i]) continue;
    for (const int k : sides.of[i]) {
      if (drawn_as[k] >= 0) continue;
      const Vec2& at = sides.corners[k].at;
      const Vec3 half = 0.5 * m.thickness_at(at) * normal[k].stableNormalized();
      drawn_as[k] = static_cast<int>(drawn.points.size());
      drawn.points.push_back(x[k] - half), drawn.points.push_back(x[k] + half);
      parameters.push_back(at);
    }
    const auto low = [&](int k) { return drawn_as[sides.of[i][k]]; };
    drawn.triangles.push_back({low(0) + 1, low(1) + 1, low(2) + 1});
    drawn.triangles.push_back({low(0), low(2), low(1)});
    for (int k = 0; k < 3; ++k) {
      const int other = t.neighbours[i][k], a = low((k + 1) % 3), b = low((k + 2) % 3);
      if (other >= 0 && t.piece[other] == piece && whole[other]) continue;
      drawn.triangles.push_back({a, b, b + 1});
      drawn.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return parameters;
}

}  // namespace

Handoff freeze(const ShellModel& m, ShellState& s, const Triangulation& t, const std::vector<Piece>& pieces,
               BodyId id) {
  Handoff out;
  RigidBody& b = out.body;
  b.id = id, b.name = m.name + "_remains", b.is_static = true;
  b.contact_group = m.contact_group;
  ConvexShape shape;
  const PieceSurface present = present_surface(m, s);
  SideCorners sides;
  for (const Piece& p : pieces)
    if (!p.handed_off && p.held) {
      std::vector<int> slots;
      for (const int i : p.control_points) slots.push_back(m.tables.slot(i));
      for (int i = 0; i < m.control_points() && p.control_points.empty(); ++i)  // a splinter on an interlayer
        if (!s.motion.detached[m.tables.slot(i)]) slots.push_back(m.tables.slot(i));
      out.area += p.area;
      const double most = kBentPiece * least_thickness_of(m, t, p.number);
      if (is_bent(m, present, t, p.number, most)) {
        add_flat_parts(m, present, outline_of(t, p.number), most, shape);
        if (sides.of.empty()) sides = side_corners(m, s, t);
        add_rest(m, draw_present(m, s, t, sides, p.number, out.drawn), out.drawn);
        continue;
      }
      Mat3 rotation;
      Vec3 from, to;
      fit_pose(m, s, slots, rotation, from, to);  // at its present place: a hinged pane may have swung
      thicken(m, t, p.number, from - rotation.transpose() * to, rotation, shape, out.drawn);
    }
  b.shape = std::move(shape);
  for (const Piece& p : pieces)
    if (!p.handed_off) remove_piece(m, s, p);
  return out;
}

}  // namespace sunder::shell
