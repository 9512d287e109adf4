#include "rigid/engine/rebound.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sunder::rigid {
namespace {

constexpr double kMostPull = 0.2;      // change of the closing speed by the pull in a window, as a share of it [-]
constexpr double kAtOneTime = 0.05;    // spread of the touches of a pair [of a window]
constexpr std::int64_t kSeveral = -1;  // partners

using Bodies = std::pair<std::uint32_t, std::uint32_t>;

}  // namespace

std::optional<Rebound> rebound(const Strike& s, double window_s) {
  if (!(s.restitution > 0.0 && s.approach > 0.0) || std::abs(s.pull) * window_s > kMostPull * s.approach) return {};
  const double at_start = s.approach + 0.5 * s.pull * window_s, gap = std::max(0.0, s.gap);
  const double square = at_start * at_start - 2.0 * s.pull * gap;
  if (!(square > 0.0)) return {};
  const double at_touch = std::sqrt(square), touch = 2.0 * gap / (at_start + at_touch), rest = window_s - touch;
  const double speed = s.restitution * at_touch + s.pull * rest;
  if (!(rest >= 0.0 && speed > 0.0)) return {};
  return Rebound{touch, speed};
}

std::vector<std::optional<Rebound>> rebounds(const std::vector<Strike>& strikes, double window_s,
                                             const std::function<bool(std::uint32_t)>& is_static,
                                             const std::function<bool(std::uint32_t)>& joined) {
  std::vector<std::optional<Rebound>> out(strikes.size());
  if (std::none_of(strikes.begin(), strikes.end(), [](const Strike& s) { return s.acted && s.restitution > 0.0; }))
    return out;
  std::map<std::uint32_t, std::int64_t> partners;  // of bodies that move
  const auto note = [&](std::uint32_t body, std::uint32_t other) {
    if (is_static(body)) return;
    const std::int64_t partner = joined(body) ? kSeveral : static_cast<std::int64_t>(other);
    const auto [at, first] = partners.emplace(body, partner);
    if (!first && at->second != partner) at->second = kSeveral;
  };
  for (const Strike& s : strikes)
    if (s.acted) note(s.first, s.second), note(s.second, s.first);
  const auto alone = [&](std::uint32_t body) { return is_static(body) || partners.at(body) != kSeveral; };

  struct Touches {
    double early, late;
    bool sound;
  };
  std::map<Bodies, Touches> pairs;
  for (std::size_t k = 0; k < strikes.size(); ++k) {
    const Strike& s = strikes[k];
    if (!s.acted) continue;
    if (alone(s.first) && alone(s.second)) out[k] = rebound(s, window_s);
    const double touch = out[k] ? out[k]->touch : 0.0;
    Touches& pair = pairs.try_emplace(std::minmax(s.first, s.second), Touches{touch, touch, true}).first->second;
    pair = {std::min(pair.early, touch), std::max(pair.late, touch), pair.sound && out[k]};
  }
  for (std::size_t k = 0; k < strikes.size(); ++k) {
    if (!out[k]) continue;
    const Touches& pair = pairs.at(std::minmax(strikes[k].first, strikes[k].second));
    if (pair.sound && pair.late - pair.early <= kAtOneTime * window_s)
      out[k]->touch = pair.late;
    else
      out[k].reset();
  }
  return out;
}

}  // namespace sunder::rigid
