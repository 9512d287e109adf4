#include "rigid/engine/way_back.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "rigid/engine/checks.h"
#include "rigid/engine/touch.h"

namespace sunder::rigid {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Closing along a way that is no touch: residuals of a solver times a window.
constexpr double kNoTouch_m = 1e-6;
/// Overlap that the end of a way may add: what the engines leave anyway.
constexpr double kOverlap_m = 5e-6;
/// A sweep advances to the touch that is next along tangents, and looks again. It ends when a step is below this share.
constexpr double kLastStep = 1e-3;  // [-]
constexpr int kMostSteps = 8;

struct Box {
  Vec3 low = Vec3::Constant(kInfinite), high = Vec3::Constant(-kInfinite);

  void add(const Vec3& x, const Vec3& around) { low = low.cwiseMin(x - around), high = high.cwiseMax(x + around); }
  void grow(double by) { low.array() -= by, high.array() += by; }
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

/// Distance of the farthest point from the centre of mass [m]; infinite for a half space.
double reach_of(const RigidBody& body) {
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) return sphere->radius;
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) return box->half_size.norm();
  const auto* convex = std::get_if<ConvexShape>(&body.shape);
  if (!convex) return kInfinite;
  double reach = 0.0;
  for (const auto& part : convex->parts)
    for (const Vec3& x : part) reach = std::max(reach, x.norm());
  return reach;
}

void add_pose(Box& box, const RigidBody& body, const BodyMotion& pose) {
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    box.add(pose.position, Vec3::Constant(sphere->radius));
  } else if (const auto* brick = std::get_if<BoxShape>(&body.shape)) {
    box.add(pose.position, pose.orientation.toRotationMatrix().cwiseAbs() * brick->half_size);
  } else if (const auto* convex = std::get_if<ConvexShape>(&body.shape)) {
    const Mat3 turn = pose.orientation.toRotationMatrix();
    for (const auto& part : convex->parts)
      for (const Vec3& x : part) box.add(pose.position + turn * x, Vec3::Zero());
  } else {
    box.add(pose.position, Vec3::Constant(kInfinite));
  }
}

/// Adds all places of a body between two poses. A corner that turns by w about the centre leaves its chord by at most
/// r (1 - cos(w / 2)).
void add_way(Box& box, const RigidBody& body, const BodyMotion& from, const BodyMotion& to, double bulge,
             bool turns_far) {
  const double reach = reach_of(body);
  Box own;
  if (turns_far) {
    own.add(from.position, Vec3::Constant(reach)), own.add(to.position, Vec3::Constant(reach));
  } else {
    add_pose(own, body, from), add_pose(own, body, to);
    const double turn = rotation_vector(to.orientation * from.orientation.conjugate()).norm();
    if (turn > 0.0) bulge += reach * (1.0 - std::cos(0.5 * turn));
  }
  own.grow(bulge);
  box.low = box.low.cwiseMin(own.low), box.high = box.high.cwiseMax(own.high);
}

/// A body of a sweep: its shape, and the parts of it that may meet the other.
struct Swept {
  const HullShape* shape;
  BodyMotion from;
  Shift shift;
  Box box;  // of its way
  std::vector<int> parts = {};

  Vec3 moves(const Vec3& point, const BodyMotion& now) const {  // by the whole shift [m]
    return shift.linear + shift.turn.cross(point - now.position);
  }
};

/// Touches of two bodies, the first of which is no half space, after a share of their shifts.
std::vector<Touch> touches_at(const Swept& a, const Swept& b, double share, double reach) {
  const BodyMotion at_a = shifted(a.from, a.shift, share), at_b = shifted(b.from, b.shift, share);
  std::vector<Touch> touches;
  std::vector<Hull> others(b.parts.size());
  for (std::size_t i = 0; i < b.parts.size(); ++i) place(b.shape->parts[b.parts[i]], at_b, others[i]);
  for (const int k : a.parts) {
    Hull part;
    place(a.shape->parts[k], at_a, part);
    if (b.shape->is_half_space) {
      const Vec3 up = at_b.orientation * Vec3::UnitZ();
      touch_half_space(part, up, up.dot(at_b.position), reach, touches);
    }
    for (const Hull& other : others) touch_hulls(part, other, reach, touches);
  }
  return touches;
}

double depth_at(const Swept& a, const Swept& b, double share) {
  double depth = 0.0;
  for (const Touch& t : touches_at(a, b, share, 0.0)) depth = std::max(depth, -t.gap);
  return depth;
}

/// Share of the shifts up to the first touch. A touch that opens is none.
double sweep(const Swept& a, const Swept& b) {
  const double reach = kOverlap_m + (a.shift.linear - b.shift.linear).norm() + a.shift.turn.norm() * a.shape->reach +
                       b.shift.turn.norm() * b.shape->reach;
  double share = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    const BodyMotion at_a = shifted(a.from, a.shift, share), at_b = shifted(b.from, b.shift, share);
    double ahead = 1.0 - share;
    bool met = false;
    for (const Touch& t : touches_at(a, b, share, reach)) {
      const double closing = -t.normal.dot(a.moves(t.first, at_a) - b.moves(t.second, at_b));  // in the whole shift
      if (t.gap - closing * (1.0 - share) >= std::min(t.gap, 0.0) - kNoTouch_m) continue;
      met = true, ahead = std::min(ahead, std::max(0.0, t.gap) / closing);
    }
    share += ahead;
    if (!met) return 1.0;
    if (ahead < kLastStep) break;
  }
  return share;
}

/// Parts that reach into a box anywhere between the start and the end of the shift.
std::vector<int> parts_in(const Box& box, const Swept& body) {
  std::vector<int> found;
  const BodyMotion to = shifted(body.from, body.shift, 1.0);
  const double bulge = body.shape->reach * (1.0 - std::cos(0.5 * body.shift.turn.norm()));
  for (std::size_t k = 0; k < body.shape->parts.size(); ++k) {
    const Hull& part = body.shape->parts[k];
    Box own;
    for (const BodyMotion* pose : {&body.from, &to})
      for (const Vec3& x : part.points) own.add(pose->position + pose->orientation * x, Vec3::Constant(part.radius));
    own.grow(kOverlap_m + bulge);
    if (own.meets(box)) found.push_back(static_cast<int>(k));
  }
  return found;
}

/// Sweeps of one window.
class Sweeps {
 public:
  Sweeps(const std::vector<Way>& ways, const std::vector<Departure>& departures,
         const std::function<const HullShape*(int)>& hulls, const std::function<bool(int, int)>& pass)
      : ways_(ways), hulls_(hulls), pass_(pass), boxes_(ways.size()), legs_(ways.size()) {
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const Way& w = ways[i];
      if (w.body->is_static)
        add_pose(boxes_[i], *w.body, w.end);
      else
        add_way(boxes_[i], *w.body, w.start, w.end, w.bulge, w.turns_far);
    }
    for (const Departure& d : departures) add_leg(d.first, d.first_shift), add_leg(d.second, d.second_shift);
  }

  double free_share(const Departure& d) const {
    double share = std::min(beside(d.first, d.first_shift, d.second), beside(d.second, d.second_shift, d.first));
    if (share > 0.0) share = std::min(share, between(d.first, d.first_shift, d.second, d.second_shift));
    if (share > 0.0 &&
        (deeper(d.first, d.first_shift, d.second, d.second_shift, share) ||
         any_deeper(d.first, d.first_shift, d.second, share) || any_deeper(d.second, d.second_shift, d.first, share)))
      return 0.0;
    return share;
  }

 private:
  void add_leg(int i, const Shift& shift) {
    const Way& w = ways_[i];
    if (w.body->is_static) return;
    const bool far = shift.turn.norm() > kFastTurn;
    add_way(legs_[i], *w.body, w.end, shifted(w.end, shift, 1.0), kOverlap_m, far);
    add_way(boxes_[i], *w.body, w.end, shifted(w.end, shift, 1.0), kOverlap_m, far);
  }

  /// Calls act(other) for each body beside the partner that is near the way back of body i.
  template <class Act>
  void each_beside(int i, int partner, Act act) const {
    if (ways_[i].body->is_static) return;
    for (std::size_t k = 0; k < ways_.size(); ++k) {
      const int other = static_cast<int>(k);
      if (other == i || other == partner || !legs_[i].meets(boxes_[k]) || pass_(i, other)) continue;
      act(other);
    }
  }
  double beside(int i, const Shift& shift, int partner) const {
    double share = 1.0;
    each_beside(i, partner, [&](int other) {
      if (share > 0.0) share = ways_[other].body->is_static ? std::min(share, between(i, shift, other, {})) : 0.0;
    });
    return share;
  }
  bool any_deeper(int i, const Shift& shift, int partner, double share) const {
    bool any = false;
    each_beside(i, partner, [&](int other) { any = any || deeper(i, shift, other, {}, share); });
    return any;
  }

  /// Two bodies for a sweep, a half space last. False where no sweep can tell.
  bool take(int i, const Shift& shift, int k, const Shift& other_shift, Swept& a, Swept& b) const {
    const auto of = [&](int body, const Shift& by) {
      return Swept{hulls_(body), ways_[body].end, by, ways_[body].body->is_static ? boxes_[body] : legs_[body]};
    };
    a = of(i, shift), b = of(k, other_shift);
    if (!a.shape || !b.shape || std::max(shift.turn.norm(), other_shift.turn.norm()) > kFastTurn) return false;
    if (a.shape->is_half_space) std::swap(a, b);
    a.parts = parts_in(b.box, a), b.parts = parts_in(a.box, b);
    return true;
  }
  double between(int i, const Shift& shift, int k, const Shift& other_shift) const {
    Swept a, b;
    return take(i, shift, k, other_shift, a, b) ? sweep(a, b) : 0.0;
  }
  bool deeper(int i, const Shift& shift, int k, const Shift& other_shift, double share) const {
    Swept a, b;
    return take(i, shift, k, other_shift, a, b) && depth_at(a, b, share) > depth_at(a, b, 0.0) + kOverlap_m;
  }

  const std::vector<Way>& ways_;
  const std::function<const HullShape*(int)>& hulls_;
  const std::function<bool(int, int)>& pass_;
  std::vector<Box> boxes_;  // of the whole window, by way
  std::vector<Box> legs_;   // of the way back alone
};

}  // namespace

BodyMotion shifted(const BodyMotion& from, const Shift& shift, double share) {
  BodyMotion to = from;
  to.position += share * shift.linear;
  to.orientation = (rotation_from_vector(share * shift.turn) * from.orientation).normalized();
  return to;
}

double time_of(double share, const Vec3& way, const Vec3& velocity, const Vec3& pull, double rest) {
  const double length = way.norm();
  if (!(length > 0.0)) return share * rest;
  const double p = pull.dot(way) / length, begin = velocity.dot(way) / length - p * rest;
  const double square = begin * begin + 2.0 * p * share * length;
  if (!(begin > 0.0 && square > 0.0)) return share * rest;
  return std::min(rest, 2.0 * share * length / (begin + std::sqrt(square)));
}

std::vector<double> free_shares(const std::vector<Way>& ways, const std::vector<Departure>& departures,
                                const std::function<const HullShape*(int)>& hulls,
                                const std::function<bool(int, int)>& pass) {
  if (departures.empty()) return {};
  const Sweeps sweeps(ways, departures, hulls, pass);
  std::vector<double> shares;
  for (const Departure& d : departures) shares.push_back(sweeps.free_share(d));
  return shares;
}

}  // namespace sunder::rigid
