#include "shell/io/starts_inside.h"

#include <fmt/format.h>

#include "shell/io/way_out.h"

namespace sunder::shell {
namespace {

constexpr double kStartRoundOff = 1e-9;  // of the distance of the faces from the middle

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
  const auto depth_after = [&](const Vec3& move) {
    Proxy moved = body;
    moved.body.motion.position = body.body.motion.position + move;
    return start_depth(shell, moved).depth;
  };
  return shortest_way({found.normal, -found.normal, -found.outward}, kStartRoundOff * found.face, depth_after);
}

std::string starts_inside(const StartDepth& found, const ShellModel& shell, const Proxy& body) {
  const Vec3 way = way_out(shell, body, found);
  const bool fixed = body.body.is_static;  // a floor stays
  const std::string remedy = move_along(fixed ? "the shell" : "it", fixed ? Vec3(-way) : way);
  return fmt::format("'{}' starts {:.3g} m inside shell '{}', whose faces are {:.3g} m from its middle; {}",
                     body.body.name, found.depth, shell.name, found.face, remedy);
}

}  // namespace sunder::shell
