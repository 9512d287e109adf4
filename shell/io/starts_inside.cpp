#include "shell/io/starts_inside.h"

#include <cmath>

#include <fmt/format.h>

namespace sunder::shell {
namespace {

constexpr int kWayOutSteps = 50;         // each takes a body out of where it was deepest
constexpr double kSpare = 1.002;         // more than the digits of a printed direction lose
constexpr double kStartRoundOff = 1e-9;  // of the distance of the faces from the middle

// The next number of three digits that is no smaller, so that what is printed is enough.
double rounded_up(double value) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return std::ceil(value / step * (1.0 - 1e-12)) * step;
}

}  // namespace

StartDepth start_depth(const ShellModel& shell, const Proxy& body) {
  StartDepth found{.depth = -1e300};
  for (int block = 0; block < shell.tables.blocks(); ++block)
    for (int e = 0; e < shell.tables.spans_u; ++e) {
      const GaussPoint g = gauss_point(shell.patch, shell.tables, block, e);
      if (!(g.weight > 0.0)) continue;
      const Proxy::Distance distance = body.distance(shell.patch.evaluate(g.parameter).x);
      const double face = 0.5 * shell.thickness_at(block, e);
      if (face - distance.value <= found.depth) continue;
      const SurfacePoint at = shell.patch.evaluate(g.parameter);
      found = {face - distance.value, face, distance.normal, at.u.cross(at.v).normalized()};
    }
  return found;
}

bool starts_outside(const StartDepth& found) { return found.depth <= kStartRoundOff * found.face; }

Vec3 way_out(const ShellModel& shell, const Proxy& body, const StartDepth& found) {
  Vec3 shortest = Vec3::Zero();
  for (const Vec3& direction : {Vec3(found.normal), Vec3(-found.normal), Vec3(-found.outward)}) {
    Proxy moved = body;
    double length = 0.0;
    StartDepth at = found;
    for (int k = 0; k < kWayOutSteps && !starts_outside(at); ++k) {
      length += at.depth;
      moved.body.motion.position = body.body.motion.position + length * direction;
      at = start_depth(shell, moved);
    }
    if (starts_outside(at) && (shortest.isZero(0.0) || length < shortest.norm())) shortest = length * direction;
  }
  return shortest;
}

std::string starts_inside(const StartDepth& found, const ShellModel& shell, const Proxy& body) {
  const Vec3 way = way_out(shell, body, found);
  std::string remedy = "move it away";
  if (!way.isZero(0.0)) {
    const bool fixed = body.body.is_static;  // a floor stays
    const Vec3 n = (fixed ? -1.0 : 1.0) * way.normalized() + Vec3::Zero();
    remedy = fmt::format("move {} {:.3g} m along ({:.3g}, {:.3g}, {:.3g})", fixed ? "the shell" : "it",
                         rounded_up(kSpare * way.norm()), n.x(), n.y(), n.z());
  }
  return fmt::format("'{}' starts {:.3g} m inside shell '{}', whose faces are {:.3g} m from its middle; {}",
                     body.body.name, found.depth, shell.name, found.face, remedy);
}

}  // namespace sunder::shell
