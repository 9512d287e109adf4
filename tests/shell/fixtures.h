#pragma once
// Shells that several tests use.
#include <random>

#include <gtest/gtest.h>

#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/state.h"

namespace sunder::shell {

inline ShellMaterial glass() {
  ShellMaterial m;
  m.density = 2500, m.youngs_modulus = 70e9, m.poisson_ratio = 0.22;
  return m;
}

// A patch with unequal weights and curvature.
inline Patch rational_patch(const KnotVector& u, const KnotVector& v) {
  Patch p{u, v, {}, {}};
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i) {
      const double u = p.knots_u.greville(i), v = p.knots_v.greville(j);
      p.control_points.emplace_back(u, v + 0.1 * u * u, 0.2 * u * u - 0.1 * u * v);
      p.weights.push_back(1.0 + 0.2 * ((i + j) % 2));
    }
  return p;
}
inline Patch rational_patch() {  // unequal knots
  return rational_patch(KnotVector({0, 0, 0, 0.3, 0.5, 1, 1, 1}, 2, "u"), KnotVector({0, 0, 0, 0.4, 1, 1, 1}, 2, "v"));
}

// Unequal weights, unequal knots, one of them double, and curvature.
inline Patch cubic_patch() {
  return rational_patch(KnotVector({0, 0, 0, 0, 0.3, 0.5, 0.5, 1, 1, 1, 1}, 3, "u"),
                        KnotVector({0, 0, 0, 0, 0.4, 1, 1, 1, 1}, 3, "v"));
}

// A pane of 20 cm and 4 mm that cracks at 60 MPa.
inline ShellModel brittle_sheet(int elements = 20) {
  ShellMaterial m = glass();
  m.strength = 60e6, m.fracture_energy = 8.0;
  return make_shell("p", plate(0.2, 0.2, elements, elements, Vec3::Zero(), Quat::Identity()), 0.004, m, 2, 2, {});
}

// A strip of 1 m along x from the origin, 20 cm wide.
inline ShellModel strip(const std::vector<Support>& supports, const std::vector<Load>& loads, double poisson = 0.0) {
  ShellMaterial m = glass();
  m.poisson_ratio = poisson;
  return make_shell("strip", plate(1.0, 0.2, 20, 4, Vec3(0.5, 0.1, 0), Quat::Identity()), 0.01, m, 2, 2, supports,
                    loads);
}

inline double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
}

inline void disturb(ShellState& s, const ShellModel& m, double size) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-size, size);
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d)
      s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] += uniform(random);
}

constexpr double kFoldFlat = 0.1;  // half of what fold_up() leaves flat [m]

/// Turns both ends of a sheet that lies about x = 0 up, round a radius of 12 cm beyond 10 cm; each control point past
/// the turn, `straight` [m] of it, gets an x-velocity of -side * speed(straight) [m/s], side being 1 or -1.
template <class Speed>
void fold_up(const ShellModel& m, ShellState& s, Speed&& speed) {
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const double x = m.rest[slot], bent = std::max(0.0, std::abs(x) - kFoldFlat), side = x < 0.0 ? -1.0 : 1.0;
    const double radius = 0.12, angle = std::min(bent / radius, 1.6), straight = bent - radius * angle;
    s.motion.x[slot] =
        side * (std::min(std::abs(x), kFoldFlat) + radius * std::sin(angle) + straight * std::cos(angle));
    s.motion.x[2 * static_cast<std::size_t>(m.tables.component_stride) + slot] =
        radius * (1.0 - std::cos(angle)) + straight * std::sin(angle);
    if (straight > 1e-9) s.motion.v[slot] = -side * speed(straight);  // within the turn it is round-off
  }
}

inline void expect_gradient(const ShellModel& m, ShellState& s) {
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> force = s.motion.force;
  double scale = 0.0;
  for (const double f : force) scale = std::max(scale, std::abs(f));
  const double epsilon = 1e-6 * m.spacing;
  for (int i = 0; i < m.control_points(); i += 3)
    for (int d = 0; d < 3; ++d) {
      const std::size_t k = d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i);
      const double x = s.motion.x[k];
      s.motion.x[k] = x + epsilon;
      const double high = compute_forces(m, s, true, 0.0, 1);
      s.motion.x[k] = x - epsilon;
      const double low = compute_forces(m, s, true, 0.0, 1);
      s.motion.x[k] = x;
      // central differences: O(epsilon^2) plus round-off of the energy over epsilon
      EXPECT_NEAR(force[k], -(high - low) / (2.0 * epsilon), 1e-5 * scale)
          << "control point " << i << " direction " << d;
    }
}

struct MomentumBalance {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // sums over all control points [N], [N m]
  double scale = 0.0;                                // sum of |f| [N]
};
inline MomentumBalance balance(const ShellModel& m, const ShellState& s) {
  MomentumBalance b;
  for (int i = 0; i < m.control_points(); ++i) {
    const Vec3 f = s.at(s.motion.force, m.tables.slot(i));
    b.force += f, b.torque += s.position(m.tables.slot(i)).cross(f), b.scale += f.norm();
  }
  return b;
}

inline void expect_balance_beside_a_cut(const ShellModel& m, const Vec2& from, const Vec2& to) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {from, to}, 0.0);
  disturb(s, m, 1e-3);
  compute_forces(m, s, false, 0.0, 2);
  const MomentumBalance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);  // round-off of sums
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

}  // namespace sunder::shell
