#include "shell/io/cuts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shell/geometry/edges.h"
#include "shell/geometry/parameter_place.h"
#include "shell/geometry/plane_curves.h"
#include "shell/solver/cracking/clamp.h"

namespace sunder::shell {
namespace {

constexpr double kSame = 1e-9;      // spacings: points this near are one
constexpr double kMostEdges = 2e4;  // edges of a curve

Vec2 to_vec2(const proto::ParameterPoint& p) { return {p.u(), p.v()}; }

struct Domain {
  const Patch& patch;
  Vec2 low, high;
  double spacing;
  explicit Domain(const ShellModel& m)
      : patch(m.patch),
        low(m.patch.knots_u.begin(), m.patch.knots_v.begin()),
        high(m.patch.knots_u.end(), m.patch.knots_v.end()),
        spacing(m.spacing) {}
  Vec2 nearest(const Vec2& p) const { return p.cwiseMax(low).cwiseMin(high); }
};

// Returns p, moved onto the border where it is by an edge. Throws Error where it is outside.
Vec2 inside(const scene::LoadedScene& scene, const std::string& field, const Domain& d, const Vec2& p,
            const char* what) {
  const Vec2 moved = moved_onto_edges(d.patch, p);
  scene.check(d.patch.contains(moved), field,
              "{} ({:.9g}, {:.9g}), {:.3g} m outside the patch, whose parameters, metres on average, run {}; end a cut "
              "at the border to run out there",
              what, p.x(), p.y(), (d.nearest(p) - p).norm(), parameter_range(d.patch));
  return moved;
}

bool encloses(const std::vector<Vec2>& ring, const Vec2& p) {
  bool inside = false;
  for (std::size_t k = 0; k + 1 < ring.size(); ++k) {
    const Vec2 &a = ring[k], &b = ring[k + 1];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

// Tests whether a ring holds a Gauss point. A piece consists of its Gauss points: a ring without any would leave a
// crack but no piece.
bool encloses_a_point(const ShellModel& m, const std::vector<Vec2>& ring) {
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e)
      if (encloses(ring, gauss_point(m.patch, m.tables, q, e).parameter)) return true;
  return false;
}

constexpr const char* kItself =
    "a cut neither crosses nor touches itself, but for a last point that is exactly the first and closes it; give two "
    "cuts";

std::vector<Vec2> polyline(const scene::LoadedScene& scene, const proto::Cut& m, const Domain& d,
                           const std::string& field) {
  std::vector<Vec2> points;
  scene.check(m.points_size() <= kMostEdges, field,
              "has {} points; at most {:.0f}: an element is {:.3g} m long, and tells none that are much closer",
              m.points_size(), kMostEdges, d.spacing);
  for (int k = 0; k < m.points_size(); ++k) {
    const std::string own = fmt::format("{}.points[{}]", field, k);
    points.push_back(inside(scene, own, d, to_vec2(m.points(k)), "lies at"));
    if (k > 0)
      scene.check(
          (points[k] - points[k - 1]).norm() > kSame * d.spacing, own,
          "is ({:.6g}, {:.6g}), as points[{}] is: the segment between them has no length; leave one of them out",
          points[k].x(), points[k].y(), k - 1);
  }
  if (const auto hit = meets_itself(points, kSame * d.spacing))
    scene.fail(fmt::format("{}.points[{}]", field, hit->second),
               fmt::format("the segment from here to points[{}] meets that from points[{}] to points[{}] at ({:.6g}, "
                           "{:.6g}); {}",
                           hit->second + 1, hit->first, hit->first + 1, hit->at.x(), hit->at.y(), kItself));
  // The shell cannot resolve such short edges: they would cost time and change nothing.
  double shortest = d.spacing;
  for (std::size_t k = 1; k < points.size(); ++k) shortest = std::min(shortest, (points[k] - points[k - 1]).norm());
  if (shortest >= kShortestEdge * d.spacing) return points;
  std::vector<Vec2> fewer = thinned(points, kSag * d.spacing);
  return meets_itself(fewer, kSame * d.spacing) ? points : fewer;
}

std::vector<Vec2> sampled(const scene::LoadedScene& scene, const PlaneCurve& curve, const Domain& d,
                          const std::string& field) {
  for (const Vec2& p : fine_points(curve, d.spacing)) inside(scene, field, d, p, "reaches");
  scene.check(curve.length > kSame * d.spacing, field, "has no length; its points are one and the same");
  scene.check(curve.length <= kMostEdges * d.spacing, field,
              "is {:.3g} m long, {:.3g} spacings of the shell; at most {:.0g}", curve.length, curve.length / d.spacing,
              kMostEdges);
  std::vector<Vec2> points = crack_points(curve, d.spacing);
  for (Vec2& p : points) p = d.nearest(p);
  if (const auto hit = meets_itself(points, kSame * d.spacing))
    scene.fail(
        field,
        fmt::format("meets itself at ({:.6g}, {:.6g}): its {} edges, of about a spacing of {:.3g} m, have "
                    "number {} from ({:.6g}, {:.6g}) and number {} from ({:.6g}, {:.6g}) there; {}",
                    hit->at.x(), hit->at.y(), points.size() - 1, d.spacing, hit->first, points[hit->first].x(),
                    points[hit->first].y(), hit->second, points[hit->second].x(), points[hit->second].y(), kItself));
  return points;
}

// Returns the edge on which both points lie, or 0. A point that is outside by round-off lies on the edge.
int edge_of(const Domain& d, const Vec2& a, const Vec2& b) {
  for (const int edge : kEdges) {
    const int axis = edge < kVMin ? 0 : 1;
    const double at = edge == kUMin || edge == kVMin ? d.low[axis] : d.high[axis];
    if (std::max(std::abs(a[axis] - at), std::abs(b[axis] - at)) <= kSame * d.spacing) return edge;
  }
  return 0;
}

// Divides the cut into polylines inside the patch and segments on its edges.
PrescribedCut divided(const Domain& d, std::vector<Vec2> points, double time) {
  PrescribedCut out;
  out.time = time;
  const std::size_t segments = points.size() - 1;
  std::vector<int> on(segments);
  for (std::size_t k = 0; k < segments; ++k) on[k] = edge_of(d, points[k], points[k + 1]);
  const auto first = std::find_if(on.begin(), on.end(), [](int edge) { return edge != 0; });
  if (first == on.end()) {
    out.lines.push_back(std::move(points));
    return out;
  }
  // A closed cut is followed from its first segment on an edge.
  const std::size_t start = points.front() == points.back() ? first - on.begin() : 0;
  std::vector<Vec2> line;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t k = (start + i) % segments;
    const Vec2 &a = points[k], &b = points[k + 1];
    if (on[k] == 0) {
      if (line.empty()) line.push_back(a);
      line.push_back(b);
      continue;
    }
    if (!line.empty()) out.lines.push_back(std::exchange(line, {}));
    const int axis = on[k] < kVMin ? 1 : 0;
    const double length = d.high[axis] - d.low[axis];
    const double from = (a[axis] - d.low[axis]) / length, to = (b[axis] - d.low[axis]) / length;
    out.on_edges.push_back({on[k], std::min(from, to), std::max(from, to)});
  }
  if (!line.empty()) out.lines.push_back(std::move(line));
  return out;
}

// Divides a line into `pieces` of one length. The points of the line stay.
std::vector<std::vector<Vec2>> pieces_of(const std::vector<Vec2>& points, int pieces) {
  double length = 0.0;
  for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
  std::vector<std::vector<Vec2>> out{{points.front()}};
  const double least = 1e-6 * length / pieces;  // a shorter rest belongs to the segment before it
  double done = 0.0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const double side = (points[k] - points[k - 1]).norm();
    for (;;) {
      const double next = length * static_cast<double>(out.size()) / pieces;
      if (static_cast<int>(out.size()) == pieces || next > done + side - least) break;
      const Vec2 p = points[k - 1] + (next - done) / side * (points[k] - points[k - 1]);
      if (next > done + least) out.back().push_back(p);
      out.push_back({out.back().back()});
    }
    out.back().push_back(points[k]);
    done += side;
  }
  return out;
}

// The pieces of a cut that grows; each is made when its end is reached.
std::vector<PrescribedCut> growing(const Domain& d, const std::vector<Vec2>& points, double from, double until) {
  double length = 0.0;
  for (std::size_t k = 1; k < points.size(); ++k) length += (points[k] - points[k - 1]).norm();
  const int pieces = std::max(1, static_cast<int>(std::ceil(length / d.spacing)));
  std::vector<PrescribedCut> out;
  for (std::vector<Vec2>& piece : pieces_of(points, pieces)) {
    const double share = static_cast<double>(out.size() + 1) / pieces;
    out.push_back(divided(d, std::move(piece), from + share * (until - from)));
    out.back().goes_on = static_cast<int>(out.size()) < pieces;
  }
  return out;
}

}  // namespace

std::vector<PrescribedCut> cut_along(const ShellModel& model, std::vector<Vec2> points, double from, double until) {
  const Domain d(model);
  if (until > from) return growing(d, points, from, until);
  return {divided(d, std::move(points), from)};
}

void settle_edges(const scene::LoadedScene& scene, const ShellModel& model, int seamed, const std::string& field,
                  PrescribedCut& cut) {
  std::vector<EdgeCut> seams;
  for (const EdgeCut& e : cut.on_edges) {
    const Vec2 from = edge_point(model.patch, e.edge, e.from), to = edge_point(model.patch, e.edge, e.to);
    const std::vector<int> row = edge_row(model.patch, e.edge, 0);
    int held = 0, all = 0;  // control points along the edge
    for (const int point : row) {
      const Vec2& at = model.parameter[point];
      if ((at - from).dot(at - to) <= 0.0) ++all, held += model.held[model.tables.slot(point)] != 0;
    }
    if (model.clamped & e.edge) {
      const double inside = (e.edge == kUMin || e.edge == kVMin ? 1.0 : -1.0) * kOnBorder * model.spacing;
      std::vector<Vec2> line{from, to};
      for (Vec2& p : line) p[e.edge < kVMin ? 0 : 1] += inside;
      cut.lines.push_back(std::move(line));
      continue;
    }
    scene.check(
        all == 0 || held < all, field,
        "lies on an edge of the patch from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g}) that a support holds without its "
        "slope: nothing bends there, and a support releases nothing; cut half an element inside, or leave the "
        "support out",
        from.x(), from.y(), to.x(), to.y());
    scene.check((seamed & e.edge) != 0, field,
                "lies on an edge of the patch from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g}), on which nothing hangs: it is "
                "no seam that fastens and not clamped; leave that side out, an end on the border runs out there",
                from.x(), from.y(), to.x(), to.y());
    seams.push_back(e);
  }
  cut.on_edges = std::move(seams);
}

std::vector<PrescribedCut> make_cut(const scene::LoadedScene& scene, const proto::Cut& m, const ShellModel& model,
                                    const std::string& field) {
  const Domain d(model);
  const auto whole = [&](std::vector<Vec2> points) -> std::vector<PrescribedCut> {
    return cut_along(model, std::move(points), m.time_s(), m.has_until_s() ? m.until_s() : m.time_s());
  };
  const double least = kSmallestRound * d.spacing;
  if (m.has_circle()) {
    const double radius = m.circle().radius_m();
    scene.check(radius >= least, field + ".circle.radius_m",
                "is {} m, less than half a spacing of the shell, {:.3g} m; take a larger one, or more elements", radius,
                least);
    return whole(sampled(scene, circle_curve(to_vec2(m.circle().center()), radius), d, field + ".circle"));
  }
  if (m.has_spiral()) {
    const auto& s = m.spiral();
    const double apart = (s.outer_radius_m() - s.inner_radius_m()) / s.turns();
    scene.check(apart >= least || s.turns() < 1.0, field + ".spiral.turns",
                "is {}: turns {:.3g} m apart, less than half a spacing of the shell, {:.3g} m; take fewer, or more "
                "elements",
                s.turns(), apart, least);
    return whole(sampled(scene, spiral_curve(to_vec2(s.center()), s.inner_radius_m(), s.outer_radius_m(), s.turns()), d,
                         field + ".spiral"));
  }
  if (m.has_curve()) {
    const auto& c = m.curve();
    std::vector<Vec2> points;
    for (const auto& p : c.points()) points.push_back(to_vec2(p));
    return whole(
        sampled(scene, spline_curve(points, c.has_degree() ? c.degree() : 3, c.closed()), d, field + ".curve"));
  }
  std::vector<Vec2> points = polyline(scene, m, d, field);
  scene.check(
      points.front() != points.back() || encloses_a_point(model, points), field,
      "goes round no Gauss point of the shell, whose spacing is {:.3g} m: nothing would come off; take a larger "
      "one, or more elements",
      d.spacing);
  return whole(std::move(points));
}

}  // namespace sunder::shell
