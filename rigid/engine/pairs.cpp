#include "rigid/engine/pairs.h"

#include <algorithm>
#include <cstring>

#include "coupler/core/error.h"
#include "rigid/engine/checks.h"
#include "rigid/engine/touch.h"

namespace sunder::rigid {
namespace {

/// Points nearer than this are contacts at any velocity, so that a body at rest on four corners is held at all four.
constexpr double kNear_m = 1e-3;

struct Placed {
  std::vector<Hull> parts;  // in world coordinates
  Vec3 low, high;           // box around the body's motion in the window [m]
};

Placed placed(const Mover& m, double window_s) {
  Placed p;
  p.low = Vec3::Constant(1e300);
  p.high = -p.low;
  for (const Hull& local : m.shape->parts) {
    place(local, m.body->motion, p.parts.emplace_back());
    for (const Vec3& x : p.parts.back().points) {
      p.low = p.low.cwiseMin(x - Vec3::Constant(local.radius));
      p.high = p.high.cwiseMax(x + Vec3::Constant(local.radius));
    }
  }
  const Vec3 sweep = window_s * (m.velocity.cwiseAbs() + Vec3::Constant(m.spin.norm() * m.shape->reach)) +
                     Vec3::Constant(0.5 * kNear_m);
  p.low -= sweep;
  p.high += sweep;
  return p;
}

/// True where the spheres around two bodies come near one another in the window. It limits the tangential motion of
/// corners, which is too large for a body that turns far in a window.
bool come_together(const Mover& a, const Mover& b, double window_s) {
  const Vec3 apart = a.body->motion.position - b.body->motion.position;
  const Vec3 travel = window_s * (a.velocity - b.velocity);
  if (b.shape->is_half_space) {
    const Vec3 up = b.body->motion.orientation * Vec3::UnitZ();
    return up.dot(apart) + std::min(0.0, up.dot(travel)) <= a.shape->reach + kNear_m;
  }
  const double way = travel.squaredNorm();
  const double when = way > 0.0 ? std::min(1.0, std::max(0.0, -apart.dot(travel) / way)) : 0.0;
  return (apart + when * travel).norm() <= a.shape->reach + b.shape->reach + kNear_m;
}

/// Pairs of movers whose boxes overlap, by ascending index, without pairs of two static bodies.
std::vector<std::pair<int, int>> overlapping(const std::vector<Mover>& movers, const std::vector<Placed>& boxes) {
  std::vector<int> by_x;
  for (std::size_t i = 0; i < movers.size(); ++i)
    if (!movers[i].shape->is_half_space) by_x.push_back(static_cast<int>(i));
  std::sort(by_x.begin(), by_x.end(),
            [&](int a, int b) { return std::make_pair(boxes[a].low.x(), a) < std::make_pair(boxes[b].low.x(), b); });
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < by_x.size(); ++i)
    for (std::size_t k = i + 1; k < by_x.size() && boxes[by_x[k]].low.x() <= boxes[by_x[i]].high.x(); ++k) {
      const int a = std::min(by_x[i], by_x[k]), b = std::max(by_x[i], by_x[k]);
      if (movers[a].body->is_static && movers[b].body->is_static) continue;
      if ((boxes[a].low.array() <= boxes[b].high.array()).all() &&
          (boxes[b].low.array() <= boxes[a].high.array()).all())
        pairs.emplace_back(a, b);
    }
  for (std::size_t f = 0; f < movers.size(); ++f)
    for (std::size_t i = 0; i < movers.size() && movers[f].shape->is_half_space; ++i)
      if (!movers[i].body->is_static) pairs.emplace_back(std::min(i, f), std::max(i, f));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// What saved state begins with.
std::string caches_begin(const std::string& engine) { return "sunder-" + engine + "-1"; }

}  // namespace

void Pairs::set_contact_laws(const std::vector<ContactLaw>& laws) {
  laws_.clear();
  for (const ContactLaw& law : laws) laws_[ordered(law.first_group, law.second_group)] = law;
}

void Pairs::leave_out(BodyId a, BodyId b) { left_out_.insert(ordered(a, b)); }
bool Pairs::left_out(BodyId a, BodyId b) const { return left_out_.count(ordered(a, b)) > 0; }

const ContactLaw& Pairs::law(const RigidBody& a, const RigidBody& b) const {
  const auto found = laws_.find(ordered(a.contact_group, b.contact_group));
  return found == laws_.end() ? other_pairs_ : found->second;
}

double Pairs::allowance(const Pair& pair, double depth) const {
  const auto known = allowances_.find(pair);
  if (known != allowances_.end()) return std::max(0.0, std::min(known->second, depth));
  return seen_.count(pair.first) && seen_.count(pair.second) ? 0.0 : std::max(0.0, depth);
}

std::vector<Meeting> Pairs::find(double window_s, const std::vector<Mover>& movers) const {
  std::vector<Placed> boxes;
  boxes.reserve(movers.size());
  for (const Mover& m : movers) boxes.push_back(placed(m, window_s));
  std::vector<Meeting> meetings;
  std::vector<Touch> touches;
  for (auto [a, b] : overlapping(movers, boxes)) {
    if (left_out(movers[a].id, movers[b].id)) continue;
    if (movers[a].body->is_static) std::swap(a, b);
    const Mover &first = movers[a], &second = movers[b];
    if (!come_together(first, second, window_s)) continue;
    const BodyMotion &at_first = first.body->motion, &at_second = second.body->motion;
    const double reach =
        kNear_m + window_s * ((first.velocity - second.velocity).norm() + first.spin.norm() * first.shape->reach +
                              second.spin.norm() * second.shape->reach);
    touches.clear();
    for (const Hull& part : boxes[a].parts) {
      if (second.shape->is_half_space) {
        const Vec3 up = at_second.orientation * Vec3::UnitZ();
        touch_half_space(part, up, up.dot(at_second.position), reach, touches);
      }
      for (const Hull& other : boxes[b].parts) touch_hulls(part, other, reach, touches);
    }
    double depth = 0.0;
    for (const Touch& t : touches) depth = std::max(depth, -t.gap);
    const double allowed = allowance(ordered(first.id, second.id), depth);
    for (const Touch& t : touches) {
      const Vec3 closing = second.velocity + second.spin.cross(t.second - at_second.position) - first.velocity -
                           first.spin.cross(t.first - at_first.position);
      const double approach = closing.dot(t.normal), gap = t.gap + allowed;
      if (gap > kNear_m + window_s * std::max(0.0, approach)) continue;
      meetings.push_back({a, b, at_first.orientation.conjugate() * (t.first - at_first.position),
                          at_second.orientation.conjugate() * (t.second - at_second.position), t.normal, gap, approach,
                          allowed, &law(*first.body, *second.body)});
    }
  }
  return meetings;
}

void Pairs::remember(const std::vector<Mover>& movers, const std::vector<Meeting>& meetings) {
  std::map<Pair, double> next;  // a pair that has separated has no allowance any more
  for (const Meeting& m : meetings)
    if (m.allowance > 0.0) next[ordered(movers[m.first].id, movers[m.second].id)] = m.allowance;
  allowances_ = std::move(next);
  for (const Mover& m : movers) seen_.insert(m.id);
}

std::string Pairs::save() const {
  std::string bytes = caches_begin(engine_);
  put(bytes, static_cast<std::uint64_t>(seen_.size()));
  for (const BodyId id : seen_) put(bytes, id);
  put(bytes, static_cast<std::uint64_t>(allowances_.size()));
  for (const auto& [pair, depth] : allowances_) put(bytes, pair.first), put(bytes, pair.second), put(bytes, depth);
  return bytes;
}

void Pairs::restore(const std::string& caches, const std::set<BodyId>& known) {
  const auto reject_state = [&](const std::string& what) {
    throw Error(Exit::kBadInput, "bad_state", fmt::format("caches of the {} engine: {}", engine_, what));
  };
  const std::string begin = caches_begin(engine_);
  if (caches.compare(0, begin.size(), begin) != 0) reject_state("do not begin as this engine's do");
  std::size_t at = begin.size();
  const auto get = [&](auto value) {
    if (caches.size() - at < sizeof(value)) reject_state(fmt::format("end after {} bytes", caches.size()));
    std::memcpy(&value, caches.data() + at, sizeof(value));
    at += sizeof(value);
    return value;
  };
  const auto body = [&] {
    const auto id = get(BodyId{});
    if (!known.count(id)) reject_state(fmt::format("name body {}, which there is not", id));
    return id;
  };
  std::set<BodyId> seen;
  for (auto n = get(std::uint64_t{}); n > 0; --n) seen.insert(body());
  std::map<Pair, double> allowances;
  for (auto n = get(std::uint64_t{}); n > 0; --n) {
    const BodyId a = body(), b = body();
    const double depth = get(0.0);
    if (!(a < b) || !(depth > 0.0 && depth < 1e3))
      reject_state(fmt::format("bodies {} and {} overlap by {} m", a, b, depth));
    allowances[{a, b}] = depth;
  }
  if (at != caches.size()) reject_state(fmt::format("{} bytes too many", caches.size() - at));
  seen_ = std::move(seen);
  allowances_ = std::move(allowances);
}

}  // namespace sunder::rigid
