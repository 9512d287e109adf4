#include "shell/solver/cracking/crack_cost.h"

#include <algorithm>

#include "shell/fracture/constants.h"

namespace sunder::shell {
namespace {

// Returns the length [m] of the part of ab inside the patch. Cracks that leave the shell end a little beyond its
// border.
double length_within(const Patch& patch, const Vec2& a, const Vec2& b) {
  double from = 0.0, to = 1.0;
  const KnotVector* knots[] = {&patch.knots_u, &patch.knots_v};
  for (int d = 0; d < 2; ++d) {
    const double way = b[d] - a[d];
    if (way == 0.0) continue;  // parallel to this border: inside, as its ends are
    const double begin = (knots[d]->begin() - a[d]) / way, end = (knots[d]->end() - a[d]) / way;
    from = std::max(from, std::min(begin, end)), to = std::min(to, std::max(begin, end));
  }
  return std::max(0.0, to - from) * (b - a).norm();
}

}  // namespace

double fracture_energy_at(const ShellModel& m, const Vec2& p) {
  const int block = m.patch.knots_v.span_of(p.y()) * m.tables.gauss * m.tables.gauss;
  const double factor = m.strength_factor_at(block, m.patch.knots_u.span_of(p.x()));
  return m.material.fracture_energy * factor * factor;
}

double edge_cost(const ShellModel& m, const CrackEdge& e) {
  const Vec2 middle = 0.5 * (e.a + e.b);
  return fracture_energy_at(m, middle) * (m.thickness_at(middle) - m.material.interlayer.thickness) * e.resistance *
         length_within(m.patch, e.a, e.b);
}

double mirror_length(const ShellMaterial& q, double drive) {
  if (!(q.strength > 0.0)) return 0.0;
  const double intensity = kMirrorIntensity * q.strength;  // over the root of the length
  return drive * q.youngs_modulus * q.fracture_energy / (intensity * intensity);
}

}  // namespace sunder::shell
