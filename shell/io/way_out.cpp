#include "shell/io/way_out.h"

#include <cmath>

#include <fmt/format.h>

namespace sunder::shell {
namespace {

constexpr int kWayOutSteps = 50;  // each takes a body out of where it was deepest
constexpr double kSpare = 1.002;  // more than the digits of a printed direction lose

// The next number of three digits that is no smaller, so that what is printed is enough.
double rounded_up(double value) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return std::ceil(value / step * (1.0 - 1e-12)) * step;
}

}  // namespace

Vec3 shortest_way(const std::vector<Vec3>& directions, double least, const DepthAfter& depth_after) {
  Vec3 shortest = Vec3::Zero();
  const double start = depth_after(Vec3::Zero());
  for (const Vec3& direction : directions) {
    double length = 0.0, depth = start;
    for (int k = 0; k < kWayOutSteps && depth > least; ++k) {
      length += depth;
      depth = depth_after(length * direction);
    }
    if (depth <= least && (shortest.isZero(0.0) || length < shortest.norm())) shortest = length * direction;
  }
  return shortest;
}

std::string move_along(const std::string& what, const Vec3& way) {
  if (way.isZero(0.0)) return fmt::format("move {} away", what);
  const Vec3 n = way.normalized() + Vec3::Zero();  // no minus before a zero
  return fmt::format("move {} {:.3g} m along ({:.3g}, {:.3g}, {:.3g})", what, rounded_up(kSpare * way.norm()), n.x(),
                     n.y(), n.z());
}

}  // namespace sunder::shell
