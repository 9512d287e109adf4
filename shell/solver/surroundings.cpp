#include "shell/solver/surroundings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "shell/mechanics/principal.h"

namespace sunder::shell {
namespace {

constexpr double kEye = 0.1;            // spacings ahead of the middle
constexpr double kBeforeAnEdge = 0.02;  // of the distance from it: one that is seen to there is seen

constexpr int kWays = 16, kRings = 4;  // of samples of the ground about a point
constexpr double kRung = 0.1;          // between radii that are told apart, of them

// Of the unit circle, each at the middle of an equal area.
const std::array<Vec2, kWays * kRings>& ground_samples() {
  static const auto samples = [] {
    std::array<Vec2, kWays * kRings> s;
    for (int k = 0; k < kWays * kRings; ++k)
      s[k] = std::sqrt((k / kWays + 0.5) / kRings) *
             turned(Vec2(1, 0), 2.0 * std::numbers::pi / kWays * (k % kWays + 0.5));
    return s;
  }();
  return samples;
}

// Calls f(block, lane, offset from p) for each Gauss point within the radius.
template <class F>
void points_within(const ShellModel& m, const Vec2& p, double radius, F&& f) {
  const RowTables& t = m.tables;
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  for (int j = kv.span_of(p.y() - radius); j <= kv.span_of(p.y() + radius); ++j)
    for (int i = ku.span_of(p.x() - radius); i <= ku.span_of(p.x() + radius); ++i)
      for (int sub = 0; sub < t.gauss * t.gauss; ++sub) {
        const int block = j * t.gauss * t.gauss + sub;
        const Vec2 d = gauss_point(m.patch, t, block, i).parameter - p;
        if (d.squaredNorm() <= radius * radius) f(block, i, d);
      }
}

// Edges from `first` on that can stand between points within `radius` of p, each once, but `skip`.
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

std::size_t most_bytes_seen(const ShellModel& m, double radius) {
  const double side = (2.0 * radius / m.spacing + 1.0) * m.tables.gauss;  // of a square, in Gauss points
  return static_cast<std::size_t>(side * side) * sizeof(SeenPoint);
}

const std::vector<SeenPoint>& Surroundings::seen(const ShellModel& m, const CrackGraph& cracks, const Look& look) {
  const int end = static_cast<int>(cracks.edges().size());
  const bool again = look == look_;
  if (again && known_ == end) return points_;
  const Vec2 eye = look.p + kEye * m.spacing * look.direction;
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
    points_within(m, look.p, look.radius, [&](int block, int lane, const Vec2& d) {
      const double angle = ahead.isZero(0.0) ? 0.0 : std::atan2(ahead.x() * d.y() - ahead.y() * d.x(), ahead.dot(d));
      if (std::abs(angle) > kBeside || hidden(look.p + d)) return;
      const double weight = std::exp(-2.0 * d.squaredNorm() / (look.radius * look.radius));
      const bool one_way = !ahead.isZero(0.0);
      points_.push_back({block, lane, d, angle, weight, one_way ? weight * wedge(angle) : 0.0,
                         one_way ? wedge_tilt(angle, kTurnStep) : 0.0});
    });
  }
  look_ = look, known_ = end;
  return points_;
}

double OwnGround::share(const ShellModel& m, const CrackGraph& cracks, const Vec2& p, double radius) {
  static_assert(kWays * kRings == 64);
  const auto& samples = ground_samples();
  const auto left_of = [](std::uint64_t owned, int k) { return owned & ~(std::uint64_t{1} << k); };
  // on a ladder, so that nothing depends on which radius was asked for before
  const double rung = std::exp(kRung * std::round(std::log(radius) / kRung));
  if (rung != radius_) {
    radius_ = rung, known_ = 0, owned_ = ~std::uint64_t{0};
    for (int k = 0; k < 64; ++k)
      if (!m.patch.contains(p + radius_ * samples[k])) owned_ = left_of(owned_, k);
  }
  const int end = static_cast<int>(cracks.edges().size());
  if (owned_ != 0 && known_ < end)
    for (const int e : edges_around(cracks, p, 2.0 * radius_, -1, known_))
      for (std::uint64_t left = owned_; left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        const Vec2 offset = radius_ * samples[k];
        Vec2 foot;
        if (cracks.distance(p + offset, e, foot) < offset.norm()) owned_ = left_of(owned_, k);
      }
  known_ = end;
  return std::popcount(owned_) / 64.0;
}

const std::vector<SeenEdge>& NearCracks::seen(const CrackGraph& cracks, const Vec2& p, double reach, double clearance,
                                              double parallel) {
  const int end = static_cast<int>(cracks.edges().size());
  const Vec2 pad = Vec2::Constant(reach);
  bool changed = false;  // what is new may also hide what is not
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
    if (distance >= reach || !cracks.visible(p, foot + kBeforeAnEdge * (p - foot), e)) continue;
    const CrackEdge& c = cracks.edges()[e];
    edges_.push_back({distance, foot, (c.b - c.a).normalized()});
    const Vec2& d = edges_.back().along;
    if (distance < clearance) angles.push_back(std::atan2(d.y() < 0.0 ? -d.y() : d.y(), d.y() < 0.0 ? -d.x() : d.x()));
  }
  std::sort(angles.begin(), angles.end());
  const double most = 2.0 * std::acos(parallel) - 1e-9;  // between two that shield all between them
  shield_all_ = !angles.empty() && angles.front() + std::numbers::pi - angles.back() < most;
  for (std::size_t k = 1; k < angles.size(); ++k) shield_all_ = shield_all_ && angles[k] - angles[k - 1] < most;
  return edges_;
}

}  // namespace sunder::shell
