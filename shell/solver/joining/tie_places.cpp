#include "shell/solver/joining/tie_places.h"

#include <algorithm>
#include <cmath>

#include "shell/fracture/constants.h"
#include "shell/fracture/mls.h"
#include "shell/solver/model.h"
#include "shell/solver/surroundings.h"

namespace sunder::shell {
namespace {

constexpr double kSameWeight = 1e-9;  // of hats: round-off
/// [-]: least number of hat functions on a seam that goes round.
/// numerical: of two, each would meet the other on both sides
constexpr int kFewestClosed = 3;
constexpr double kReach = kLargestSupport + 1.0;  // beyond it an edge hides nothing that a place uses [spacings]

// Whether no crack stands between two points; trim loops do not count.
bool sees(const CrackGraph& cracks, const Vec2& from, const Vec2& to) {
  bool clear = true;
  cracks.near(from, to, 0.0, [&](int e) {
    const CrackEdge& c = cracks.edges()[e];
    clear = e < cracks.trims() || !segments_meet(from, to, c.long_a, c.long_b);
    return clear;
  });
  return clear;
}

// The point from which a place of the border looks: a little inside.
Vec2 eye_of(const ShellModel& m, const Vec2& p, const Vec2& into) {
  const Vec2 eye = p + kEyeInside * m.spacing * into.normalized();
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()), high(m.patch.knots_u.end(), m.patch.knots_v.end());
  if (m.trim.empty()) return eye.cwiseMax(low).cwiseMin(high);
  return m.trim.loops.contains(eye) ? eye : m.trim.loops.moved_inside(p, kEyeInside * m.spacing);
}

// Functions at `eye` continued to p by Taylor's formula, exact for polynomials of degree 2.
void continue_to(const Vec2& d, std::vector<GatheredFunction>& functions) {
  for (GatheredFunction& f : functions) {
    auto& n = f.n;
    n[0] +=
        d.x() * n[1] + d.y() * n[2] + 0.5 * d.x() * d.x() * n[3] + 0.5 * d.y() * d.y() * n[4] + d.x() * d.y() * n[5];
    n[1] += d.x() * n[3] + d.y() * n[5];
    n[2] += d.y() * n[4] + d.x() * n[5];
  }
}

bool near_edge(const ShellModel& m, const Vec2& p, const CrackEdge& e) {
  const Vec2 pad = kReach * Vec2(m.spacing_u, m.spacing_v);
  return (e.a.cwiseMin(e.b).array() <= (p + pad).array()).all() &&
         (e.a.cwiseMax(e.b).array() >= (p - pad).array()).all();
}

}  // namespace

bool Hat::same_as(const Hat& other) const {
  if (places != other.places) return false;
  for (std::size_t k = 0; k < weights.size(); ++k)
    if (std::abs(weights[k] - other.weights[k]) > kSameWeight) return false;
  return true;
}

bool PlaceFunctions::same_as(const PlaceFunctions& other) const {
  return bends == other.bends && functions.size() == other.functions.size() &&
         std::equal(
             functions.begin(), functions.end(), other.functions.begin(),
             [](const GatheredFunction& a, const GatheredFunction& b) { return a.slot == b.slot && a.n == b.n; });
}

std::vector<Hat> hats_along(const Seam& seam, double element, const std::vector<char>& apart,
                            const std::vector<char>& detached) {
  const int places = static_cast<int>(seam.places.size());
  const int spans = std::max(seam.closed ? kFewestClosed : 1, static_cast<int>(seam.length / element));
  const int count = seam.closed ? spans : spans + 1;
  const auto ends_after = [&](int i) { return apart[i] != 0 || detached[i] != 0 || detached[(i + 1) % places] != 0; };
  int start = 0;
  bool round = seam.closed;  // no end at all
  for (int i = 0; i < places && seam.closed; ++i)
    if (ends_after(i)) start = (i + 1) % places, round = false;
  std::vector<std::map<int, Hat>> stretches(1);  // hats by their number along the stretch
  for (int k = 0; k < places; ++k) {
    const int i = (start + k) % places;
    const SeamPlace& place = seam.places[i];
    if (detached[i] == 0) {
      const double at = place.along / seam.length * spans;
      const int before = std::min(spans - 1, static_cast<int>(at)), lap = start + k >= places ? spans : 0;
      for (const int n : {before, before + 1}) {
        const double weight = place.length * (1.0 - std::abs(at - n));
        if (weight <= 0.0) continue;
        Hat& hat = stretches.back()[round ? n % count : n + lap];
        hat.places.push_back(i), hat.weights.push_back(weight);
      }
    }
    if (ends_after(i)) stretches.emplace_back();
  }
  const auto size = [](const Hat& hat) {
    double sum = 0.0;
    for (const double w : hat.weights) sum += w;
    return sum;
  };
  const double least = kLeastHat * seam.length / spans;
  std::vector<Hat> out;
  for (std::size_t part = 0; part < stretches.size(); ++part) {
    auto& stretch = stretches[part];
    double whole = 0.0;
    for (const auto& [n, hat] : stretch) whole += size(hat);
    const bool between = seam.closed ? !round : part > 0 && part + 1 < stretches.size();
    if (between && whole < kLeastStretch * seam.length / spans) continue;
    const auto merge = [&](auto small, auto into) {
      for (std::size_t k = 0; k < small->second.places.size(); ++k) {
        Hat& hat = into->second;
        const auto at = std::find(hat.places.begin(), hat.places.end(), small->second.places[k]);
        if (at == hat.places.end())
          hat.places.push_back(small->second.places[k]), hat.weights.push_back(small->second.weights[k]);
        else
          hat.weights[at - hat.places.begin()] += small->second.weights[k];
      }
      stretch.erase(small);
    };
    while (stretch.size() > 1 && !round && size(stretch.begin()->second) < least)
      merge(stretch.begin(), std::next(stretch.begin()));
    while (stretch.size() > 1 && !round && size(std::prev(stretch.end())->second) < least)
      merge(std::prev(stretch.end()), std::prev(stretch.end(), 2));
    for (auto& [n, hat] : stretch) {
      const double sum = size(hat);
      std::vector<std::pair<int, double>> sorted;
      for (std::size_t k = 0; k < hat.places.size(); ++k) sorted.emplace_back(hat.places[k], hat.weights[k] / sum);
      std::sort(sorted.begin(), sorted.end());
      Hat& own = out.emplace_back();
      own.number = n % count;
      for (const auto& [place, weight] : sorted) own.places.push_back(place), own.weights.push_back(weight);
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const Hat& a, const Hat& b) { return a.number < b.number; });
  return out;
}

PlaceFunctions place_functions(const ShellModel& m, const ShellState& s, const Vec2& p, const Vec2& into) {
  const CrackGraph& cracks = s.cracks.graph;
  const auto detached = [&](const std::vector<GatheredFunction>& functions) {
    return std::any_of(functions.begin(), functions.end(),
                       [&](const GatheredFunction& f) { return s.motion.detached[f.slot] != 0; });
  };
  PlaceFunctions out{shell_functions(m, p)};
  const Vec2 eye = eye_of(m, p, into);
  // A control point that stays outside of a loop belongs to the piece at its home.
  const bool whole = std::all_of(out.functions.begin(), out.functions.end(), [&](const GatheredFunction& f) {
    const int point = m.tables.control_point(f.slot);
    return sees(cracks, eye, m.parameter[point]) &&
           (m.trim.empty() || m.trim.home[point] == m.parameter[point] || sees(cracks, eye, m.trim.home[point]));
  });
  if (!whole) {
    const MlsPoint mls =
        mls_point(control_grid(m), cracks, eye, m.patch.knots_u.span_of(eye.x()), m.patch.knots_v.span_of(eye.y()));
    out.functions.clear();
    out.bends = mls.basis == MlsBasis::kQuadratic ? 1 : 0;
    if (mls.basis != MlsBasis::kNone)
      for (const MlsFunction& f : mls.functions) out.functions.push_back({m.tables.slot(f.control_point), f.n});
    continue_to(p - eye, out.functions);
  }
  if (detached(out.functions)) out.functions.clear();
  return out;
}

TiePlaces::TiePlaces(const Seam& seam)
    : apart_(seam.places.size(), 0), detached_(seam.places.size(), 0), changed_(seam.places.size(), 0) {}

bool TiePlaces::look(const Seam& seam, const std::vector<ShellRef>& shells, const std::vector<int>& first) {
  const int places = static_cast<int>(seam.places.size());
  std::fill(changed_.begin(), changed_.end(), 0);
  bool any = false;
  for (const bool one : {true, false}) {
    const int shell = one ? seam.first : seam.second;
    const ShellModel& m = *shells[shell].model;
    const ShellState& s = *shells[shell].state;
    const std::vector<CrackEdge>& edges = s.cracks.graph.edges();
    const auto parameter = [&](int i) -> const Vec2& { return one ? seam.places[i].first : seam.places[i].second; };
    const auto into = [&](int i) -> const Vec2& {
      return one ? seam.places[i].into_first : seam.places[i].into_second;
    };
    for (int i = 0; i < places; ++i) {
      const bool near = std::any_of(edges.begin() + first[shell], edges.end(),
                                    [&](const CrackEdge& e) { return near_edge(m, parameter(i), e); });
      if (!near || detached_[i] != 0) continue;
      PlaceFunctions now = place_functions(m, s, parameter(i), into(i));
      if (now.functions.empty()) detached_[i] = 1, any = true;
      const std::pair<int, int> key(i, one ? 0 : 1);
      const auto known = cracked_.find(key);
      const bool differs =
          known != cracked_.end() ? !known->second.same_as(now) : !now.same_as({shell_functions(m, parameter(i))});
      if (differs) cracked_[key] = std::move(now), changed_[i] = 1, any = true;
      const int next = (i + 1) % places;
      if (apart_[i] != 0 || (next == 0 && !seam.closed)) continue;
      if (!sees(s.cracks.graph, eye_of(m, parameter(i), into(i)), eye_of(m, parameter(next), into(next))))
        apart_[i] = 1, any = true;
    }
  }
  return any;
}

PlaceFunctions TiePlaces::at(const Seam& seam, const std::vector<const ShellModel*>& shells, int i, bool first) const {
  const auto known = cracked_.find({i, first ? 0 : 1});
  if (known != cracked_.end()) return known->second;
  return {
      shell_functions(*shells[first ? seam.first : seam.second], first ? seam.places[i].first : seam.places[i].second)};
}

}  // namespace sunder::shell
