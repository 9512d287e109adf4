#include "coupler/link/held_rows.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace sunder::link {
namespace {

constexpr int kSweeps = 20;                // at most
constexpr double kConverged = 1e-11;       // largest change of a velocity in a sweep, relative to the fastest one
constexpr double kImpactSpeed_m_s = 0.05;  // slower contacts do not bounce

constexpr double kSamePoint_m = 1e-3;  // a contact that moves by less between windows keeps its impulse

bool moves(const RigidBody* b) { return b && !b->is_static; }

Vec3 velocity_at(const RigidBody* b, const Vec3& arm) {
  return moves(b) ? Vec3(b->motion.velocity + b->angular_velocity().cross(arm)) : Vec3(Vec3::Zero());
}

void push(RigidBody* b, const Vec3& arm, const Vec3& j) {
  if (!moves(b)) return;
  b->motion.velocity += j / b->mass;
  b->motion.angular_momentum += arm.cross(j);
}

void twist(RigidBody* b, const Vec3& angular) {
  if (moves(b)) b->motion.angular_momentum += angular;
}

// Inverse mass of a body at `arm`: change of velocity per impulse there, along `axes` [1/kg].
Mat3 inverse_mass(const RigidBody* b, const Vec3& arm, const Mat3& axes) {
  if (!moves(b)) return Mat3::Zero();
  Mat3 k;
  for (int d = 0; d < 3; ++d)
    k.col(d) = axes.col(d) / b->mass + b->apply_inverse_inertia(arm.cross(axes.col(d))).cross(arm);
  return axes.transpose() * k;
}

Mat3 inverse_inertia(const RigidBody* b, const Mat3& axes) {
  if (!moves(b)) return Mat3::Zero();
  Mat3 k;
  for (int d = 0; d < 3; ++d) k.col(d) = b->apply_inverse_inertia(axes.col(d));
  return axes.transpose() * k;
}

// Norm of the first n entries.
double size(const Vec3& v, int n) {
  double sum = 0.0;
  for (int d = 0; d < n; ++d) sum += v[d] * v[d];
  return std::sqrt(sum);
}

// The inverse of the leading n x n block; the rest is zero.
Mat3 leading_inverse(const Mat3& m, int n) {
  Mat3 out = Mat3::Zero();
  if (n > 0) out.topLeftCorner(n, n) = m.topLeftCorner(n, n).inverse();
  return out;
}

}  // namespace

void HeldRows::take(const std::vector<ContactRow>& rows, const std::vector<Joint>& joints,
                    const std::vector<RigidBody*>& bodies) {
  std::unordered_map<BodyId, RigidBody*> by_id;
  for (RigidBody* b : bodies) by_id[b->id] = b;
  const std::vector<Contact> old = std::move(contacts_);
  const std::vector<Bilateral> old_joints = std::move(joints_);
  clear(), touched_.clear();
  // Impulse of the same contact in the window before. A stack that starts from zero impulses sinks in every window.
  const auto impulse_before = [&](const ContactRow& row) {
    Vec3 best = Vec3::Zero();
    double nearest = kSamePoint_m;
    for (const Contact& c : old) {
      if (c.row.first != row.first || c.row.second != row.second) continue;
      const double distance = (c.row.first_point - row.first_point).norm();
      if (distance < nearest) nearest = distance, best = c.impulse;
    }
    return best;
  };
  const auto touch = [&](RigidBody* b) {
    if (moves(b) && std::find(touched_.begin(), touched_.end(), b) == touched_.end()) touched_.push_back(b);
  };
  for (const ContactRow& row : rows) {
    Contact c;
    c.first = by_id.at(row.first), c.second = by_id.at(row.second), c.row = row;
    c.side = row.normal.unitOrthogonal(), c.other = row.normal.cross(c.side);
    c.impulse = impulse_before(row);
    contacts_.push_back(c), touch(c.first), touch(c.second);
  }
  for (const Joint& joint : joints) {
    Bilateral b;
    b.first = by_id.at(joint.first), b.second = joint.second ? by_id.at(joint.second) : nullptr, b.joint = joint;
    b.held_linear = joint.kind == Joint::Kind::kSlider ? 2 : 3;
    b.held_angular = joint.kind == Joint::Kind::kBall ? 0 : joint.kind == Joint::Kind::kHinge ? 2 : 3;
    for (const Bilateral& o : old_joints)
      if (o.joint.id == joint.id) b.linear = o.linear, b.angular = o.angular;
    joints_.push_back(b), touch(b.first), touch(b.second);
  }
}

void HeldRows::prepare(Contact& c, double h) {
  const BodyMotion &a = c.first->motion, &b = c.second->motion;
  const Vec3& n = c.row.normal;
  Vec3 pa = a.position + a.orientation * c.row.first_point, pb = b.position + b.orientation * c.row.second_point;
  // A sphere touches straight below its centre at any time. An impulse beside that point would turn it.
  const auto* first_sphere = std::get_if<SphereShape>(&c.first->shape);
  const auto* second_sphere = std::get_if<SphereShape>(&c.second->shape);
  if (first_sphere) pa = a.position - first_sphere->radius * n;
  if (second_sphere) pb = b.position + second_sphere->radius * n;
  const double gap = (pa - pb).dot(n) + c.row.allowance;
  const Vec3 middle = first_sphere    ? Vec3(pa - 0.5 * gap * n)
                      : second_sphere ? Vec3(pb + 0.5 * gap * n)
                                      : Vec3(0.5 * (pa + pb));
  c.first_arm = middle - a.position, c.second_arm = middle - b.position;
  Mat3 axes;
  axes << c.row.normal, c.side, c.other;
  c.inverse = inverse_mass(c.first, c.first_arm, axes) + inverse_mass(c.second, c.second_arm, axes);
  const double closing = (velocity_at(c.second, c.second_arm) - velocity_at(c.first, c.first_arm)).dot(c.row.normal);
  c.target = -std::max(gap, 0.0) / h;
  if (c.row.restitution > 0.0 && closing > kImpactSpeed_m_s && closing * h > std::max(gap, 0.0))
    c.target = c.row.restitution * closing;
}

void HeldRows::prepare(Bilateral& b, double h) {
  const auto frame = [](const RigidBody* body, const Joint::Frame& f, Vec3& at, Quat& turned) {
    at = body ? Vec3(body->motion.position + body->motion.orientation * f.position) : f.position;
    turned = body ? body->motion.orientation * f.orientation : f.orientation;
  };
  Vec3 pa, pb;
  Quat qa, qb;
  frame(b.first, b.joint.first_frame, pa, qa), frame(b.second, b.joint.second_frame, pb, qb);
  b.axes = qb.toRotationMatrix();
  const Vec3 middle = 0.5 * (pa + pb);
  b.first_arm = middle - b.first->motion.position;
  b.second_arm = b.second ? Vec3(middle - b.second->motion.position) : Vec3(Vec3::Zero());
  b.linear_target = b.axes.transpose() * (pb - pa) / h;
  const Vec3 error = rotation_vector(qa * qb.conjugate());
  // a hinge turns about z, so its error is the tilt of that axis: the cross product of the two axes
  const Vec3 tilt = (qb * Vec3::UnitZ()).cross(qa * Vec3::UnitZ());
  b.angular_target = -(b.axes.transpose() * (b.held_angular == 2 ? tilt : error)) / h;
  b.point_mass = leading_inverse(
      inverse_mass(b.first, b.first_arm, b.axes) + inverse_mass(b.second, b.second_arm, b.axes), b.held_linear);
  b.turn_mass = leading_inverse(inverse_inertia(b.first, b.axes) + inverse_inertia(b.second, b.axes), b.held_angular);
}

double HeldRows::sweep(Contact& c) {
  Mat3 axes;
  axes << c.row.normal, c.side, c.other;
  double most = 0.0;
  const auto slip = [&] {
    return Vec3(axes.transpose() * (velocity_at(c.first, c.first_arm) - velocity_at(c.second, c.second_arm)));
  };
  const auto take = [&](const Vec3& change) {
    if (change.isZero(0.0)) return;
    c.impulse += change;
    const Vec3 j = axes * change;
    push(c.first, c.first_arm, j), push(c.second, c.second_arm, -j);
    most = std::max(most, (c.inverse * change).norm());
  };
  Vec3 v = slip();
  const double pressed = std::max(0.0, c.impulse[0] + (c.target - v[0]) / c.inverse(0, 0));
  take(Vec3(pressed - c.impulse[0], 0.0, 0.0));
  if (c.row.friction > 0.0) {
    v = slip();
    const Eigen::Matrix2d k = c.inverse.bottomRightCorner<2, 2>();
    Vec2 lateral = c.impulse.tail<2>() - k.inverse() * v.tail<2>();
    const double limit = c.row.friction * c.impulse[0], size = lateral.norm();
    if (size > limit) lateral *= limit / size;
    take(Vec3(0.0, lateral[0] - c.impulse[1], lateral[1] - c.impulse[2]));
  }
  return most;
}

double HeldRows::sweep(Bilateral& b) {
  double most = 0.0;
  const Vec3 v =
      b.axes.transpose() * (velocity_at(b.first, b.first_arm) - velocity_at(b.second, b.second_arm)) - b.linear_target;
  const Vec3 j = -(b.point_mass * v);
  push(b.first, b.first_arm, b.axes * j), push(b.second, b.second_arm, -(b.axes * j));
  b.linear += j;
  most = std::max(most, size(v, b.held_linear));
  if (b.held_angular > 0) {
    const auto spin = [](const RigidBody* body) { return moves(body) ? body->angular_velocity() : Vec3(Vec3::Zero()); };
    const Vec3 w = b.axes.transpose() * (spin(b.first) - spin(b.second)) - b.angular_target;
    const Vec3 l = -(b.turn_mass * w);
    twist(b.first, b.axes * l), twist(b.second, -(b.axes * l));
    b.angular += l;
    // as a velocity at the radius of gyration
    const double arm = std::sqrt(b.first->principal_inertia.maxCoeff() / std::max(b.first->mass, 1e-300));
    most = std::max(most, arm * size(w, b.held_angular));
  }
  return most;
}

double HeldRows::kinetic() const {
  double sum = 0.0;
  for (const RigidBody* b : touched_) sum += b->kinetic_energy();
  return sum;
}

double HeldRows::solve(double h) {
  if (empty()) return 0.0;
  const double before = kinetic();
  double fastest = 0.0;
  for (const RigidBody* b : touched_) fastest = std::max(fastest, b->motion.velocity.norm());
  for (Contact& c : contacts_) prepare(c, h), fastest = std::max(fastest, std::min(std::abs(c.target), 1.0));
  for (Bilateral& b : joints_) prepare(b, h);
  for (Contact& c : contacts_) {  // start from the impulses of the last substep
    Mat3 axes;
    axes << c.row.normal, c.side, c.other;
    const Vec3 j = axes * c.impulse;
    push(c.first, c.first_arm, j), push(c.second, c.second_arm, -j);
  }
  for (Bilateral& b : joints_) {
    push(b.first, b.first_arm, b.axes * b.linear), push(b.second, b.second_arm, -(b.axes * b.linear));
    twist(b.first, b.axes * b.angular), twist(b.second, -(b.axes * b.angular));
  }
  for (int k = 0; k < kSweeps; ++k) {
    double most = 0.0;
    for (Contact& c : contacts_) most = std::max(most, sweep(c));
    for (Bilateral& b : joints_) most = std::max(most, sweep(b));
    if (most <= kConverged * fastest) break;
  }
  return before - kinetic();
}

}  // namespace sunder::link
