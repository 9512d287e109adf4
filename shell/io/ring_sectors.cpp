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

double angle_of(const proto::Annulus& ring) { return ring.has_angle_deg() ? ring.angle_deg() : 360.0; }

// Edges of the patch of sector k that an edge of the ring means.
std::vector<proto::Support::Edge> edges_of_sector(const proto::Annulus& ring, int k, int edge) {
  const bool first = !ring_closed(ring) && k == 0, last = !ring_closed(ring) && k + 1 == ring_sectors(ring);
  const bool all = edge == proto::Support::ALL;
  std::vector<proto::Support::Edge> out;
  if (all || edge == proto::Support::OUTER || edge == proto::Support::V_MIN) out.push_back(proto::Support::V_MIN);
  if (all || edge == proto::Support::INNER || edge == proto::Support::V_MAX) out.push_back(proto::Support::V_MAX);
  if (first && (all || edge == proto::Support::U_MIN)) out.push_back(proto::Support::U_MIN);
  if (last && (all || edge == proto::Support::U_MAX)) out.push_back(proto::Support::U_MAX);
  return out;
}

}  // namespace

int ring_sectors(const proto::Annulus& ring) {
  return std::max(1, static_cast<int>(std::ceil(angle_of(ring) / kWidestSector * (1.0 - kWhole))));
}

bool ring_closed(const proto::Annulus& ring) { return !ring.slit() && angle_of(ring) == 360.0; }

Patch ring_sector(const proto::Annulus& ring, int k, int degree) {
  const double angle = angle_of(ring) * std::numbers::pi / 180.0 / ring_sectors(ring);
  const auto elements = [&](double length) {
    return std::max(1, static_cast<int>(std::ceil(length / ring.element_m() * (1.0 - kWhole))));
  };
  const Patch sector = cone(ring.outer_m(), ring.inner_m(), 0.0, angle, elements(angle * ring.outer_m()),
                            elements(ring.outer_m() - ring.inner_m()), degree);
  return placed(sector, Vec3::Zero(), Quat(Eigen::AngleAxisd(k * angle, Vec3::UnitZ())));
}

proto::Shell shell_of_sector(const proto::Shell& shell, int k) {
  const proto::Annulus& ring = shell.annulus();
  proto::Shell out = shell;
  if (ring_sectors(ring) > 1) out.set_name(fmt::format("{}.{}", shell.name(), k + 1));
  for (int i = 0; i < shell.supports_size(); ++i) {
    out.mutable_supports(i)->clear_edges();
    for (const int edge : shell.supports(i).edges())
      for (const auto own : edges_of_sector(ring, k, edge)) out.mutable_supports(i)->add_edges(own);
  }
  out.clear_loads();
  for (const proto::ShellLoad& load : shell.loads()) {
    if (load.has_edge_force())
      for (const auto own : edges_of_sector(ring, k, load.edge_force().edge())) {
        proto::ShellLoad& l = *out.add_loads() = load;
        l.mutable_edge_force()->set_edge(own);
      }
    else if (load.has_edge_moment())
      for (const auto own : edges_of_sector(ring, k, load.edge_moment().edge())) {
        proto::ShellLoad& l = *out.add_loads() = load;
        l.mutable_edge_moment()->set_edge(own);
      }
    else
      *out.add_loads() = load;
  }
  return out;
}

}  // namespace sunder::shell
