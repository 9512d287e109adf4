#include "shell/solver/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "shell/geometry/edges.h"
#include "shell/mechanics/principal.h"

namespace sunder::shell {
namespace {

constexpr double kFar = 1e30;          // no end [m]
constexpr double kSpare = 1.25;        // of a radius that is asked for: a little more saves another look at all edges
constexpr double kWhole = 1.0 - 1e-6;  // of a radius: the result must not depend on edges further off

// Lengths from a flaw along zone_ways() to the end of its energy-release zone [m].
using Rays = std::array<float, EnergyReleaseZone::kWays>;

const std::array<Vec2, EnergyReleaseZone::kWays>& zone_ways() {
  static const auto ways = [] {
    std::array<Vec2, EnergyReleaseZone::kWays> w;
    for (int k = 0; k < EnergyReleaseZone::kWays; ++k)
      w[k] = turned(Vec2(1, 0), 2.0 * std::numbers::pi / EnergyReleaseZone::kWays * (k + 0.5));
    return w;
  }();
  return ways;
}

// A segment from a to b as seen from the origin.
struct Line {
  Line(const Vec2& a, const Vec2& b) : along((b - a).normalized()), across(-along.y(), along.x()) {
    if (across.dot(a) < 0.0) across = -across;
    away = across.dot(a), first = along.dot(a), last = along.dot(b);
  }
  Vec2 along, across;        // unit vectors; across: away from the origin
  double away, first, last;  // [m]
};

// Ends rays where they meet a cut.
void end_at_cut(const Vec2& a, const Vec2& b, Rays& rays) {
  const Line line(a, b);
  for (int k = 0; k < EnergyReleaseZone::kWays; ++k) {
    const double towards = line.across.dot(zone_ways()[k]), end = line.away / towards;
    const double foot = end * line.along.dot(zone_ways()[k]);
    if (towards > 0.0 && foot >= line.first && foot <= line.last) rays[k] = std::min(rays[k], static_cast<float>(end));
  }
}

// Ends rays where they become nearer to a crack than to the origin. The region nearer to the origin is convex, so a ray
// leaves it once: where it is as near to the line, if its foot is on the segment, else as near to the end beyond which
// the foot is.
void end_at_crack(const Vec2& a, const Vec2& b, Rays& rays) {
  const Line line(a, b);
  for (int k = 0; k < EnergyReleaseZone::kWays; ++k) {
    const Vec2& way = zone_ways()[k];
    double end = line.away / std::max(1.0 + line.across.dot(way), 1e-12);
    const double foot = end * line.along.dot(way);
    if (!(foot >= line.first && foot <= line.last)) {
      const Vec2& tip = foot < line.first ? a : b;
      const double ahead = tip.dot(way);
      end = ahead > 0.0 ? 0.5 * tip.squaredNorm() / ahead : kFar;
    }
    rays[k] = std::min(rays[k], static_cast<float>(end));
  }
}

// Edges from `first` on that can stand between points within `radius` of p, each once, without `skip`.
const std::vector<int>& edges_around(const CrackGraph& cracks, const Vec2& p, double radius, int skip, int first) {
  thread_local std::vector<int> found;
  found.clear();
  const Vec2 low = p - Vec2::Constant(radius), high = p + Vec2::Constant(radius);
  cracks.near_since(low, high, first, [&](int e) {
    const CrackEdge& c = cracks.edges()[e];
    if (e != skip && (c.long_a.cwiseMin(c.long_b).array() <= high.array()).all() &&
        (c.long_a.cwiseMax(c.long_b).array() >= low.array()).all())
      found.push_back(e);
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

ControlGrid control_grid(const ShellModel& m) {
  return {m.tables.columns, m.tables.rows, &m.parameter,
          m.spacing_u,      m.spacing_v,   m.trim.empty() ? nullptr : &m.trim.absent};
}

Visibility first_visibility(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v) {
  const ControlGrid grid = control_grid(m);
  Visibility out(grid, p, span_u, span_v);
  out.update(grid, cracks, cracks.trims());
  return out;
}

void note_uses(const ShellModel& m, const std::vector<GatheredFunction>& functions, Visibility& uses) {
  uses.close();
  for (const GatheredFunction& f : functions) uses.show(control_grid(m), m.tables.control_point(f.slot));
}

std::size_t most_bytes_seen(const ShellModel& m, double radius) {
  const double side = (2.0 * radius / m.spacing + 1.0) * m.tables.gauss;  // side of a square, in Gauss points
  return static_cast<std::size_t>(side * side) * sizeof(Neighbours::Seen);
}

const std::vector<SeenPoint>& Surroundings::seen(const ShellModel& m, const CrackGraph& cracks, const Look& look) {
  const int end = static_cast<int>(cracks.edges().size());
  const bool again = look == look_;
  if (again && known_ == end) return points_;
  const Vec2 eye = look.p + kEyeAhead * m.spacing * look.direction;
  const std::vector<int>& between = edges_around(cracks, look.p, look.radius, look.edge, again ? known_ : 0);
  const auto hidden = [&](const Vec2& q) {
    return std::any_of(between.begin(), between.end(), [&](int e) {
      return segments_meet(eye, q, cracks.edges()[e].long_a, cracks.edges()[e].long_b);
    });
  };
  if (again) {
    if (!between.empty()) std::erase_if(points_, [&](const SeenPoint& q) { return hidden(look.p + q.offset); });
  } else {
    points_.clear();
    const Vec2& ahead = look.direction;
    points_within(m, look.p, look.radius, 1, 1, [&](int block, int lane, const Vec2& d, double /*area*/) {
      const double angle = ahead.isZero(0.0) ? 0.0 : std::atan2(ahead.x() * d.y() - ahead.y() * d.x(), ahead.dot(d));
      if (std::abs(angle) > kFlankAngle || hidden(look.p + d)) return;
      const double weight = std::exp(-kRadialFall * d.squaredNorm() / (look.radius * look.radius));
      const bool one_way = !ahead.isZero(0.0);
      points_.push_back({block, lane, d, angle, weight, one_way ? weight * wedge(angle) : 0.0,
                         one_way ? wedge_tilt(angle, kTurnStep) : 0.0});
    });
  }
  look_ = look, known_ = end;
  return points_;
}

const std::vector<Neighbours::Seen>& Neighbours::seen(const ShellModel& m, const CrackGraph& cracks, const Vec2& p,
                                                      double radius) {
  const int end = static_cast<int>(cracks.edges().size());
  if (radius == radius_ && known_ == end) return points_;
  if (radius == radius_) {
    const std::vector<int>& between = edges_around(cracks, p, radius, -1, known_);
    const auto hidden = [&](const Seen& q) {
      const Vec2 to = p + (gauss_point(m.patch, m.tables, q.block, q.lane).parameter - p);
      return std::any_of(between.begin(), between.end(), [&](int e) {
        return segments_meet(p, to, cracks.edges()[e].long_a, cracks.edges()[e].long_b);
      });
    };
    if (!between.empty()) std::erase_if(points_, hidden);
  } else {
    Surroundings all;
    points_.clear();
    for (const SeenPoint& q : all.seen(m, cracks, {p, radius})) points_.push_back({q.block, q.lane, q.weight});
    points_.shrink_to_fit();
  }
  radius_ = radius, known_ = end;
  return points_;
}

double EnergyReleaseZone::share(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, double radius) {
  if (radius > asked_) {
    asked_ = kSpare * radius, known_ = 0;
    const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
    const auto border = [&](int edge, double at) {
      return (m.joined & edge) ? (edge == kUMin || edge == kVMin ? -kFar : kFar) : at;
    };
    const Vec2 low(border(kUMin, ku.begin() - p.x()), border(kVMin, kv.begin() - p.y()));
    const Vec2 high(border(kUMax, ku.end() - p.x()), border(kVMax, kv.end() - p.y()));
    for (int k = 0; k < kWays; ++k) {
      const Vec2& way = zone_ways()[k];
      const Vec2 end = (way.array() > 0.0).select(high, low).array() / way.array();
      rays_[k] = static_cast<float>(std::max(0.0, end.minCoeff()));
    }
  }
  const int end = static_cast<int>(cracks.edges().size());
  if (known_ < end) {  // an edge may come twice
    const Vec2 far = Vec2::Constant(2.0 * asked_);
    cracks.near_since(p - far, p + far, known_, [&](int e) {
      const CrackEdge& c = cracks.edges()[e];
      if (c.crack == CrackEdge::kTiedTrim) return;
      if (c.face == 0)
        end_at_cut(c.long_a - p, c.long_b - p, rays_);
      else
        end_at_crack(c.a - p, c.b - p, rays_);
    });
  }
  known_ = end;
  double own = 0.0;
  for (const float ray : rays_) {
    const double part = ray / radius;
    own += part < kWhole ? part * part : 1.0;
  }
  return own / kWays;
}

bool EnergyReleaseZone::holds(const Vec2& offset) const {
  // its sector, by quadrant: this is called too often for an arc tangent
  static_assert(kWays == 16);
  static const double first = std::tan(std::numbers::pi / 8.0);
  double x = offset.x(), y = offset.y();
  int way = 0;
  for (; way < kWays && !(x > 0.0 && y >= 0.0); way += kWays / 4) x = std::exchange(y, -x);
  way += y >= x ? (first * y >= x ? 3 : 2) : (y >= first * x ? 1 : 0);
  const double ray = rays_[way % kWays];
  return offset.squaredNorm() <= ray * ray;
}

const std::vector<SeenEdge>& NearCracks::seen(const CrackGraph& cracks, const Vec2& p, double reach, double clearance,
                                              double parallel) {
  const int end = static_cast<int>(cracks.edges().size());
  const Vec2 pad = Vec2::Constant(reach);
  bool changed = false;  // new edges may hide old ones
  if (known_ < end) cracks.near_since(p - pad, p + pad, known_, [&](int) { changed = true; });
  known_ = end;
  if (!changed) return edges_;
  thread_local std::vector<int> around;
  around.clear();
  cracks.near_since(p - pad, p + pad, 0, [](int e) { around.push_back(e); });
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  edges_.clear();
  std::vector<double> angles;  // [0, pi)
  for (const int e : around) {
    Vec2 foot;
    const double distance = cracks.distance(p, e, foot);
    if (cracks.edges()[e].crack == CrackEdge::kTiedTrim) continue;  // stress goes on beyond it
    if (distance >= reach || !cracks.visible(p, foot + kShortOfEdge * (p - foot), e)) continue;
    const CrackEdge& c = cracks.edges()[e];
    edges_.push_back({distance, foot, (c.b - c.a).normalized()});
    const Vec2& d = edges_.back().along;
    if (distance < clearance) angles.push_back(std::atan2(d.y() < 0.0 ? -d.y() : d.y(), d.y() < 0.0 ? -d.x() : d.x()));
  }
  std::sort(angles.begin(), angles.end());
  const double most = 2.0 * std::acos(parallel) - 1e-9;  // angle between two that shield all directions between them
  shield_all_ = !angles.empty() && angles.front() + std::numbers::pi - angles.back() < most;
  for (std::size_t k = 1; k < angles.size(); ++k) shield_all_ = shield_all_ && angles[k] - angles[k - 1] < most;
  return edges_;
}

}  // namespace sunder::shell
