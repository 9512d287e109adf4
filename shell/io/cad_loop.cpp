#include "shell/io/cad_loop.h"

#include <cmath>

#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

constexpr int kArcPieces = 8;              // of an arc between two corners, by which its area over the chord is found
constexpr double kStraight = 1e-9;         // area over the chord, of the squared spacing, that counts as none
constexpr double kSmoothJoint = 0.02;      // angle between borders up to which their joint may move [rad]
constexpr std::size_t kFewestCorners = 8;  // of a loop of arcs
constexpr int kAreaSteps = 3;              // corrections of the corners: each leaves the square of the error
constexpr double kJointStep = 1e-3;        // of a border, over which its direction at an end is taken

// Area between the arc from t0 to t1 and its chord, positive to the right of the chord.
double area_over_chord(const PlaneCurve& curve, double t0, double t1) {
  const Vec2 origin = curve.at(t0);
  const auto polygon = [&](int pieces) {
    double sum = 0.0;
    Vec2 before = Vec2::Zero();
    for (int i = 1; i <= pieces; ++i) {
      const Vec2 now = curve.at(t0 + (t1 - t0) * i / pieces) - origin;
      sum += 0.5 * cross(before, now), before = now;
    }
    return sum;
  };
  const double fine = polygon(kArcPieces);  // its error falls with the square of the number of pieces
  return fine + (fine - polygon(kArcPieces / 2)) / 3.0;
}

// The sides of a patch on which borders run.
struct Sides {
  Vec2 low, high;
  explicit Sides(const Patch& p) : low(p.knots_u.begin(), p.knots_v.begin()), high(p.knots_u.end(), p.knots_v.end()) {}
  Vec2 moved(Vec2 p, int sides) const {
    p = p.cwiseMax(low).cwiseMin(high);
    if (sides & kUMin) p.x() = low.x();
    if (sides & kUMax) p.x() = high.x();
    if (sides & kVMin) p.y() = low.y();
    if (sides & kVMax) p.y() = high.y();
    return p;
  }
};

// A corner, and the arc from it to the next corner.
struct Corner {
  Vec2 at;
  double area = 0.0;  // between the arc that follows and its chord
  int sides = 0;      // on which the corner lies
  bool moves = true;
};

double angle_between(const PlaneCurve& in, const PlaneCurve& out) {
  const Vec2 a = in.at(1.0) - in.at(1.0 - kJointStep), b = out.at(kJointStep) - out.at(0.0);
  return std::abs(std::atan2(cross(a, b), a.dot(b)));
}

std::vector<Corner> corners_of(const CadLoop& loop, const Sides& sides, double spacing) {
  std::vector<Corner> out;
  for (std::size_t k = 0; k < loop.borders.size(); ++k) {
    const auto& [curve, on] = loop.borders[k];
    const auto& [before, on_before] = loop.borders[(k + loop.borders.size() - 1) % loop.borders.size()];
    std::vector<double> t = crack_parameters(curve, spacing);
    const auto bent = [&](double a, double b) { return on == 0 ? area_over_chord(curve, a, b) : 0.0; };
    // A short arc gets corners that can make up for its bend, and a small loop enough of them.
    const std::size_t least =
        std::max<std::size_t>(2, (kFewestCorners + loop.borders.size() - 1) / loop.borders.size());
    if (t.size() <= least && std::abs(bent(0.0, 0.5)) + std::abs(bent(0.5, 1.0)) > kStraight * spacing * spacing) {
      t.clear();
      for (std::size_t i = 0; i <= least; ++i) t.push_back(static_cast<double>(i) / static_cast<double>(least));
    }
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
      const int corner_on = i == 0 ? on | on_before : on;
      out.push_back({sides.moved(curve.at(t[i]), corner_on), bent(t[i], t[i + 1]), corner_on,
                     corner_on == 0 && (i > 0 || angle_between(before, curve) <= kSmoothJoint)});
    }
  }
  return out;
}

double area_of(const std::vector<Corner>& c) {
  double sum = 0.0;
  for (std::size_t k = 0; k < c.size(); ++k) sum += 0.5 * cross(c[k].at - c[0].at, c[(k + 1) % c.size()].at - c[0].at);
  return sum;
}

// Moves corners along their normals until the polygon has the area of the loop. Each makes up for the arcs beside it.
void keep_area(std::vector<Corner>& c, const Sides& sides, double spacing) {
  const std::size_t n = c.size();
  double wanted = area_of(c);
  for (const Corner& corner : c) wanted += corner.area;
  std::vector<double> most(n, 0.0);
  double all = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const Corner &before = c[(k + n - 1) % n], &after = c[(k + 1) % n];
    const double length = (c[k].at - before.at).norm() + (after.at - c[k].at).norm();
    if (c[k].moves) most[k] = (before.area + c[k].area) / std::max(length, 1e-300);
    all += std::abs(before.area) + std::abs(c[k].area);
  }
  if (all <= kStraight * spacing * spacing) return;
  for (int step = 0; step < kAreaSteps; ++step) {
    const std::vector<Corner> from = c;
    double change = 0.0, scale = 0.0;  // area that these moves, or their sizes, would add
    for (std::size_t k = 0; k < n; ++k) {
      const double length = (from[(k + 1) % n].at - from[(k + n - 1) % n].at).norm();
      change += 0.5 * length * most[k], scale += 0.5 * length * std::abs(most[k]);
    }
    if (scale == 0.0) return;
    const double missing = wanted - area_of(from) - (step == 0 ? change : 0.0);
    for (std::size_t k = 0; k < n; ++k) {
      const Vec2 along = (from[(k + 1) % n].at - from[(k + n - 1) % n].at).normalized();
      const double move = (step == 0 ? most[k] : 0.0) + missing / scale * std::abs(most[k]);
      c[k].at = sides.moved(from[k].at + move * Vec2(along.y(), -along.x()), c[k].sides);  // to the right
    }
  }
}

}  // namespace

std::vector<CadLoop> scaled_loops(const std::vector<CadLoop>& loops, const Patch& from, const Patch& to) {
  const Sides a(from), b(to);
  const Vec2 scale = (b.high - b.low).cwiseQuotient(a.high - a.low);
  std::vector<CadLoop> out = loops;
  for (CadLoop& loop : out)
    for (CadBorder& border : loop.borders) {
      const PlaneCurve before = border.curve;
      border.curve.at = [before, a, b, scale](double t) {
        return b.moved(b.low + scale.cwiseProduct(before.at(t) - a.low), 0);
      };
      border.curve.length *= scale.maxCoeff();
    }
  return out;
}

TrimLoop cad_loop(const CadLoop& loop, const Patch& patch, double spacing) {
  const Sides sides(patch);
  std::vector<Corner> corners = corners_of(loop, sides, spacing);
  keep_area(corners, sides, spacing);
  TrimLoop out{{}, loop.hole, {}};
  for (const Corner& corner : corners) out.points.push_back(corner.at);
  out.points.push_back(out.points.front());
  for (const CadBorder& border : loop.borders) out.curves.push_back(border.curve);
  return out;
}

}  // namespace sunder::shell
