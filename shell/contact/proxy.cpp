#include "shell/contact/proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/Dense>

namespace sunder::shell {
namespace {

constexpr double kLeastSafety = 0.05;  // a lower time_step_safety is no remedy
constexpr double kJointGap = 1e-6;     // of a body's radius: parts that are nearer to one another are joined

using Parts = std::vector<std::vector<Plane>>;

/// How far a point is outside of a plane [m], negative inside.
double outside(const Plane& p, const Vec3& local) { return p.normal.dot(local) - p.offset; }

bool holds(const std::vector<Plane>& planes, const Vec3& local) {
  return std::all_of(planes.begin(), planes.end(), [&](const Plane& p) { return outside(p, local) <= 0.0; });
}

/// Where the way out of a part through plane `p` ends. `gap`: how far parts that are joined may be apart [m].
Vec3 beyond(const Plane& p, const Vec3& local, double gap) { return local + (gap - outside(p, local)) * p.normal; }

/// The part that the way out of part `own` leads into; `own` where there is none.
std::size_t next_part(const Parts& parts, std::size_t own, const Vec3& beyond) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (i != own && holds(parts[i], beyond)) return i;
  return own;
}

/// The least deep way out of part `own`: through a face that is no joint, or through a joint and a face of the next
/// part. Where there is none, the least deep face.
Proxy::Distance way_out(const Parts& parts, std::size_t own, const Vec3& local, double gap,
                        const Proxy::Distance& least) {
  Proxy::Distance best{-std::numeric_limits<double>::infinity(), Vec3::UnitZ()};
  for (const Plane& p : parts[own]) {
    const double s = outside(p, local);
    if (s <= best.value) continue;
    const Vec3 there = beyond(p, local, gap);
    const std::size_t next = next_part(parts, own, there);
    if (next == own) {
      best = {s, p.normal};
      continue;
    }
    for (const Plane& q : parts[next])
      if (const double both = s + outside(q, there);
          both > best.value && next_part(parts, next, beyond(q, there, gap)) == next)
        best = {both, q.normal};
  }
  return std::isfinite(best.value) ? best : least;
}

/// Exact inside a part that is alone. Where parts touch, the way out does not lead through what they share. Outside of
/// all parts a lower bound that is not negative.
Proxy::Distance nearest_part(const Parts& parts, const Vec3& local, double gap) {
  Proxy::Distance best{std::numeric_limits<double>::infinity(), Vec3::UnitZ()};
  std::size_t own = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Proxy::Distance part{-std::numeric_limits<double>::infinity(), Vec3::UnitZ()};
    for (const Plane& p : parts[i]) {
      const double s = outside(p, local);
      if (s > part.value) part = {s, p.normal};
      if (part.value >= best.value) break;  // this part is not nearer
    }
    if (part.value < best.value) best = part, own = i;
  }
  return best.value <= gap && parts.size() > 1 ? way_out(parts, own, local, gap, best) : best;
}

}  // namespace

Vec3 contact_impulse(const Vec3& n, const Vec3& v_rel, const Mat3& inverse_mass, double friction, double restitution) {
  const double v_n = n.dot(v_rel);
  if (v_n >= 0.0) return Vec3::Zero();  // separating
  const Vec3 stick = inverse_mass.ldlt().solve(-v_rel - restitution * v_n * n);
  const double pressed = n.dot(stick);
  if (pressed > 0.0 && (stick - pressed * n).norm() <= friction * pressed) return stick;
  const Vec3 v_t = v_rel - v_n * n;
  const double speed = v_t.norm();
  const Vec3 slide = speed > 0.0 ? Vec3(n - friction / speed * v_t) : n;  // |j_t| = mu j_n, against the slip
  const double gain = n.dot(inverse_mass * slide);
  // a tangential impulse on a body that can turn may separate the surfaces by itself; then friction is left out
  const Vec3 along = gain > 0.0 ? slide : n;
  const double j_n = -(1.0 + restitution) * v_n / n.dot(inverse_mass * along);
  const Vec3 j = j_n * along;
  // the work of an impulse is that on the mean of the velocities before and after; friction must not add energy
  const bool gains = j.dot(v_rel + 0.5 * (inverse_mass * j)) > 0.0;
  return gains ? Vec3(-(1.0 + restitution) * v_n / n.dot(inverse_mass * n) * n) : j;
}

std::string slow_down(double travel, double wide, double safety) {
  const double enough = 0.9 * safety * wide / travel;  // two digits may say 5 % more
  return enough < kLeastSafety ? "slow it down: shells are not solved in steps so short"
                               : fmt::format("slow it down, or take a time_step_safety of {:.2g}", enough);
}

Proxy::Proxy(RigidBody b, std::shared_ptr<const DrivenMotion> driven, double arrived)
    : body(std::move(b)), driven_(std::move(driven)), arrived_(arrived) {
  if (const auto* s = std::get_if<SphereShape>(&body.shape)) radius_ = s->radius;
  if (const auto* s = std::get_if<BoxShape>(&body.shape)) radius_ = s->half_size.norm();
  if (std::holds_alternative<HalfSpaceShape>(body.shape)) radius_ = std::numeric_limits<double>::infinity();
  if (const auto* s = std::get_if<ConvexShape>(&body.shape)) {
    if (s->surface) {
      // Of a shape that changes, always the first one: which triangle is found on an edge depends on how they are
      // sorted, and a run that goes on must find the same.
      Surface first = *s->surface;
      if (deforms()) first.corners = driven_->shape.corners.front();
      solid_ = std::make_shared<SolidDistance>(first);
    }
    for (const auto& part : s->parts) {
      if (!solid_) parts_.push_back(hull_planes(part));
      for (const Vec3& c : part) radius_ = std::max(radius_, c.norm());
    }
    if (s->surface && s->parts.empty())
      for (const Vec3& c : s->surface->corners) radius_ = std::max(radius_, c.norm());
  }
  if (deforms() && arrived_ > 0.0) {
    std::vector<Vec3> now;
    driven_->shape.at(arrived_, now);
    solid_->move(now);
  }
}

void Proxy::drive(double t, double dt) {
  if (!driven_) return;
  place(*driven_, t, dt, body, spin_);
  if (!deforms()) return;
  std::vector<Vec3> now, then;
  driven_->shape.at(t, now);
  solid_->move(now);
  radius_ = 0.0;
  for (const Vec3& c : now) radius_ = std::max(radius_, c.norm());
  if (!(dt > 0.0)) return;
  driven_->shape.at(t + dt, then);
  for (std::size_t i = 0; i < then.size(); ++i) then[i] = (then[i] - now[i]) / dt;
  solid_->set_velocities(std::move(then));
}

void Proxy::arrive(double t) {
  if (!driven_) return;
  const BodyMotion before = body.motion;
  const Vec3 spin = spin_;
  drive(t, 0.0);
  arrived_ = t;
  body.motion.velocity = before.velocity, body.motion.angular_momentum = before.angular_momentum, spin_ = spin;
  if (!deforms()) return;
  auto& shape = std::get<ConvexShape>(body.shape);
  auto drawn = std::make_shared<Surface>(*shape.surface);
  driven_->shape.at(t, drawn->corners);
  shape.surface = std::move(drawn);
}

double Proxy::turning_speed() const {
  if (driven_) return driven_->top_speed;
  return body.is_static ? 0.0 : body.angular_velocity().norm() * radius();
}

double Proxy::half_width() const {
  const auto* box = std::get_if<BoxShape>(&body.shape);
  if (!box && !solid_) return radius_;
  Vec3 half = box ? box->half_size : Vec3(0.5 * solid_->extent());
  std::sort(half.begin(), half.end());
  return half[1];
}

Proxy::Distance Proxy::distance(const Vec3& world, std::int32_t guess) const {
  const Quat& q = body.motion.orientation;
  if (const auto* s = std::get_if<SphereShape>(&body.shape)) {
    const Vec3 d = world - body.motion.position;
    const double r = d.norm();
    return {r - s->radius, r > 0.0 ? Vec3(d / r) : Vec3(Vec3::UnitZ())};
  }
  const Vec3 local = this->local(world);
  if (std::holds_alternative<HalfSpaceShape>(body.shape)) return {local.z(), q * Vec3::UnitZ()};
  if (const auto* s = std::get_if<BoxShape>(&body.shape)) {
    const Vec3 over = local.cwiseAbs() - s->half_size;
    const Vec3 sign(std::copysign(1.0, local.x()), std::copysign(1.0, local.y()), std::copysign(1.0, local.z()));
    const Vec3 out = over.cwiseMax(0.0);
    if (out.squaredNorm() > 0.0) return {out.norm(), q * out.cwiseProduct(sign).normalized()};
    int axis = 0;
    over.maxCoeff(&axis);
    Vec3 n = Vec3::Zero();
    n[axis] = sign[axis];
    return {over[axis], q * n};
  }
  if (solid_) {
    const SolidDistance::Found found = solid_->at(local, guess);
    return {found.value, q * found.normal, found.point, found.triangle};
  }
  Distance best = nearest_part(parts_, local, kJointGap * radius_);
  best.normal = q * best.normal;
  return best;
}

Proxy::Known Proxy::known(const Vec3& world, const Distance& distance) const {
  return {local(world), distance.value, solid_ ? solid_->moved() : 0.0, distance.triangle};
}

double Proxy::change_since(const Vec3& world, const Known& k) const {
  return (local(world) - k.local).norm() + (solid_ ? solid_->moved() - k.moved : 0.0);
}

bool Proxy::surely_beyond(const Vec3& world, const Known& k, double least, double slack) const {
  const double spare = k.value - least - slack - (solid_ ? solid_->moved() - k.moved : 0.0);
  return spare > 0.0 && (local(world) - k.local).squaredNorm() < spare * spare;
}

Vec3 Proxy::rigid_velocity_at(const Vec3& world) const {
  const Vec3 arm = world - body.motion.position;
  if (driven_) return body.motion.velocity + spin_.cross(arm);
  return body.is_static ? Vec3(Vec3::Zero()) : Vec3(body.motion.velocity + body.angular_velocity().cross(arm));
}

Vec3 Proxy::velocity_at(const Vec3& world) const {
  const Vec3 rigid = rigid_velocity_at(world);
  return deforms() ? Vec3(rigid + body.motion.orientation * solid_->velocity_at(local(world))) : rigid;
}

Vec3 Proxy::velocity_at(const Vec3& world, const Distance& there) const {
  const Vec3 rigid = rigid_velocity_at(world);
  if (!deforms()) return rigid;
  return rigid + body.motion.orientation * solid_->velocity_at(there.nearest, there.triangle);
}

Mat3 Proxy::inverse_mass_at(const Vec3& world) const {
  Mat3 k = Mat3::Zero();
  if (!is_free() || unmoved) return k;
  const Vec3 arm = world - body.motion.position;
  for (int d = 0; d < 3; ++d)
    k.col(d) = body.apply_inverse_inertia(arm.cross(Vec3::Unit(d))).cross(arm) + Vec3::Unit(d) / body.mass;
  return 0.5 * (k + k.transpose());
}

void Proxy::apply(const Vec3& world, const Vec3& j) {
  const Vec3 turn = (world - body.motion.position).cross(j);
  linear_impulse += j, angular_impulse += turn;
  if (!is_free() || unmoved) return;
  body.motion.velocity += j / body.mass;
  body.motion.angular_momentum += turn;
}

}  // namespace sunder::shell
