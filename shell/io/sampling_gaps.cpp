#include "shell/io/sampling_gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "shell/geometry/quadrature.h"

namespace sunder::shell {
namespace {

constexpr double kBluntSides = 2.0;  // half sides over the distance from samples, above which an edge is not told

struct Late {
  double depth;  // [m]
  bool told;
};

Late late(const RigidBody& body, const ShellModel& shell) {
  const double d = farthest_from_samples(shell);
  if (const auto* ball = std::get_if<SphereShape>(&body.shape)) {
    const double r = ball->radius;
    const double depth = r > d ? r - std::sqrt(r * r - d * d) : r;
    return {depth, depth > 0.5 * shell.least_thickness()};
  }
  return {d, d > shell.least_thickness() && half_sides(body)[0] < kBluntSides * d};
}

}  // namespace

Vec3 half_sides(const RigidBody& body) {
  Vec3 half = Vec3::Constant(std::numeric_limits<double>::infinity());
  if (const auto* ball = std::get_if<SphereShape>(&body.shape)) half = Vec3::Constant(ball->radius);
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) half = box->half_size;
  if (const auto* parts = std::get_if<ConvexShape>(&body.shape)) {
    Eigen::AlignedBox3d around;
    for (const auto& part : parts->parts)
      for (const Vec3& corner : part) around.extend(corner);
    if (parts->parts.empty() && parts->surface)  // of a body that changes its shape
      for (const Vec3& corner : parts->surface->corners) around.extend(corner);
    half = 0.5 * around.sizes();
  }
  std::sort(half.begin(), half.end());
  return half;
}

double farthest_from_samples(const ShellModel& shell) {
  const std::vector<double>& at = gauss_rule(shell.tables.gauss).point;  // on [-1, 1]
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  double gap = 2.0 + *low - *high;  // from the last point of an element to the first of the next
  std::vector<double> sorted = at;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t k = 1; k < sorted.size(); ++k) gap = std::max(gap, sorted[k] - sorted[k - 1]);
  return 0.5 * gap * 0.5 * shell.longest_element * std::numbers::sqrt2;  // half of the diagonal of four points
}

std::string sampling_gap_warning(const std::vector<ShellSetup>& shells, const std::vector<RigidBody>& bodies) {
  Late worst{0.0, false};
  double worst_share = 0.0;  // depth over the body's shortest half side
  const RigidBody* which = nullptr;
  const ShellModel* where = nullptr;
  std::set<std::string> told;
  for (const ShellSetup& shell : shells)
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (i < shell.hertz.size() && shell.hertz[i] > 0.0) continue;
      const Late found = late(bodies[i], shell.model);
      const double share = found.depth / half_sides(bodies[i])[0];
      if (!found.told) continue;
      told.insert(bodies[i].name);
      if (share > worst_share) worst = found, worst_share = share, which = &bodies[i], where = &shell.model;
    }
  if (which == nullptr) return "";
  return fmt::format(
      "{} '{}' may sink {:.2g} m into shell '{}' before it is felt{}: contact is felt at Gauss points, from which a "
      "point of the shell is up to {:.2g} m away; take more elements, or a larger body",
      std::holds_alternative<SphereShape>(which->shape) ? "ball" : "an edge of", which->name, worst.depth, where->name,
      told.size() > 1 ? fmt::format(", and so may {} other bodies", told.size() - 1) : "",
      farthest_from_samples(*where));
}

}  // namespace sunder::shell
