#include "shell/io/near_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "shell/io/build_seams.h"

namespace sunder::shell {
namespace {

constexpr double kRoundOff = 1e-9;       // of the thickness: parts that far apart do not touch
constexpr double kTouchingShare = 0.02;  // of the thickness: for parts that near no thickness is worth its steps
constexpr double kThinner = 0.9;         // of the distance, a thickness that leaves a gap
constexpr double kPlaneReach = 0.6;  // of a spacing: as far from a Gauss point its tangent plane stands for the surface

// A Gauss point of a shell, or the middle of an element.
struct NearSample {
  int shell = 0;
  Vec3 x, normal;
};

using NearCell = std::array<long, 3>;

NearCell cell_of(const Vec3& x, double width) {
  return {std::lround(std::floor(x.x() / width)), std::lround(std::floor(x.y() / width)),
          std::lround(std::floor(x.z() / width))};
}

std::vector<NearSample> near_samples(const RunSetup& setup) {
  std::vector<NearSample> out;
  for (std::size_t k = 0; k < setup.shells.size(); ++k) {
    const ShellModel& m = setup.shells[k].model;
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) {
        const GaussPoint g = gauss_point(m.patch, m.tables, q, e);
        if (g.weight <= 0.0) continue;
        const SurfacePoint p = m.patch.evaluate(g.parameter);
        out.push_back({static_cast<int>(k), p.x, p.u.cross(p.v).normalized()});
      }
  }
  return out;
}

// How far a place is from the surface about a sample of the shell `of`; beyond the reach of its plane, from the sample.
double apart_from(const NearSample& s, const ShellModel& of, const Vec3& x) {
  const Vec3 d = x - s.x;
  const double along = d.dot(s.normal), aside = (d - along * s.normal).norm();
  return aside <= kPlaneReach * of.spacing ? std::abs(along) : d.norm();
}

}  // namespace

std::vector<NearParts> near_parts(const RunSetup& setup) {
  std::vector<int> group(setup.shells.size(), 0);
  const std::vector<std::vector<int>> groups = joined_groups(setup);
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const int k : groups[g]) group[k] = static_cast<int>(g);
  const auto apart = [&](int a, int b) {  // faces of one shell of the scene have one contact group
    return group[a] != group[b] && setup.shells[a].model.contact_group == setup.shells[b].model.contact_group;
  };
  bool any = false;
  double width = 0.0;  // of a cell: as far as two samples may be from each other
  for (std::size_t k = 0; k < setup.shells.size(); ++k) {
    const ShellModel& m = setup.shells[k].model;
    any = any || (k > 0 && apart(static_cast<int>(k) - 1, static_cast<int>(k)));
    width = std::max(width, kPlaneReach * m.spacing + m.largest_thickness());
  }
  if (!any) return {};
  const std::vector<NearSample> samples = near_samples(setup);
  std::map<NearCell, std::vector<int>> cells;
  for (std::size_t i = 0; i < samples.size(); ++i) cells[cell_of(samples[i].x, width)].push_back(static_cast<int>(i));
  std::map<std::pair<int, int>, NearParts> nearest;  // by groups
  for (const NearSample& s : samples) {
    const NearCell own = cell_of(s.x, width);
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const auto cell = cells.find({own[0] + i, own[1] + j, own[2] + k});
          if (cell == cells.end()) continue;
          for (const int n : cell->second) {
            const NearSample& other = samples[n];
            if (!apart(s.shell, other.shell)) continue;
            const ShellModel &a = setup.shells[s.shell].model, &b = setup.shells[other.shell].model;
            const double thickness = 0.5 * (a.thickness + b.thickness), away = apart_from(other, b, s.x);
            if (away >= (1.0 - kRoundOff) * thickness) continue;
            const NearParts found{std::min(s.shell, other.shell), std::max(s.shell, other.shell), away, thickness, s.x};
            const auto [at, is_new] = nearest.try_emplace(std::minmax(group[s.shell], group[other.shell]), found);
            if (!is_new && away < at->second.apart) at->second = found;
          }
        }
  }
  std::vector<NearParts> out;
  for (const auto& [pair, near] : nearest) out.push_back(near);
  return out;
}

double free_thickness(const RunSetup& setup, double thickness) {
  for (const NearParts& near : near_parts(setup))
    if (near.apart > kTouchingShare * near.thickness) thickness = std::min(thickness, kThinner * near.apart);
  return thickness;
}

std::string near_warning(const RunSetup& setup, const NearParts& near) {
  const std::string &a = setup.shells[near.first].model.name, &b = setup.shells[near.second].model.name;
  const std::string thinner = near.apart > kTouchingShare * near.thickness
                                  ? fmt::format("give a thickness of at most {:.3g} m, ", kThinner * near.apart)
                                  : "";
  return fmt::format(
      "shells '{}' and '{}' are {:.3g} m apart at ({:.6g}, {:.6g}, {:.6g}) m, less than their thickness of {:.3g} m, "
      "and no seam joins them: contact parts them from the start; {}leave one of them out, or move them apart in the "
      "program that made the file",
      a, b, near.apart, near.at.x(), near.at.y(), near.at.z(), near.thickness, thinner);
}

}  // namespace sunder::shell
