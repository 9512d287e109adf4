#include "shell/solver/parting/remains.h"

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

}  // namespace

Handoff freeze(const ShellModel& m, ShellState& s, const Triangulation& t, const std::vector<Piece>& pieces,
               BodyId id) {
  Handoff out;
  RigidBody& b = out.body;
  b.id = id, b.name = m.name + "_remains", b.is_static = true;
  b.contact_group = m.contact_group;
  ConvexShape shape;
  const PieceSurface present = present_surface(m, s);
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
        add_rest(m, draw_prisms(present, t, p.number, m.largest_thickness(), out.drawn), out.drawn);
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
