#include "shell/io/trims.h"

#include <cmath>
#include <numbers>

#include "shell/geometry/parameter_place.h"
#include "shell/geometry/plane_curves.h"

namespace sunder::shell {
namespace {

constexpr double kSame = 1e-9;        // spacings: points this near are one
constexpr double kMostCorners = 2e4;  // corners of a loop
constexpr double kLeastRadius = 0.5;  // of a circle [spacings]
constexpr double kLeastHole = 0.25;   // area of a hole that Gauss points notice [squared spacings]
constexpr int kAreaSteps = 3;         // corrections of the corners of a curve: each leaves the square of the error

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

std::vector<Vec2> points_of(const scene::LoadedScene& scene, const proto::Trim& m, const Domain& d,
                            const std::string& field) {
  if (m.has_circle()) {
    const double radius = m.circle().radius_m();
    scene.check(radius >= kLeastRadius * d.spacing, field + ".circle.radius_m",
                "is {} m, less than half a spacing of the shell, {:.3g} m; take a larger one, or more elements", radius,
                kLeastRadius * d.spacing);
    return corners(scene, circle_curve({m.circle().center().u(), m.circle().center().v()}, radius),
                   std::numbers::pi * radius * radius, d, field + ".circle");
  }
  if (m.has_curve()) {
    std::vector<Vec2> points;
    for (const auto& p : m.curve().points()) points.emplace_back(p.u(), p.v());
    const PlaneCurve curve = spline_curve(points, m.curve().has_degree() ? m.curve().degree() : 3, true);
    return corners(scene, curve, area_of(fine_points(curve, 0.1 * d.spacing)), d, field + ".curve");
  }
  return polygon(scene, m, d, field);
}

// Throws Error where two loops meet, or one lies where it has no effect.
void check_together(const scene::LoadedScene& scene, const std::vector<TrimLoop>& loops, const Domain& d,
                    const std::string& field) {
  for (std::size_t i = 0; i < loops.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const std::string own = fmt::format("{}.trims[{}]", field, i);
      scene.check(loops[i].hole || loops[k].hole, own,
                  "is a second outline, and trims[{}] is one; a shell has one outline: give two shells, or hole: true",
                  k);
      for (std::size_t a = 0; a + 1 < loops[i].points.size(); ++a)
        for (std::size_t b = 0; b + 1 < loops[k].points.size(); ++b) {
          const std::vector<Vec2> two{loops[i].points[a], loops[i].points[a + 1], loops[k].points[b],
                                      loops[k].points[b + 1]};
          const Vec2 low = two[0].cwiseMin(two[1]), high = two[0].cwiseMax(two[1]);
          const Vec2 pad = Vec2::Constant(kSame * d.spacing);
          if (((two[2].cwiseMax(two[3]) + pad).array() < low.array()).any() ||
              ((two[2].cwiseMin(two[3]) - pad).array() > high.array()).any())
            continue;
          const auto at = segments_touch(two[0], two[1], two[2], two[3], kSame * d.spacing);
          if (at)
            scene.fail(own, fmt::format("meets trims[{}] at ({:.6g}, {:.6g}); loops do not meet: join them to one", k,
                                        at->x(), at->y()));
        }
      const auto holds = [&](std::size_t one, std::size_t other) {
        return TrimLoops(d.low, d.high, {{loops[one].points, false}}).contains(loops[other].points.front());
      };
      if (loops[i].hole && loops[k].hole)
        scene.check(!holds(i, k) && !holds(k, i), own,
                    "and trims[{}] are holes one in the other; leave the inner one out", k);
      else
        scene.check(loops[i].hole ? holds(k, i) : holds(i, k), own,
                    "and trims[{}]: the hole lies outside of the outline and cuts away nothing; leave it out", k);
    }
}

}  // namespace

TrimLoops make_trims(const scene::LoadedScene& scene, const proto::Shell& shell, const Patch& patch,
                     const std::string& field) {
  if (shell.trims_size() == 0) return {};
  const Domain d(patch);
  std::vector<TrimLoop> loops;
  for (int i = 0; i < shell.trims_size(); ++i) {
    const std::string own = fmt::format("{}.trims[{}]", field, i);
    TrimLoop loop{points_of(scene, shell.trims(i), d, own), shell.trims(i).hole()};
    if (const auto hit = meets_itself(loop.points, kSame * d.spacing))
      scene.fail(own, fmt::format("meets itself at ({:.6g}, {:.6g}): its sides from ({:.6g}, {:.6g}) and from ({:.6g}, "
                                  "{:.6g}); a loop neither crosses nor touches itself",
                                  hit->at.x(), hit->at.y(), loop.points[hit->first].x(), loop.points[hit->first].y(),
                                  loop.points[hit->second].x(), loop.points[hit->second].y()));
    const double area = std::abs(area_of(loop.points)), least = kLeastHole * d.spacing * d.spacing;
    scene.check(
        area >= least, own,
        "encloses {:.3g} m^2, less than a quarter of an element, {:.3g} m^2: no Gauss point would notice; take a "
        "larger one, or more elements",
        area, least);
    loops.push_back(std::move(loop));
  }
  check_together(scene, loops, d, field);
  return {d.low, d.high, std::move(loops)};
}

}  // namespace sunder::shell
