#include "shell/solver/interlock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sunder::shell {
namespace {

// The gap from the minus to the plus side at the middle of the sheet, in the frame of the deformed surface.
struct Gap {
  Vec3 tu, tv;                 // mean tangents of the two sides
  Vec3 across, along, normal;  // orthonormal; across points from the minus to the plus side
  double c, d;                 // lengths of tu x tv and of the edge's tangent
  // of the plus and the minus side
  Vec3 at[2], side_tu[2], side_tv[2], side[2];  // position, tangents, unit normal
  double side_c[2];                             // length of the cross product of the tangents
  double half = 0.0;                            // of the thickness [m]

  // Height of a point of contact over the middle of the sheet [m].
  double height(int face) const { return (face == 0 ? -1.0 : 1.0) * half; }
  Vec3 at_height(double z) const { return at[0] - at[1] + z * (side[0] - side[1]); }
  Vec3 in_frame(const Vec3& g) const { return {g.dot(across), g.dot(along), g.dot(normal)}; }
};

Vec2 direction(const ShellState& s, const Interlock& lock) {
  const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
  return (e.b - e.a).normalized();
}

// Thickness at an edge [m]: the factor of a shell costs too much to be looked up in every substep, and the area has it.
double thickness_at(const ShellModel& m, const ShellState& s, const Interlock& lock) {
  if (!m.varies()) return m.thickness;
  const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
  return lock.area / (e.b - e.a).norm();
}

// The frame of a gap whose positions and tangents of the sides are known.
void find_frame(const ShellState& s, const Interlock& lock, Gap& r) {
  r.tu = r.tv = Vec3::Zero();
  for (int side = 0; side < 2; ++side) {
    r.tu += 0.5 * r.side_tu[side], r.tv += 0.5 * r.side_tv[side];
    const Vec3 c = r.side_tu[side].cross(r.side_tv[side]);
    r.side_c[side] = c.norm(), r.side[side] = c / r.side_c[side];
  }
  const Vec2 p = direction(s, lock);
  const Vec3 c = r.tu.cross(r.tv), d = p.x() * r.tu + p.y() * r.tv;
  r.c = c.norm(), r.d = d.norm();
  r.normal = c / r.c, r.along = d / r.d, r.across = r.normal.cross(r.along);
}

Gap gap_of(const ShellModel& m, const ShellState& s, const Interlock& lock) {
  Gap r;
  r.half = 0.5 * thickness_at(m, s, lock);
  for (int side = 0; side < 2; ++side) {
    r.at[side] = r.side_tu[side] = r.side_tv[side] = Vec3::Zero();
    for (const auto& f : side == 0 ? lock.plus : lock.minus) {
      const Vec3 x = s.position(f.slot);
      r.at[side] += f.n[0] * x, r.side_tu[side] += f.n[1] * x, r.side_tv[side] += f.n[2] * x;
    }
  }
  find_frame(s, lock, r);
  return r;
}

double sum_of(const Pack& a) {
  double sum = 0.0;
  for (int i = 0; i < kLanes; ++i) sum += a[i];
  return sum;
}

// The same with packed functions. `x`: [3][component stride].
Gap gap_of(const ShellModel& m, const ShellState& s, const Interlock& lock, const double* x) {
  Gap r;
  r.half = 0.5 * thickness_at(m, s, lock);
  const std::size_t stride = m.tables.component_stride;
  for (int side = 0; side < 2; ++side) {
    const FaceStrips& strips = lock.strips[side];
    Pack sum[3][3] = {};
    for (std::size_t i = 0; i < strips.slot.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const Pack at = load<Pack>(x + c * stride + strips.slot[i]);
        for (int k = 0; k < 3; ++k) sum[k][c] += strips.n[i][k] * at;
      }
    for (int c = 0; c < 3; ++c) {
      r.at[side][c] = sum_of(sum[0][c]);
      r.side_tu[side][c] = sum_of(sum[1][c]), r.side_tv[side][c] = sum_of(sum[2][c]);
    }
  }
  find_frame(s, lock, r);
  return r;
}

// Asks for the packed functions before they are used: their memory is scattered, and waiting for it takes longer than
// the sums.
void fetch_ahead(const Interlock& lock) {
  if (!lock.holds) return;
  for (const FaceStrips& strips : lock.strips)
    for (const auto& n : strips.n)
      for (const Pack& k : n) __builtin_prefetch(&k);
}

FaceStrips packed(std::vector<GatheredFunction> functions, int stride) {
  std::sort(functions.begin(), functions.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  FaceStrips r;
  int first = -kLanes;
  for (const GatheredFunction& f : functions) {
    if (f.slot >= first + kLanes) {
      first = std::min(f.slot, stride - kLanes);
      r.slot.push_back(first), r.n.push_back({});
    }
    for (int k = 0; k < 3; ++k) r.n.back()[k][f.slot - first] += f.n[k];
  }
  return r;
}

// Faces that have turned against one another, or whose surroundings are crushed, bear no more.
bool sound(const Interlock& lock, const Gap& gap) {
  const double cosine = gap.side[0].dot(gap.side[1]);
  bool fits = cosine > kFacesCosine;
  for (int side = 0; side < 2; ++side)
    fits = fits && gap.side_c[side] > kFacesLeastArea * lock.rest_area[side] &&
           gap.side_c[side] < kFacesMostArea * lock.rest_area[side];
  return fits;
}

double stiffness(const ShellModel& m) { return m.material.youngs_modulus / m.spacing; }  // of one element [Pa/m]

// Gap at a point of contact: across, along, normal [m].
Vec3 gap_at(const Gap& gap, int face) { return gap.in_frame(gap.at_height(gap.height(face))); }

// The springs of a point of contact, over k A / 2: what they bear across, along and normal [m], and hold [m^2]. Across
// they bear pressure only, and are soft over the depth of closing.
struct Springs {
  Vec3 bear;
  double hold;
};

Springs springs_of(const Vec3& extension, double depth) {
  Springs r{extension, 0.0};
  const double approach = std::max(-r.bear[0], 0.0);
  if (approach < depth) {
    r.bear[0] = -0.5 * approach * approach / depth;
    r.hold = approach * approach * approach / (6.0 * depth);
  } else {
    r.bear[0] = 0.5 * depth - approach;
    r.hold = 0.5 * r.bear[0] * r.bear[0] + depth * depth / 24.0;
  }
  r.hold += 0.5 * (r.bear[1] * r.bear[1] + r.bear[2] * r.bear[2]);
  return r;
}
double depth_of(const ShellModel& m, const FacePoint& point) { return std::max(closing_depth(m), point.depth); }
Springs springs_at(const ShellModel& m, const Vec3& at, const FacePoint& point) {
  return springs_of(at - point.rest, depth_of(m, point));
}

// A point of contact gives way where it bears more than its laws allow: it crushes, then slides. The work of a force
// over a substep is that of the mean of its two ends. So the energy of crushing and friction is this mean times the
// way.
void give_way(const ShellModel& m, const Vec3& at, Interlock& lock, int face) {
  FacePoint& point = lock.points[face];
  const double k = 0.5 * lock.stiffness * lock.area, depth = depth_of(m, point);
  Vec3 e = at - point.rest;
  Springs now = springs_of(e, depth);
  const double most = m.material.crushing_strength / lock.stiffness;  // [m]
  if (-now.bear[0] > most) {
    const double approach = most >= 0.5 * depth ? most + 0.5 * depth : std::sqrt(2.0 * depth * most);
    const double gives = -e[0] - approach;
    point.rest[0] -= gives;
    e[0] = -approach, now = springs_of(e, depth);
    lock.crushed += 0.5 * k * (-point.bore[0] - now.bear[0]) * gives;
  }
  const double shear = std::hypot(e[1], e[2]), bears = m.material.crack_friction * -now.bear[0];
  if (shear > bears) {
    const double stays = bears / shear;
    for (int c = 1; c < 3; ++c) {
      const double slides = (1.0 - stays) * e[c];
      point.rest[c] += slides, e[c] *= stays;
      lock.rubbed += 0.5 * k * (point.bore[c] + e[c]) * slides;
    }
  }
  point.bore = {now.bear[0], e[1], e[2]};
}

// Stiffness of a pair of faces [Pa/m]: that of one element, reduced where so little mass moves with a point of contact
// that the step would not be stable. A point above the middle of the sheet also moves as the normal turns.
double stable_stiffness(const ShellModel& m, const ShellState& s, const Interlock& lock) {
  const double z = 0.5 * thickness_at(m, s, lock);
  double mobility = 0.0;  // of the gap [1/kg]
  for (const auto* side : {&lock.plus, &lock.minus})
    for (const GatheredFunction& f : *side) {
      const double slope = f.n[1] * f.n[1] + f.n[2] * f.n[2];
      mobility += (f.n[0] * f.n[0] + z * z * slope) * s.motion.inverse_mass[f.slot];
    }
  const double most = kMostMobility / (m.material.density * m.spacing * lock.area);
  return stiffness(m) * (mobility > most ? most / mobility : 1.0);
}

// The point just beside the middle of the edge, on the plus side (0) or the minus side (1).
Vec2 face(const ShellModel& m, const ShellState& s, const Interlock& lock, int side) {
  const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
  const Vec2 d = (e.b - e.a).normalized(), normal(-d.y(), d.x());
  return 0.5 * (e.a + e.b) + (side == 0 ? kFaceBeside : -kFaceBeside) * m.spacing * normal;
}

bool attach(const ShellModel& m, const ShellState& s, Interlock& lock) {
  std::vector<GatheredFunction>* sides[2] = {&lock.plus, &lock.minus};
  const ControlGrid grid = control_grid(m);
  for (int side = 0; side < 2; ++side) {
    const Vec2 p = face(m, s, lock, side);
    if (!m.patch.contains(p) || (!m.trim.empty() && !m.trim.loops.contains(p))) return false;
    Visibility& visibility = lock.visibility[side];
    if (!lock.looked)
      visibility =
          first_visibility(m, s.cracks.graph, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
    const Visibility before = visibility;
    visibility.update(grid, s.cracks.graph, static_cast<int>(s.cracks.graph.edges().size()));
    if (lock.looked && visibility.sees_the_same(before)) continue;
    const MlsPoint mls = face_point(grid, visibility);
    if (mls.basis == MlsBasis::kNone) return false;
    sides[side]->clear();
    for (const MlsFunction& f : mls.functions) sides[side]->push_back({m.tables.slot(f.control_point), f.n});
    lock.uses[side] = visibility;
    note_uses(m, *sides[side], lock.uses[side]);
    lock.strips[side] = {};
  }
  lock.looked = true;
  lock.stiffness = std::min(lock.stiffness, stable_stiffness(m, s, lock));
  return true;
}

// Forces on the gap, on the tangents of the plus side, and on those of the minus side.
struct FaceForces {
  bool none = true;
  Vec3 gap = Vec3::Zero();
  std::array<Vec3, 2> u{Vec3::Zero(), Vec3::Zero()}, v{Vec3::Zero(), Vec3::Zero()};
};

// Adds the forces of the springs of one point of contact, times `times`.
void push(const ShellState& s, const Interlock& lock, const Gap& gap, int face, const Springs& springs, double times,
          FaceForces& to) {
  const Vec3& e = springs.bear;
  if (e.isZero(0.0)) return;
  to.none = false;
  const double z = gap.height(face), k = 0.5 * times * lock.stiffness * lock.area;
  const Vec3 g = gap.at_height(z);
  // dE = k (e . (dg in the frame) + g . (turn of the frame)); across = normal x along, so
  // g . d across = d normal . (along x g) + d along . (g x normal)
  const Vec3 on_gap = k * (e[0] * gap.across + e[1] * gap.along + e[2] * gap.normal);
  const Vec3 on_normal = k * (e[2] * g + e[0] * gap.along.cross(g));
  const Vec3 on_along = k * (e[1] * g + e[0] * g.cross(gap.normal));
  const Vec3 a = (on_normal - gap.normal * gap.normal.dot(on_normal)) / gap.c;
  const Vec3 b = (on_along - gap.along * gap.along.dot(on_along)) / gap.d;
  const Vec2 p = direction(s, lock);
  const Vec3 u = 0.5 * (gap.tv.cross(a) + p.x() * b), v = 0.5 * (a.cross(gap.tu) + p.y() * b);
  to.gap -= on_gap;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1.0 : -1.0;
    // the side's own normal: d n = (1 - n n) (d tu x tv + tu x d tv) / |tu x tv|
    const Vec3& n = gap.side[side];
    const Vec3 c = sign * z * (on_gap - n * n.dot(on_gap)) / gap.side_c[side];
    to.u[side] -= u + gap.side_tv[side].cross(c), to.v[side] -= v + c.cross(gap.side_tu[side]);
  }
}

// Forces on control points. `add`: adds to the force on a slot.
template <class Add>
void spread(const Interlock& lock, const FaceForces& on, Add&& add) {
  if (on.none) return;
  for (int side = 0; side < 2; ++side)
    for (const auto& f : side == 0 ? lock.plus : lock.minus)
      add(f.slot, Vec3((side == 0 ? f.n[0] : -f.n[0]) * on.gap + f.n[1] * on.u[side] + f.n[2] * on.v[side]));
}

// The same with packed functions, to `force` [3][component stride].
void spread(const Interlock& lock, const FaceForces& on, std::size_t stride, double* force) {
  if (on.none) return;
  for (int side = 0; side < 2; ++side) {
    const FaceStrips& strips = lock.strips[side];
    const Vec3 gap = side == 0 ? on.gap : Vec3(-on.gap);
    for (std::size_t i = 0; i < strips.slot.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        double* to = force + c * stride + strips.slot[i];
        const auto& n = strips.n[i];
        store<Pack>(to, load<Pack>(to) + n[0] * gap[c] + n[1] * on.u[side][c] + n[2] * on.v[side][c]);
      }
  }
}

// Energy of both points of contact [J].
double energy_of(const ShellModel& m, const Gap& gap, const Interlock& lock) {
  double held = 0.0;
  for (int face = 0; face < 2; ++face) held += springs_at(m, gap_at(gap, face), lock.points[face]).hold;
  return 0.5 * lock.stiffness * lock.area * held;
}

}  // namespace

double closing_depth(const ShellModel& m) {
  const double strength = m.material.strength;
  const double share = strength > 0.0 ? kClosingDepth * strength / m.material.youngs_modulus : kMostClosing;
  return std::min(share, kMostClosing) * m.spacing;
}

namespace {

// The gap across at a point of contact in the shell at rest [m]. A crack from damage is born open, by what the damaged
// band has been stretched.
double closed(const ShellModel& m, const ShellState& s, Interlock& lock, int face) {
  for (int side = 0; side < 2; ++side)
    lock.strips[side] = packed(side == 0 ? lock.plus : lock.minus, m.tables.component_stride);
  return gap_at(gap_of(m, s, lock, m.rest.data()), face)[0];
}

}  // namespace

bool fasten(const ShellModel& m, const ShellState& s, Interlock& lock) {
  if (!attach(m, s, lock)) return false;
  const Gap gap = gap_of(m, s, lock);
  lock.rest_area = {gap.side_c[0], gap.side_c[1]};
  lock.origin = gap.in_frame(gap.at_height(0.0));
  bool finite = lock.origin.allFinite();
  for (int face = 0; face < 2; ++face) {  // one-sided shape functions do not meet to round-off
    lock.points[face].rest = gap_at(gap, face);
    if (s.weakens()) lock.points[face].rest[0] = std::min(lock.points[face].rest[0], closed(m, s, lock, face));
    finite = finite && lock.points[face].rest.allFinite();
  }
  return finite;
}

bool loses_visibility(const ShellModel& m, const ShellState& s, Interlock& lock, int first) {
  const ControlGrid grid = control_grid(m);
  const int end = static_cast<int>(s.cracks.graph.edges().size());
  if (!lock.looked)  // first look since a checkpoint
    for (int side = 0; side < 2; ++side) {
      const Vec2 p = face(m, s, lock, side);
      lock.uses[side] = {grid, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y())};
      note_uses(m, side == 0 ? lock.plus : lock.minus, lock.uses[side]);
    }
  for (int k = first; k < end; ++k)
    for (const Visibility& uses : lock.uses)
      if (uses.loses(grid, s.cracks.graph.edges()[k])) return true;
  return false;
}

Refastened refasten(const ShellModel& m, const ShellState& s, Interlock& lock) {
  Refastened r;
  const auto bear = [&](const Gap& gap, double times) {
    FaceForces on;
    for (int face = 0; face < 2; ++face)
      push(s, lock, gap, face, springs_at(m, gap_at(gap, face), lock.points[face]), times, on);
    spread(lock, on, [&](int slot, const Vec3& force) { r.force_change.push_back({slot, force}); });
  };
  const Gap before = gap_of(m, s, lock);
  const double held = energy_of(m, before, lock);
  bear(before, 1.0);
  lock.holds = attach(m, s, lock);
  if (lock.holds) {
    const Gap after = gap_of(m, s, lock);
    const auto moved = [&](double z) {
      return Vec3(after.in_frame(after.at_height(z)) - before.in_frame(before.at_height(z)));
    };
    lock.origin += moved(0.0), lock.holds = lock.origin.allFinite();
    for (int face = 0; face < 2; ++face) {
      lock.points[face].rest += moved(before.height(face));
      lock.holds = lock.holds && lock.points[face].rest.allFinite();
    }
    if (lock.holds) bear(after, -1.0);
    r.released = held - (lock.holds ? energy_of(m, after, lock) : 0.0);
  } else {
    r.released = held;
  }
  return r;
}

void interlock_forces(const ShellModel& m, ShellState& s, bool advance, int chunk, int chunks, const double* x,
                      double* force) {
  const std::size_t stride = m.tables.component_stride;
  const std::size_t end = s.cracks.interlocks.size() * (chunk + 1) / chunks;
  for (std::size_t i = s.cracks.interlocks.size() * chunk / chunks; i < end; ++i) {
    Interlock& lock = s.cracks.interlocks[i];
    if (!lock.holds) continue;
    if (i + 1 < end) fetch_ahead(s.cracks.interlocks[i + 1]);
    for (int side = 0; side < 2; ++side)
      if (lock.strips[side].slot.empty())
        lock.strips[side] = packed(side == 0 ? lock.plus : lock.minus, static_cast<int>(stride));
    const Gap gap = gap_of(m, s, lock, x);
    lock.sound = sound(lock, gap);
    lock.energy = 0.0;
    if (!(std::min(gap.side_c[0] / lock.rest_area[0], gap.side_c[1] / lock.rest_area[1]) > kNoFrame)) continue;
    const Vec3 offset = gap.in_frame(gap.at_height(0.0)) - lock.origin;
    lock.along = std::abs(offset[1]), lock.height = std::abs(offset[2]);
    double opening = 1e300, held = 0.0;
    FaceForces on;
    for (int face = 0; face < 2; ++face) {
      FacePoint& point = lock.points[face];
      const Vec3 at = gap_at(gap, face);
      const double open = at[0] - point.rest[0];
      opening = std::min(opening, open);
      if (advance) {
        if (open > 0.0) point.depth = kClosingTravels * std::abs(open - point.was_open);
        give_way(m, at, lock, face);
        point.was_open = at[0] - point.rest[0];
      }
      const Springs springs = springs_at(m, at, point);
      held += springs.hold;
      push(s, lock, gap, face, springs, 1.0, on);
    }
    spread(lock, on, stride, force);
    lock.opening = opening;
    lock.energy = 0.5 * lock.stiffness * lock.area * held;
  }
}

double interlock_energy(const ShellState& s) {
  double energy = 0.0;
  for (const Interlock& lock : s.cracks.interlocks)
    if (lock.holds) energy += lock.energy;
  return energy;
}

void book_faces(ShellState& s) {
  for (Interlock& lock : s.cracks.interlocks) {
    s.book.face_friction += std::exchange(lock.rubbed, 0.0);
    s.book.face_crushing += std::exchange(lock.crushed, 0.0);
  }
}

void release_interlocks(const ShellModel& m, ShellState& s, const InterlockLaw& law, bool all) {
  for (Interlock& lock : s.cracks.interlocks) {
    if (!lock.holds) continue;
    const double thickness = thickness_at(m, s, lock), length = lock.area / thickness;
    const double apart = law.opening + law.of_thickness * thickness;
    if (!all && lock.sound && lock.opening <= apart && lock.height <= thickness && lock.along <= length) continue;
    lock.holds = false;
    const Gap gap = gap_of(m, s, lock);
    const double held = energy_of(m, gap, lock);
    s.release_by_faces(held);
    std::vector<double>& force = s.discontinuity();
    const std::size_t stride = force.size() / 3;
    FaceForces on;
    for (int face = 0; face < 2; ++face)
      push(s, lock, gap, face, springs_at(m, gap_at(gap, face), lock.points[face]), 1.0, on);
    spread(lock, on, [&](int slot, const Vec3& by_face) {
      for (int d = 0; d < 3; ++d) force[d * stride + slot] += by_face[d];
    });
    s.motion.last_force.clear();
  }
}

}  // namespace sunder::shell
