#include "shell/io/ring_sectors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/geometry/builders.h"

namespace sunder::shell {
namespace {

constexpr double kWidestSector = 90.0;  // [deg]
constexpr double kWhole = 1e-9;         // of an element: round-off

// Edges of the patch of sector k that an edge of the shell means.
std::vector<proto::Support::Edge> edges_of_sector(const proto::Shell& shell, int k, int edge) {
  const bool ends = !scene::is_closed(shell), first = ends && k == 0, last = ends && k + 1 == ring_sectors(shell);
  const bool all = edge == proto::Support::ALL;
  std::vector<proto::Support::Edge> out;
  if (all || edge == proto::Support::OUTER || edge == proto::Support::V_MIN) out.push_back(proto::Support::V_MIN);
  if (all || edge == proto::Support::INNER || edge == proto::Support::V_MAX) out.push_back(proto::Support::V_MAX);
  if (first && (all || edge == proto::Support::U_MIN)) out.push_back(proto::Support::U_MIN);
  if (last && (all || edge == proto::Support::U_MAX)) out.push_back(proto::Support::U_MAX);
  return out;
}

}  // namespace

int ring_sectors(const proto::Shell& shell) {
  return std::max(1, static_cast<int>(std::ceil(scene::arc_deg(shell) / kWidestSector * (1.0 - kWhole))));
}

Patch ring_sector(const proto::Shell& shell, int k, int degree) {
  const int sectors = ring_sectors(shell);
  const double angle = scene::arc_deg(shell) * std::numbers::pi / 180.0 / sectors;
  const auto turned = [](const Patch& patch, double by) {
    return placed(patch, Vec3::Zero(), Quat(Eigen::AngleAxisd(by, Vec3::UnitZ())));
  };
  const auto share = [&](int elements) { return (elements + sectors - 1) / sectors; };
  if (shell.has_cylinder()) {  // its middle is over the x axis
    const auto& c = shell.cylinder();
    return turned(cylinder(c.radius_m(), c.length_m(), angle, share(c.elements_u()), c.elements_v(), degree),
                  (k - 0.5 * (sectors - 1)) * angle);
  }
  if (shell.has_cone()) {
    const auto& c = shell.cone();
    return turned(cone(c.bottom_m(), c.top_m(), c.height_m(), angle, share(c.elements_u()), c.elements_v(), degree),
                  k * angle);
  }
  const proto::Annulus& ring = shell.annulus();
  const auto elements = [&](double length) {
    return std::max(1, static_cast<int>(std::ceil(length / ring.element_m() * (1.0 - kWhole))));
  };
  return turned(cone(ring.outer_m(), ring.inner_m(), 0.0, angle, elements(angle * ring.outer_m()),
                     elements(ring.outer_m() - ring.inner_m()), degree),
                k * angle);
}

Patch posed_sector(const proto::Shell& shell, int k, int degree) {
  const proto::Pose& pose = shell.has_cylinder() ? shell.cylinder().pose()
                            : shell.has_cone()   ? shell.cone().pose()
                                                 : shell.annulus().pose();
  return placed(ring_sector(shell, k, degree), scene::to_vec(pose.position()), scene::to_quat(pose));
}

proto::Shell shell_of_sector(const proto::Shell& shell, int k) {
  proto::Shell out = shell;
  if (ring_sectors(shell) > 1) out.set_name(fmt::format("{}.{}", shell.name(), k + 1));
  for (int i = 0; i < shell.supports_size(); ++i) {
    out.mutable_supports(i)->clear_edges();
    for (const int edge : shell.supports(i).edges())
      for (const auto own : edges_of_sector(shell, k, edge)) out.mutable_supports(i)->add_edges(own);
  }
  out.clear_loads();
  for (const proto::ShellLoad& load : shell.loads()) {
    if (load.has_edge_force())
      for (const auto own : edges_of_sector(shell, k, load.edge_force().edge())) {
        proto::ShellLoad& l = *out.add_loads() = load;
        l.mutable_edge_force()->set_edge(own);
      }
    else if (load.has_edge_moment())
      for (const auto own : edges_of_sector(shell, k, load.edge_moment().edge())) {
        proto::ShellLoad& l = *out.add_loads() = load;
        l.mutable_edge_moment()->set_edge(own);
      }
    else
      *out.add_loads() = load;
  }
  return out;
}

}  // namespace sunder::shell
