#pragma once
// Blocks and balls of rubber, for tests and validations of soft bodies.
#include <cmath>
#include <numbers>
#include <vector>

#include "shell/soft/soft_bodies.h"

namespace sunder::soft_blocks {

using namespace sunder::shell;

inline SoftMaterial rubber(double young = 1e6, double poisson = 0.3) { return {1000.0, young, poisson}; }

inline BodyMotion at(const Vec3& x, const Quat& q = Quat::Identity()) {
  BodyMotion m;
  m.position = x, m.orientation = q;
  return m;
}

inline SoftSetup block(const Vec3& half, const BodyMotion& pose, double spacing, const Vec3& velocity = Vec3::Zero(),
                       const Vec3& angular = Vec3::Zero(), const SoftMaterial& material = rubber()) {
  return {make_soft("block", material, BoxShape{half}, pose, spacing, 2.0 * spacing, 8.0 * half.prod()), velocity,
          angular};
}

/// Between soft bodies of group 0 and whatever has group 1, and within both.
inline std::vector<ContactLaw> laws(double friction) {
  return {{0, 0, friction, 0.0}, {0, 1, friction, 0.0}, {1, 1, friction, 0.0}};
}

/// A half space below z = 0, of group 1.
inline std::vector<Proxy> ground() {
  RigidBody b;
  b.id = 1, b.name = "floor", b.is_static = true, b.shape = HalfSpaceShape{}, b.contact_group = 1;
  return {Proxy(b)};
}

/// Energy with its book [J].
inline double books(const SoftBodies& s, const Vec3& gravity) {
  const SoftSums sums = s.sums(gravity);
  return sums.kinetic + sums.elastic + sums.potential + s.book().lost();
}

/// Speed of waves along a bar that cannot widen, over sqrt((lambda + 2 mu) / rho), from two and a half half periods of
/// its first mode; `left`: of the amplitude after half a period.
inline double wave_speed(double spacing, double* left = nullptr) {
  const double length = 0.4;
  const SoftModel m = block({0.5 * length, 0.02, 0.02}, at({0.201, 0.003, 0.004}), spacing).model;
  SoftState s = make_soft_state(m, Vec3::Zero(), Vec3::Zero());
  const double c = m.material.wave_speed(), k = std::numbers::pi / length, dt = 0.8 * soft_stable_step(m, s);
  const auto phase = [&](std::size_t p) { return k * (m.rest[p].x() - 0.001); };
  for (std::size_t p = 0; p < s.x.size(); ++p) {
    s.v[p].x() = 1e-3 * c * std::cos(phase(p));
    s.affine[p](0, 0) = -1e-3 * c * k * std::sin(phase(p));
  }
  double time = 0.0, last = 0.0, crossed = 0.0, first = 0.0, least = 0.0;
  for (int crossings = 0; crossings < 3;) {
    to_grid(m, s, Vec3::Zero(), dt, 1);
    for (Vec3& v : s.grid.v) v.y() = v.z() = 0.0;
    from_grid(m, s, dt, 1);
    double now = 0.0;
    for (std::size_t p = 0; p < s.x.size(); ++p) now += m.mass[p] * s.v[p].x() * std::cos(phase(p));
    if (now * last < 0.0) crossed = time - 0.5 * dt + dt * last / (last - now), ++crossings;
    if (first == 0.0) first = now;
    least = std::min(least, now / first);
    last = now, time += dt;
  }
  if (left != nullptr) *left = -least;
  return 2.5 * length / crossed / c;
}

/// How far the middle of a block on the floor sinks under its weight, without friction, over rho g h^2 / 3E.
inline double sag(double spacing) {
  const double height = 0.1, young = 2e5;
  const Vec3 gravity(0, 0, -9.81);
  SoftBodies soft(
      {block({0.02, 0.02, 0.5 * height}, at({0, 0, 0.5 * height}), spacing, Vec3::Zero(), Vec3::Zero(), rubber(young))},
      0, laws(0.0));
  std::vector<Proxy> bodies = ground();
  double last = 0.0;
  const double dt = 0.8 * soft.stable_step();
  for (double t = 0.0; t < 0.6; t += dt) {
    soft.step(gravity, dt, 0.8, bodies);
    const double now = soft.sums(gravity).kinetic;
    if (now < last) {  // remove the motion where it is fastest
      for (Vec3& v : soft.states()[0].v) v.setZero();
      for (Mat3& a : soft.states()[0].affine) a.setZero();
      last = 0.0;
    } else {
      last = now;
    }
  }
  return (0.5 * height - soft.sums(gravity).centre.z()) / (1000 * 9.81 * height * height / (3 * young));
}

}  // namespace sunder::soft_blocks
