#include "rigid/engine/window.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "rigid/engine/at_touch.h"
#include "rigid/engine/checks.h"
#include "rigid/engine/rebound.h"
#include "rigid/engine/way_back.h"

namespace sunder::rigid {
namespace {

/// Contacts that close more slowly do not bounce: a resting body closes with g H per window.
constexpr double kImpactSpeed = 0.05;  // [m/s]
/// Overlap that stays, and the share of the rest that a window removes by moving poses.
constexpr double kSlack_m = 5e-6;
constexpr double kPushShare = 0.2;  // [-]
/// Share of the joints' error that a window removes. With all of it a body on a joint moves along the chord of its arc,
/// and the second solve turns the velocity without a change of magnitude. With less it would lose energy of order
/// (|w| H)^2 in every window.
constexpr double kJointShare = 1.0;  // [-]

/// Orientation after h seconds of free flight; `spin`: angular velocity at the start [rad/s].
Quat free_turn(RigidBody body, const Vec3& spin, double h) {
  body.motion.angular_momentum = body.apply_inertia(spin);
  body.drift(h);
  return body.motion.orientation;
}

/// Bodies during a window, with the movers' indices.
class Transit {
 public:
  Transit(VelocitySolver& solver, double window_s, const std::vector<Mover>& movers,
          const std::vector<const BodyMotion*>& ends, std::vector<Meeting> meetings, std::vector<SolverJoint> joints,
          const Beside& beside)
      : solver_(solver),
        h_(window_s),
        movers_(movers),
        meetings_(std::move(meetings)),
        joints_(std::move(joints)),
        beside_(beside),
        acted_(meetings_.size()),
        solved_(movers.size()),
        relaxed_(movers.size()) {
    auto next = ends.begin();
    for (const Mover& m : movers_) {
      ends_.push_back(*m.body);
      if (!m.body->is_static) ends_.back().motion = **next++;
      given_.push_back(ends_.back().motion);
    }
  }

  /// Takes the window. Returns the bodies at its end.
  const std::vector<RigidBody>& run() {
    if (meetings_.empty() && joints_.empty()) return ends_;
    if (solve()) push(), relax(), fly_on();
    return ends_;
  }

 private:
  /// Fills the solver's bodies with make(index); static bodies have no slot.
  template <class Make>
  void gather(Make make) {
    slots_.assign(movers_.size(), -1);
    solver_bodies_.clear();
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (movers_[i].body->is_static) continue;
      slots_[i] = static_cast<int>(solver_bodies_.size());
      solver_bodies_.push_back(make(i));
    }
  }
  SolverBody at(std::size_t i, const BodyMotion& pose, const Vec3& velocity, const Vec3& spin) const {
    const RigidBody& b = *movers_[i].body;
    return {b.mass, b.principal_inertia, pose.position, pose.orientation, velocity, spin};
  }
  bool is_ball(int i) const { return std::holds_alternative<SphereShape>(movers_[i].body->shape); }
  /// A contact's point. That of a ball does not turn with it.
  Vec3 point(int i, const Vec3& local, bool at_end) const {
    const BodyMotion &start = movers_[i].body->motion, &m = at_end ? ends_[i].motion : start;
    return m.position + (is_ball(i) ? start : m).orientation * local;
  }
  double gap_at_end(const Meeting& m) const {
    return m.normal.dot(point(m.first, m.first_point, true) - point(m.second, m.second_point, true)) + m.allowance;
  }
  /// The same at another pose. That of a ball is on the normal through its centre, on the side `side`.
  Vec3 point_at(int i, const Vec3& local, const BodyMotion& pose, const Vec3& normal, double side) const {
    const auto* ball = std::get_if<SphereShape>(&movers_[i].body->shape);
    return ball ? Vec3(pose.position + side * ball->radius * normal) : Vec3(pose.position + pose.orientation * local);
  }
  /// The one point of both bodies at which a contact acts.
  Vec3 contact_point(const Meeting& m, const Vec3& one, const Vec3& other) const {
    return is_ball(m.first) ? one : is_ball(m.second) ? other : Vec3(0.5 * (one + other));
  }
  SolverContact contact(const Meeting& m, bool at_end, double friction, double target) const {
    const Vec3 one = point(m.first, m.first_point, at_end), other = point(m.second, m.second_point, at_end);
    return {slots_[m.first], slots_[m.second], contact_point(m, one, other), m.normal, friction, target, false};
  }
  std::vector<SolverJoint> joints() const {
    std::vector<SolverJoint> all = joints_;
    for (SolverJoint& j : all) j.first = slots_[j.first], j.second = j.second < 0 ? -1 : slots_[j.second];
    return all;
  }

  /// First solve, on the average velocities: contacts may close their gaps. False where it changes no velocity.
  bool solve() {
    gather([&](std::size_t i) { return at(i, movers_[i].body->motion, movers_[i].velocity, movers_[i].spin); });
    std::vector<SolverContact> contacts;
    for (const Meeting& m : meetings_)
      contacts.push_back(contact(m, false, m.law->friction, -std::max(0.0, m.gap) / h_));
    solver_.solve(h_, kJointShare, solver_bodies_, joints(), contacts);
    for (std::size_t k = 0; k < contacts.size(); ++k) acted_[k] = contacts[k].acted;
    bool any = false;
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody& s = solver_bodies_[slots_[i]];
      const Vec3 dv = s.velocity - movers_[i].velocity, dw = s.spin - movers_[i].spin;
      if (dv.isZero(0.0) && dw.isZero(0.0)) continue;
      any = true;
      solved_[i] = {dv, dw};
      const RigidBody& start = *movers_[i].body;
      BodyMotion& end = ends_[i].motion;
      end.position += h_ * dv;
      // Turn by the difference between two free flights from the start, with and without the change of angular
      // velocity. exp(H (w + dw)) would keep w constant, and a thin shard that an impact sets spinning would gain
      // energy of order (|w| H)^2.
      const Quat without = free_turn(start, movers_[i].spin, h_), with = free_turn(start, s.spin, h_);
      end.orientation = (with * without.conjugate() * end.orientation).normalized();
      end.velocity += dv;
      end.angular_momentum += start.apply_inertia(dw);
    }
    return any;
  }

  /// Moves poses out of overlaps. Velocities do not change.
  void push() {
    const auto too_deep = [&](const Meeting& m) { return gap_at_end(m) < -kSlack_m; };
    if (std::none_of(meetings_.begin(), meetings_.end(), too_deep)) return;
    gather([&](std::size_t i) { return at(i, ends_[i].motion, Vec3::Zero(), Vec3::Zero()); });
    std::vector<SolverContact> contacts;
    for (const Meeting& m : meetings_) {
      const double gap = gap_at_end(m);
      contacts.push_back(
          contact(m, true, 0.0, gap > 0.0 ? -gap / h_ : kPushShare * std::max(0.0, -gap - kSlack_m) / h_));
    }
    solver_.solve(h_, 0.0, solver_bodies_, joints(), contacts);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody& s = solver_bodies_[slots_[i]];
      if (s.velocity.isZero(0.0) && s.spin.isZero(0.0)) continue;
      ends_[i].motion.position += h_ * s.velocity;
      ends_[i].motion.orientation = (rotation_from_vector(h_ * s.spin) * ends_[i].motion.orientation).normalized();
    }
  }

  /// Second solve, of velocities only, at the new poses. Contacts that acted or touch now do not close.
  void relax() {
    gather(
        [&](std::size_t i) { return at(i, ends_[i].motion, ends_[i].motion.velocity, ends_[i].angular_velocity()); });
    const std::vector<SolverBody> before = solver_bodies_;
    find_rebounds();
    std::vector<SolverContact> contacts;
    for (std::size_t k = 0; k < meetings_.size(); ++k) {
      const Meeting& m = meetings_[k];
      if (!acted_[k] && gap_at_end(m) > 0.0) continue;
      const bool bounces = acted_[k] && m.approach > kImpactSpeed;
      const double target = rebounds_[k] ? rebounds_[k]->speed : bounces ? m.law->restitution * m.approach : 0.0;
      contacts.push_back(contact(m, true, m.law->friction, target));
    }
    solver_.solve(h_, 0.0, solver_bodies_, joints(), contacts);
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      if (slots_[i] < 0) continue;
      const SolverBody &was = before[slots_[i]], &is = solver_bodies_[slots_[i]];
      const Vec3 dv = is.velocity - was.velocity, dw = is.spin - was.spin;
      if (dv.isZero(0.0) && dw.isZero(0.0)) continue;
      ends_[i].motion.velocity += dv;
      ends_[i].motion.angular_momentum += ends_[i].apply_inertia(dw);
      relaxed_[i] = {dv, dw};
    }
  }

  /// Mean acceleration of the predicted motion [m/s^2].
  Vec3 pull(int i) const {
    if (movers_[i].body->is_static) return Vec3::Zero();
    return 2.0 / h_ * (given_[i].velocity - movers_[i].velocity);
  }

  /// The rebounds that are sound, by meeting.
  void find_rebounds() {
    std::vector<Strike> strikes;
    for (std::size_t k = 0; k < meetings_.size(); ++k) {
      const Meeting& m = meetings_[k];
      const bool bounces = m.approach > kImpactSpeed;
      strikes.push_back({movers_[m.first].id, movers_[m.second].id, m.gap, m.approach,
                         m.normal.dot(pull(m.first) - pull(m.second)), bounces ? m.law->restitution : 0.0,
                         acted_[k] != 0});
      for (const int i : {m.first, m.second}) index_[movers_[i].id] = i;
    }
    const auto is_static = [&](BodyId id) { return movers_[index_.at(id)].body->is_static; };
    const auto joined = [&](BodyId id) {
      const int i = index_.at(id);
      return beside_.elsewhere.count(id) > 0 || std::any_of(joints_.begin(), joints_.end(), [i](const SolverJoint& j) {
               return j.first == i || j.second == i;
             });
    };
    rebounds_ = rebounds(strikes, h_, is_static, joined);
  }

  /// Two moving bodies, alone with one another, that bounce within the window.
  struct Pair {
    int first, second;
    RigidBody first_touch, second_touch;  // as they reach it
    BodyMotion first_end, second_end;
    bool turns_far = false;  // one of them, on its way back: no sweep can tell what it meets
  };
  /// Solves the rebound of meeting k at its touch, with the other contacts of the two that acted.
  Pair bounce(std::size_t k) {
    const int first = meetings_[k].first, second = meetings_[k].second;
    const auto flight = [&](int i) { return Flight{movers_[i].body, &given_[i], pull(i)}; };
    const std::optional<double> touch =
        touch_time(flight(first), flight(second), h_, meetings_[k].allowance, rebounds_[k]->touch);
    const double rest = touch ? h_ - *touch : 0.0;
    const auto at_touch = [&](int i) { return before_end(*movers_[i].body, given_[i], pull(i), rest); };
    RigidBody one = at_touch(first), other = at_touch(second);
    std::vector<SolverBody> both;
    for (const auto& [i, b] : {std::pair(first, &one), std::pair(second, &other)})
      both.push_back(at(i, b->motion, b->motion.velocity, b->angular_velocity()));
    const std::vector<SolverBody> before = both;
    std::vector<SolverContact> contacts;  // none where they pass one another
    for (std::size_t n = 0; touch && n < meetings_.size(); ++n) {
      const Meeting& m = meetings_[n];
      if (m.first != first || m.second != second || !acted_[n]) continue;
      const Vec3 normal = normal_at_touch(one, other, m.normal);
      const Vec3 here = contact_point(m, point_at(first, m.first_point, one.motion, normal, -1.0),
                                      point_at(second, m.second_point, other.motion, normal, 1.0));
      const double closing = normal.dot(velocity_at(both[1], here) - velocity_at(both[0], here));
      contacts.push_back({0, 1, here, normal, m.law->friction, m.law->restitution * std::max(0.0, closing), false});
    }
    if (touch) solver_.solve(h_, 0.0, both, {}, contacts);
    Pair pair{first, second, one, other, {}, {}};
    const auto end = [&](int i, RigidBody body, int slot) {
      body.motion.velocity += both[slot].velocity - before[slot].velocity;
      body.motion.angular_momentum += body.apply_inertia(both[slot].spin - before[slot].spin);
      pair.turns_far = pair.turns_far || body.angular_velocity().norm() * rest > kFastTurn;
      return flown_on(body, pull(i), rest);
    };
    pair.first_end = end(first, one, 0), pair.second_end = end(second, other, 1);
    return pair;
  }

  /// Bodies that bounce leave their touch at its time, as far as nothing is in their way. On a static body the first
  /// solve has changed their velocities from the window's start, and the second one at its end: both do so at the
  /// touch. Two that both move are solved there anew, and stay at the window's end where their way is not free.
  void fly_on() {
    std::vector<Departure> departures;
    std::vector<double> rests;
    std::vector<Pair> pairs;
    const auto known = [](const auto& all, int first, int second) {
      return std::any_of(all.begin(), all.end(), [&](const auto& d) { return d.first == first && d.second == second; });
    };
    for (std::size_t k = 0; k < meetings_.size(); ++k) {
      const int first = meetings_[k].first, second = meetings_[k].second;
      if (!rebounds_[k] || known(departures, first, second) || known(pairs, first, second)) continue;
      if (slots_[first] >= 0 && slots_[second] >= 0) {
        pairs.push_back(bounce(k));
        continue;
      }
      const double touch = rebounds_[k]->touch, rest = h_ - touch;
      const auto shift = [&](int i) -> Shift {
        return {rest * relaxed_[i].linear - touch * solved_[i].linear,
                rest * relaxed_[i].spin - touch * solved_[i].spin};
      };
      departures.push_back({first, second, shift(first), shift(second)}), rests.push_back(rest);
    }
    const std::size_t on_static = departures.size();
    for (const Pair& p : pairs)
      departures.push_back({p.first, p.second, shift_between(p.first_touch.motion, p.first_end),
                            shift_between(p.second_touch.motion, p.second_end)});
    if (departures.empty()) return;
    std::vector<Way> ways;
    std::vector<int> of;  // mover of a way
    const auto add_way = [&](int i, const BodyMotion& end) {
      const Mover& m = movers_[i];
      const double bulge = 0.5 * h_ * (given_[i].velocity - m.velocity).norm();
      ways.push_back({m.body, m.body->motion, end, bulge, m.spin.norm() * h_ > kFastTurn}), of.push_back(i);
    };
    std::map<int, int> partners;
    for (std::size_t i = 0; i < movers_.size(); ++i) add_way(static_cast<int>(i), ends_[i].motion);
    for (const Pair& p : pairs) {
      partners[p.first] = p.second, partners[p.second] = p.first;
      for (const auto& [i, touch] : {std::pair(p.first, &p.first_touch), std::pair(p.second, &p.second_touch)}) {
        add_way(i, ends_[i].motion);  // which it takes where the other one is not free
        ways[i].end = touch->motion;
      }
    }
    const auto pass = [&](int a, int b) {
      const int i = of[a], k = of[b];
      const auto partner = partners.find(i);
      return i == k || (partner != partners.end() && partner->second == k) ||
             beside_.pass(movers_[i].id, movers_[k].id);
    };
    const std::vector<double> shares = free_shares(
        ways, departures, [&](int i) { return movers_[of[i]].shape; }, pass);
    for (std::size_t n = 0; n < on_static; ++n) {
      const Departure& d = departures[n];
      go_on(d.first, d.first_shift, shares[n], slots_[d.second] < 0 ? rests[n] : 0.0);
      go_on(d.second, d.second_shift, shares[n], slots_[d.first] < 0 ? rests[n] : 0.0);
    }
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      if (shares[on_static + n] < 1.0 || pairs[n].turns_far) continue;
      ends_[pairs[n].first].motion = pairs[n].first_end;
      ends_[pairs[n].second].motion = pairs[n].second_end;
    }
  }
  /// `rest`: time after a touch with a static body [s], else 0. What it cannot fly of that, the pull does not act in.
  void go_on(int i, const Shift& shift, double share, double rest) {
    if (slots_[i] < 0) return;
    BodyMotion& end = ends_[i].motion;
    if (share > 0.0) end = shifted(end, shift, share);
    if (share < 1.0) end.velocity -= (rest - time_of(share, shift.linear, end.velocity, pull(i), rest)) * pull(i);
  }

  struct Change {
    Vec3 linear = Vec3::Zero(), spin = Vec3::Zero();
  };

  VelocitySolver& solver_;
  double h_;
  const std::vector<Mover>& movers_;
  std::vector<Meeting> meetings_;
  std::vector<SolverJoint> joints_;  // in indices of movers
  const Beside& beside_;
  std::vector<char> acted_;  // by meeting: had an impulse in solve()
  std::vector<RigidBody> ends_;
  std::vector<BodyMotion> given_;                 // predicted, by mover
  std::vector<Change> solved_, relaxed_;          // of velocities, by mover, in solve() and relax()
  std::vector<std::optional<Rebound>> rebounds_;  // by meeting
  std::map<BodyId, int> index_;                   // of movers that meet
  std::vector<int> slots_;                        // by mover
  std::vector<SolverBody> solver_bodies_;
};

}  // namespace

std::vector<RigidBody> take_window(VelocitySolver& solver, double window_s, const std::vector<Mover>& movers,
                                   const std::vector<const BodyMotion*>& ends, std::vector<Meeting> meetings,
                                   std::vector<SolverJoint> joints, const Beside& beside) {
  return Transit(solver, window_s, movers, ends, std::move(meetings), std::move(joints), beside).run();
}

}  // namespace sunder::rigid
