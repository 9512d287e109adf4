#include "shell/solver/interlock.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

// The gap from the minus to the plus side in the frame of the deformed surface.
struct Gap {
  Vec3 g;                      // plus - minus
  Vec3 tu, tv;                 // mean tangents of the two sides
  Vec3 across, along, normal;  // orthonormal; across points from the minus to the plus side
  Vec3 side[2];                // normals of the plus and the minus side
  double c, d;                 // lengths of tu x tv and of the edge's tangent
  Vec3 components() const { return {g.dot(across), g.dot(along), g.dot(normal)}; }
};

Vec2 direction(const ShellState& s, const Interlock& lock) {
  const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
  return (e.b - e.a).normalized();
}

// `position`: position of a slot.
template <class At>
Gap gap_of(const ShellState& s, const Interlock& lock, At&& position) {
  Gap r;
  r.g = r.tu = r.tv = Vec3::Zero();
  for (int side = 0; side < 2; ++side) {
    Vec3 at = Vec3::Zero(), tu = Vec3::Zero(), tv = Vec3::Zero();
    for (const auto& f : side == 0 ? lock.plus : lock.minus) {
      const Vec3 x = position(f.slot);
      at += f.n[0] * x, tu += f.n[1] * x, tv += f.n[2] * x;
    }
    r.g += side == 0 ? at : Vec3(-at);
    r.tu += 0.5 * tu, r.tv += 0.5 * tv;
    r.side[side] = tu.cross(tv).normalized();
  }
  const Vec2 p = direction(s, lock);
  const Vec3 c = r.tu.cross(r.tv), d = p.x() * r.tu + p.y() * r.tv;
  r.c = c.norm(), r.d = d.norm();
  r.normal = c / r.c, r.along = d / r.d, r.across = r.normal.cross(r.along);
  return r;
}
Gap gap_of(const ShellState& s, const Interlock& lock) {
  return gap_of(s, lock, [&](int slot) { return s.position(slot); });
}

// Faces that have turned against one another, or whose surroundings are crushed, bear no more.
bool sound(const Interlock& lock, const Gap& gap) {
  const double cosine = gap.side[0].dot(gap.side[1]);
  return cosine > kFacesCosine && gap.c > kFacesLeastArea * lock.rest_area && gap.c < kFacesMostArea * lock.rest_area;
}

double stiffness(const ShellModel& m) { return m.material.youngs_modulus / m.spacing; }  // of one element [Pa/m]

// The springs of an edge, over k A: what they bear across, along and normal [m], and hold [m^2]. Across they bear
// pressure only, and are soft over the depth of closing.
struct Springs {
  Vec3 bear;
  double hold;
};

Springs springs_of(const ShellModel& m, const Gap& gap, const Interlock& lock) {
  Springs r{gap.components() - lock.rest, 0.0};
  const double approach = std::max(-r.bear[0], 0.0), depth = std::max(closing_depth(m), lock.depth);
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

// Stiffness of faces one of which is a plane through the few control points between close cracks [Pa/m]: reduced where
// these have so little mass at fastening that the step would not be stable.
double stiffness_beside_plane(const ShellModel& m, const ShellState& s, const Interlock& lock) {
  double mobility = 0.0;  // of the gap [1/kg]
  for (const auto* side : {&lock.plus, &lock.minus})
    for (const GatheredFunction& f : *side) mobility += f.n[0] * f.n[0] * s.motion.inverse_mass[f.slot];
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
    if (!m.patch.contains(p)) return false;
    Visibility& visibility = lock.visibility[side];
    if (!lock.looked) visibility = {grid, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y())};
    const Visibility before = visibility;
    visibility.update(grid, s.cracks.graph, static_cast<int>(s.cracks.graph.edges().size()));
    if (lock.looked && visibility.sees_the_same(before)) continue;
    const MlsPoint mls = face_point(grid, visibility);
    if (mls.basis == MlsBasis::kNone) return false;
    lock.planes[side] = mls.basis == MlsBasis::kLinear;
    sides[side]->clear();
    for (const MlsFunction& f : mls.functions) sides[side]->push_back({m.tables.slot(f.control_point), f.n});
    lock.uses[side] = visibility;
    note_uses(m, *sides[side], lock.uses[side]);
  }
  lock.looked = true;
  const bool plane = lock.planes[0] || lock.planes[1];
  lock.stiffness = std::min(lock.stiffness, plane ? stiffness_beside_plane(m, s, lock) : stiffness(m));
  return true;
}

// Forces of the springs on both sides: on their values, and on their derivatives along u and v [N, N m].
struct Push {
  Vec3 value, u, v;
};

Push push_of(const ShellState& s, const Interlock& lock, const Gap& gap, const Springs& springs, double times) {
  const Vec3& e = springs.bear;
  const double k = times * lock.stiffness * lock.area;
  // dE = k (e . (dg in the frame) + g . (turn of the frame)); across = normal x along, so
  // g . d across = d normal . (along x g) + d along . (g x normal)
  const Vec3 on_gap = k * (e[0] * gap.across + e[1] * gap.along + e[2] * gap.normal);
  const Vec3 on_normal = k * (e[2] * gap.g + e[0] * gap.along.cross(gap.g));
  const Vec3 on_along = k * (e[1] * gap.g + e[0] * gap.g.cross(gap.normal));
  const Vec3 a = (on_normal - gap.normal * gap.normal.dot(on_normal)) / gap.c;
  const Vec3 b = (on_along - gap.along * gap.along.dot(on_along)) / gap.d;
  const Vec2 p = direction(s, lock);
  return {on_gap, 0.5 * (gap.tv.cross(a) + p.x() * b), 0.5 * (a.cross(gap.tu) + p.y() * b)};
}

// `add`: adds to the force on a slot.
template <class Add>
void spread(const Interlock& lock, const Push& push, Add&& add) {
  for (int side = 0; side < 2; ++side)
    for (const auto& f : side == 0 ? lock.plus : lock.minus)
      add(f.slot, Vec3(-((side == 0 ? f.n[0] : -f.n[0]) * push.value + f.n[1] * push.u + f.n[2] * push.v)));
}

void add_force(const ShellState& s, const Interlock& lock, const Gap& gap, const Springs& springs, double times,
               std::vector<double>& force) {
  if (springs.bear.isZero(0.0)) return;
  const std::size_t plane = force.size() / 3;
  spread(lock, push_of(s, lock, gap, springs, times), [&](int slot, const Vec3& on) {
    for (int d = 0; d < 3; ++d) force[d * plane + slot] += on[d];
  });
}

}  // namespace

double closing_depth(const ShellModel& m) {
  return std::min(kClosingDepth * m.material.strength / m.material.youngs_modulus, kMostClosing) * m.spacing;
}

bool fasten(const ShellModel& m, const ShellState& s, Interlock& lock) {
  if (!attach(m, s, lock)) return false;
  const Gap gap = gap_of(s, lock);
  lock.rest_area = gap.c;
  lock.rest = gap.components();  // one-sided shape functions do not meet to round-off
  return lock.rest.allFinite();
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
  const auto bear = [&](const Gap& gap, const Springs& springs, double times) {
    if (!springs.bear.isZero(0.0))
      spread(lock, push_of(s, lock, gap, springs, times), [&](int slot, const Vec3& on) {
        r.force_change.push_back({slot, on});
      });
  };
  const Gap gap = gap_of(s, lock);
  const Vec3 before = gap.components() - lock.rest;
  const Springs springs = springs_of(m, gap, lock);
  const double held = lock.area * springs.hold, stiff = lock.stiffness;
  bear(gap, springs, 1.0);
  lock.holds = attach(m, s, lock);
  if (lock.holds) lock.rest = gap_of(s, lock).components() - before;
  lock.holds = lock.holds && lock.rest.allFinite();
  if (lock.holds) bear(gap_of(s, lock), springs, -1.0);
  r.released = held * (stiff - (lock.holds ? lock.stiffness : 0.0));
  return r;
}

void interlock_forces(const ShellModel& m, ShellState& s, bool advance, int chunk, int chunks, const double* x4,
                      double* force4) {
  const auto position = [&](int slot) { return Vec3(Eigen::Map<const Vec3>(x4 + kPointLanes * slot)); };
  const auto add = [&](int slot, const Vec3& on) { Eigen::Map<Vec3>(force4 + kPointLanes * slot) += on; };
  const std::size_t end = s.cracks.interlocks.size() * (chunk + 1) / chunks;
  for (std::size_t i = s.cracks.interlocks.size() * chunk / chunks; i < end; ++i) {
    Interlock& lock = s.cracks.interlocks[i];
    if (!lock.holds) continue;
    const Gap gap = gap_of(s, lock, position);
    lock.opening = gap.components()[0] - lock.rest[0];
    if (advance) {
      if (lock.opening > 0.0) lock.depth = kClosingTravels * std::abs(lock.opening - lock.was_open);
      lock.was_open = lock.opening;
    }
    const Springs springs = springs_of(m, gap, lock);
    // at full stiffness: a softer spring slips no further
    lock.shear = stiffness(m) * std::hypot(springs.bear[1], springs.bear[2]);
    lock.sound = sound(lock, gap);
    lock.energy = lock.stiffness * lock.area * springs.hold;
    if (!springs.bear.isZero(0.0)) spread(lock, push_of(s, lock, gap, springs, 1.0), add);
  }
}

double interlock_energy(const ShellState& s) {
  double energy = 0.0;
  for (const Interlock& lock : s.cracks.interlocks)
    if (lock.holds) energy += lock.energy;
  return energy;
}

void release_interlocks(const ShellModel& m, ShellState& s, const InterlockLaw& law, bool all) {
  for (Interlock& lock : s.cracks.interlocks) {
    if (!lock.holds) continue;
    if (!all && lock.sound && lock.opening <= law.opening && lock.shear <= law.shear_strength) continue;
    lock.holds = false;
    const Gap gap = gap_of(s, lock);
    const Springs springs = springs_of(m, gap, lock);
    s.release(lock.stiffness * lock.area * springs.hold);
    add_force(s, lock, gap, springs, 1.0, s.discontinuity());
    s.motion.last_force.clear();
  }
}

}  // namespace sunder::shell
