#include "shell/io/strength_factors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shell/geometry/parameter_place.h"
#include "shell/io/grey_map.h"

namespace sunder::shell {
namespace {

bool holds(const proto::StrengthRegion& r, const Vec2& p) {
  if (r.has_disc()) return (p - Vec2(r.disc().center().u(), r.disc().center().v())).norm() <= r.disc().radius_m();
  return p.x() >= r.low().u() && p.x() <= r.high().u() && p.y() >= r.low().v() && p.y() <= r.high().v();
}

// Distance of a point from a polyline [m]; `at` gives its corners.
template <class Point, class At>
double distance_to_line(const Point& p, int corners, At&& at) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 1; i < corners; ++i) {
    const Point a = at(i - 1), d = at(i) - a;
    least = std::min(least, (p - a - std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0) * d).norm());
  }
  return least;
}

bool holds(const proto::StrengthLine& line, const Vec2& p) {
  const auto at = [&](int i) { return Vec2(line.points(i).u(), line.points(i).v()); };
  return distance_to_line(p, line.points_size(), at) <= 0.5 * line.width_m();
}

// Tests whether a point of a surface with this normal is near a segment. It is within half the width along the tangent
// plane. Across that plane it is within half the length of the segment, the distance from the chord of half a circle.
bool holds(const proto::SpaceLine& line, double width, const Vec3& x, const Vec3& normal) {
  for (int i = 1; i < line.points_size(); ++i) {
    const Vec3 a = scene::to_vec(line.points(i - 1)), d = scene::to_vec(line.points(i)) - a;
    const Vec3 flat = d - d.dot(normal) * normal, arm = x - a, near = arm - arm.dot(normal) * normal;
    const double length2 = flat.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp(flat.dot(near) / length2, 0.0, 1.0) : 0.5;
    const double across = std::abs((arm - t * d).dot(normal)), reach = 0.5 * std::max(d.norm(), width);
    if ((near - t * flat).norm() <= 0.5 * width && across <= reach) return true;
  }
  return false;
}

// True where a scene's line may weaken the shell.
bool is_for(const proto::SpaceLine& line, const proto::Shell& shell, const std::string& name) {
  return line.shells_size() == 0 || std::any_of(line.shells().begin(), line.shells().end(),
                                                [&](const std::string& s) { return s == shell.name() || s == name; });
}

// Gauss points along a narrower line would leave gaps.
void check_width(const scene::LoadedScene& scene, const std::string& field, double width, const ShellModel& m) {
  scene.check(width >= m.longest_element * (1.0 - 1e-6), field + ".width_m",
              "is {} m, and the longest element of shell '{}' is {:.4g} m, so the line would have gaps; give {:.4g} m "
              "or more, or take more elements",
              width, m.name, m.longest_element, 1.001 * m.longest_element);
}

}  // namespace

std::vector<float> strength_factors(const scene::LoadedScene& scene, const proto::Shell& s, const ShellModel& m,
                                    const std::string& field, const Paint* paint) {
  const auto& across = scene.message.strength_lines();
  const bool any_across = m.material.strength > 0.0 && std::any_of(across.begin(), across.end(), [&](const auto& line) {
                            return is_for(line, s, m.name);
                          });
  if (s.strength_regions_size() + s.strength_lines_size() == 0 && !s.has_strength_map() && !any_across && !paint)
    return {};
  const RowTables& t = m.tables;
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()),
      size = Vec2(m.patch.knots_u.end(), m.patch.knots_v.end()) - low;
  GreyImage image;
  const auto& map = s.strength_map();
  if (s.has_strength_map()) image = read_grey_map(scene, map.path(), size, field + ".strength_map");
  const double black = map.low_factor(), white = map.has_high_factor() ? map.high_factor() : 1.0;
  std::vector<int> held(s.strength_regions_size(), 0), near(s.strength_lines_size(), 0);
  for (int k = 0; k < s.strength_lines_size(); ++k)
    check_width(scene, fmt::format("{}.strength_lines[{}]", field, k), s.strength_lines(k).width_m(), m);
  std::vector<float> factors(static_cast<std::size_t>(t.blocks()) * t.lanes, 1.0f);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, t, q, e).parameter;
      double factor = paint ? paint->at(p) : 1.0;
      if (s.has_strength_map())
        factor *= black + (white - black) * image.grey((p.x() - low.x()) / size.x(), (p.y() - low.y()) / size.y());
      for (int k = 0; k < s.strength_regions_size(); ++k)
        if (holds(s.strength_regions(k), p)) ++held[k], factor *= s.strength_regions(k).factor();
      for (int k = 0; k < s.strength_lines_size(); ++k)
        if (holds(s.strength_lines(k), p)) ++near[k], factor *= s.strength_lines(k).factor();
      for (int k = 0; k < across.size() && any_across; ++k) {
        const SurfacePoint x = m.patch.evaluate(p);
        const double width = across[k].width_m();
        const Vec3 normal = x.u.cross(x.v).normalized();
        if (!is_for(across[k], s, m.name) || !holds(across[k], std::max(width, m.longest_element), x.x, normal))
          continue;
        check_width(scene, fmt::format("strength_lines[{}]", k), width, m);
        factor *= across[k].factor();
      }
      scene.check(factor >= scene::kLeastFactor && factor <= scene::kMostFactor, field + ".strength_regions",
                  "multiply to {:.3g} at ({:.4g}, {:.4g}), with lines, strength_map and strength_paint; {:.0g} to "
                  "{:.0g} of the "
                  "material's strength",
                  factor, p.x(), p.y(), scene::kLeastFactor, scene::kMostFactor);
      factors[static_cast<std::size_t>(q) * t.lanes + e] = static_cast<float>(factor);
    }
  for (int k = 0; k < s.strength_lines_size(); ++k)
    scene.check(near[k] > 0, fmt::format("{}.strength_lines[{}]", field, k),
                "passes no Gauss point of the shell, whose parameters run {}; move it", parameter_range(m.patch));
  for (int k = 0; k < s.strength_regions_size(); ++k)
    scene.check(held[k] > 0, fmt::format("{}.strength_regions[{}]", field, k),
                "holds no Gauss point of the shell, whose parameters run from {:.6g} to {:.6g} along u and from {:.6g} "
                "to {:.6g} along v, with a spacing of {:.3g} m; move it, or make it larger",
                low.x(), low.x() + size.x(), low.y(), low.y() + size.y(), m.spacing);
  return factors;
}

void check_space_lines(const scene::LoadedScene& scene, const std::vector<const proto::Shell*>& shells,
                       const std::vector<const ShellModel*>& models) {
  const auto passes = [](const proto::SpaceLine& line, const ShellModel& m) {
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) {
        const GaussPoint g = gauss_point(m.patch, m.tables, q, e);
        if (g.weight == 0.0) continue;
        const SurfacePoint x = m.patch.evaluate(g.parameter);
        if (holds(line, line.width_m(), x.x, x.u.cross(x.v).normalized())) return true;
      }
    return false;
  };
  for (int i = 0; i < scene.message.strength_lines_size(); ++i) {
    const proto::SpaceLine& line = scene.message.strength_lines(i);
    bool any = false;
    for (std::size_t k = 0; k < models.size() && !any; ++k)
      any = models[k]->material.strength > 0.0 && is_for(line, *shells[k], models[k]->name) && passes(line, *models[k]);
    scene.check(any, fmt::format("strength_lines[{}]", i),
                "passes no Gauss point of a shell with a strength; its points are places in space [m] on the surface "
                "at rest: move it");
  }
}

}  // namespace sunder::shell
