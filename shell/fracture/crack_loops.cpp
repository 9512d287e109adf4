#include "shell/fracture/crack_loops.h"

#include <algorithm>

#include "shell/fracture/constants.h"

namespace sunder::shell {
namespace {

double squared_distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  return (p - a - std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d).squaredNorm();
}

bool meet(const CrackEdge& e, const CrackEdge& f, double distance) {
  if (segments_meet(e.a, e.b, f.a, f.b)) return true;
  const double nearest = std::min({squared_distance(e.a, f.a, f.b), squared_distance(e.b, f.a, f.b),
                                   squared_distance(f.a, e.a, e.b), squared_distance(f.b, e.a, e.b)});
  return nearest <= distance * distance;
}

}  // namespace

bool CrackLoops::closed(const CrackGraph& cracks, const Vec2& low, const Vec2& high, double spacing) {
  constexpr int kBorder = 0;
  const double met = kLoopMet * spacing;
  const auto inside = [&](const Vec2& p) {
    return (p.array() > low.array() + met).all() && (p.array() < high.array() - met).all();
  };
  bool closed = false;
  for (int k = sets_.size() - 1; k < static_cast<int>(cracks.edges().size()); ++k) {
    const CrackEdge& e = cracks.edges()[k];
    const int own = sets_.add();
    std::vector<int> beside;
    cracks.near(e.a, e.b, met, [&](int other) {
      if (other < k) beside.push_back(other);
      return true;
    });
    std::sort(beside.begin(), beside.end());
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    const auto starts_there = [&](int other) {
      const CrackEdge& f = cracks.edges()[other];
      return f.from == e.from || f.to == e.from;
    };
    for (const int other : beside)
      if (starts_there(other)) sets_.join(other + 1, own);
    for (const int other : beside)  // one more place where they meet
      if (!starts_there(other) && meet(e, cracks.edges()[other], met)) closed |= !sets_.join(other + 1, own);
    for (const Vec2& end : {e.a, e.b})
      if (!inside(end)) closed |= !sets_.join(kBorder, own);
  }
  return closed;
}

}  // namespace sunder::shell
