#include "shell/io/trims.h"

#include <cmath>
#include <numbers>

#include "shell/geometry/parameter_place.h"
#include "shell/geometry/plane_curves.h"
#include "shell/io/cad_loop.h"

namespace sunder::shell {
namespace {

constexpr double kSame = 1e-9;        // spacings: points this near are one
constexpr double kMostCorners = 2e4;  // corners of a loop
constexpr double kLeastRadius = 0.5;  // of a circle [spacings]
constexpr double kLeastHole = 0.25;   // area of a hole that Gauss points notice [squared spacings]
constexpr int kAreaSteps = 3;         // corrections of the corners of a curve: each leaves a small share of the error

struct Domain {
  const Patch& patch;
  Vec2 low, high;
  double spacing;
  explicit Domain(const Patch& p)
      : patch(p),
        low(p.knots_u.begin(), p.knots_v.begin()),
        high(p.knots_u.end(), p.knots_v.end()),
        spacing(std::sqrt((high - low).prod() / (p.knots_u.spans() * p.knots_v.spans()))) {}
};

double area_of(const std::vector<Vec2>& loop) {
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < loop.size(); ++k) {
    const Vec2 a = loop[k] - loop[0], b = loop[k + 1] - loop[0];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

Vec2 inside(const scene::LoadedScene& scene, const std::string& field, const Domain& d, const Vec2& p,
            const char* what) {
  const Vec2 moved = moved_onto_edges(d.patch, p);
  scene.check(d.patch.contains(moved), field,
              "{} ({:.9g}, {:.9g}), outside the patch, whose parameters, metres on average, run {}; a loop may run "
              "along the border, not beyond it",
              what, p.x(), p.y(), parameter_range(d.patch));
  return moved;
}

std::vector<Vec2> polygon(const scene::LoadedScene& scene, const proto::Trim& m, const Domain& d,
                          const std::string& field) {
  scene.check(m.points_size() >= 4, field + ".points",
              "has {} points; a loop has three corners at least, and its first point again at the end",
              m.points_size());
  scene.check(m.points_size() <= kMostCorners, field + ".points", "has {} points; at most {:.0f}", m.points_size(),
              kMostCorners);
  const auto &first = m.points(0), &last = m.points(m.points_size() - 1);
  scene.check(first.u() == last.u() && first.v() == last.v(), fmt::format("{}.points[{}]", field, m.points_size() - 1),
              "is ({:.9g}, {:.9g}), and the loop begins at ({:.9g}, {:.9g}): it is open; end it with its first point",
              last.u(), last.v(), first.u(), first.v());
  std::vector<Vec2> points;
  for (int k = 0; k < m.points_size(); ++k) {
    const std::string own = fmt::format("{}.points[{}]", field, k);
    points.push_back(inside(scene, own, d, {m.points(k).u(), m.points(k).v()}, "lies at"));
    if (k > 0)
      scene.check((points[k] - points[k - 1]).norm() > kSame * d.spacing, own,
                  "is ({:.6g}, {:.6g}), as points[{}] is; leave one of them out", points[k].x(), points[k].y(), k - 1);
  }
  return points;
}

// Corners of a curve, moved along its normals until they enclose `area`.
std::vector<Vec2> corners(const scene::LoadedScene& scene, const PlaneCurve& curve, double area, const Domain& d,
                          const std::string& field) {
  for (const Vec2& p : fine_points(curve, d.spacing)) inside(scene, field, d, p, "reaches");
  scene.check(curve.length <= kMostCorners * d.spacing, field, "is {:.3g} m long, {:.3g} spacings of the shell",
              curve.length, curve.length / d.spacing);
  std::vector<Vec2> p = crack_points(curve, d.spacing);
  for (int step = 0; step < kAreaSteps; ++step) {
    const double now = area_of(p);
    double length = 0.0;
    for (std::size_t k = 0; k + 1 < p.size(); ++k) length += (p[k + 1] - p[k]).norm();
    const std::size_t count = p.size() - 1;
    std::vector<Vec2> moved = p;
    for (std::size_t k = 0; k < count; ++k) {
      const Vec2 along = (p[(k + 1) % count] - p[(k + count - 1) % count]).normalized();
      moved[k] += (area - now) / length * Vec2(along.y(), -along.x());  // outwards of a counter-clockwise loop
      moved[k] = moved[k].cwiseMax(d.low).cwiseMin(d.high);
    }
    moved.back() = moved.front();
    p = std::move(moved);
  }
  return p;
}

TrimLoop scene_loop(const scene::LoadedScene& scene, const proto::Trim& m, const Domain& d, const std::string& field) {
  if (m.has_circle()) {
    const double radius = m.circle().radius_m();
    scene.check(radius >= kLeastRadius * d.spacing, field + ".circle.radius_m",
                "is {} m, less than half a spacing of the shell, {:.3g} m; take a larger one, or more elements", radius,
                kLeastRadius * d.spacing);
    const PlaneCurve curve = circle_curve({m.circle().center().u(), m.circle().center().v()}, radius);
    return {corners(scene, curve, std::numbers::pi * radius * radius, d, field + ".circle"), m.hole(), {curve}};
  }
  if (m.has_curve()) {
    std::vector<Vec2> points;
    for (const auto& p : m.curve().points()) points.emplace_back(p.u(), p.v());
    const PlaneCurve curve = spline_curve(points, m.curve().has_degree() ? m.curve().degree() : 3, true);
    return {
        corners(scene, curve, area_of(fine_points(curve, 0.1 * d.spacing)), d, field + ".curve"), m.hole(), {curve}};
  }
  return {polygon(scene, m, d, field), m.hole(), {}};
}

// A loop with its place in messages: the field, and what stands before the message.
struct NamedLoop {
  TrimLoop loop;
  std::string field, before, name;
};

// Throws Error where two loops meet, or one lies where it has no effect.
void check_together(const scene::LoadedScene& scene, const std::vector<NamedLoop>& loops, const Domain& d) {
  for (std::size_t i = 0; i < loops.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const auto& [first, field, before, own] = loops[i];
      const auto& [second, field_k, before_k, other] = loops[k];
      scene.check(first.hole || second.hole, field,
                  "{}is a second outline, and {} is one; a shell has one outline: give two shells, or hole: true",
                  before, other);
      for (std::size_t a = 0; a + 1 < first.points.size(); ++a)
        for (std::size_t b = 0; b + 1 < second.points.size(); ++b) {
          const std::vector<Vec2> two{first.points[a], first.points[a + 1], second.points[b], second.points[b + 1]};
          const Vec2 low = two[0].cwiseMin(two[1]), high = two[0].cwiseMax(two[1]);
          const Vec2 pad = Vec2::Constant(kSame * d.spacing);
          if (((two[2].cwiseMax(two[3]) + pad).array() < low.array()).any() ||
              ((two[2].cwiseMin(two[3]) - pad).array() > high.array()).any())
            continue;
          const auto at = segments_touch(two[0], two[1], two[2], two[3], kSame * d.spacing);
          if (at)
            scene.fail(field, fmt::format("{}meets {} at ({:.6g}, {:.6g}); loops do not meet: join them to one", before,
                                          other, at->x(), at->y()));
        }
      const auto holds = [&](const TrimLoop& one, const TrimLoop& inner) {
        return TrimLoops(d.low, d.high, {{one.points, false}}).contains(inner.points.front());
      };
      if (first.hole && second.hole)
        scene.check(!holds(first, second) && !holds(second, first), field,
                    "{}and {} are holes one in the other; leave the inner one out", before, other);
      else
        scene.check(first.hole ? holds(second, first) : holds(first, second), field,
                    "{}and {}: the hole lies outside of the outline and cuts away nothing; leave it out", before,
                    other);
    }
}

void check_alone(const scene::LoadedScene& scene, const NamedLoop& named, const Domain& d) {
  const std::vector<Vec2>& points = named.loop.points;
  if (const auto hit = meets_itself(points, kSame * d.spacing))
    scene.fail(named.field,
               fmt::format("{}meets itself at ({:.6g}, {:.6g}): its sides from ({:.6g}, {:.6g}) and from ({:.6g}, "
                           "{:.6g}); a loop neither crosses nor touches itself",
                           named.before, hit->at.x(), hit->at.y(), points[hit->first].x(), points[hit->first].y(),
                           points[hit->second].x(), points[hit->second].y()));
  const double area = std::abs(area_of(points)), least = kLeastHole * d.spacing * d.spacing;
  scene.check(area >= least, named.field,
              "{}encloses {:.3g} m^2, less than a quarter of an element, {:.3g} m^2: no Gauss point would notice; take "
              "a larger one, or more elements",
              named.before, area, least);
}

}  // namespace

TrimLoops make_trims(const scene::LoadedScene& scene, const proto::Shell& shell, const Patch& patch,
                     const std::string& field, const std::vector<CadLoop>& of_file) {
  const Domain d(patch);
  std::vector<NamedLoop> loops;
  for (std::size_t i = 0; i < of_file.size(); ++i) {
    const bool mesh = shell.has_mesh();
    const std::string name = of_file[i].hole ? fmt::format("hole {} of the {}", i, mesh ? "surface" : "face")
                                             : fmt::format("the {}'s border", mesh ? "surface" : "face");
    loops.push_back({cad_loop(of_file[i], patch, d.spacing), field + (mesh ? ".mesh.path" : ".cad.path"),
                     fmt::format("'{}': {} ", mesh ? shell.mesh().path() : shell.cad().path(), name), name});
  }
  for (int i = 0; i < shell.trims_size(); ++i) {
    const std::string own = fmt::format("{}.trims[{}]", field, i);
    loops.push_back({scene_loop(scene, shell.trims(i), d, own), own, "", fmt::format("trims[{}]", i)});
  }
  if (loops.empty()) return {};
  for (const NamedLoop& loop : loops) check_alone(scene, loop, d);
  check_together(scene, loops, d);
  std::vector<TrimLoop> all;
  for (NamedLoop& loop : loops) all.push_back(std::move(loop.loop));
  return {d.low, d.high, std::move(all)};
}

}  // namespace sunder::shell
