// Cracks change the force between two half kicks: what they say they changed, and what the books make of it.
#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/insertion.h"
#include "shell/solver/forces.h"
#include "shell/solver/interlock.h"
#include "shell/solver/state.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kStep = 2e-7;  // [s], below the stable one of all sheets here

ShellModel sheet(double yield_stress = 0.0, std::vector<Support> supports = {}) {
  ShellMaterial material = glass();
  material.strength = 100e6, material.fracture_energy = 10.0, material.yield_stress = yield_stress;
  material.hardening_modulus = yield_stress > 0.0 ? 1e9 : 0.0;
  return make_shell("p", plate(0.1, 0.08, 20, 16, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 3,
                    std::move(supports));
}

int insert(const ShellModel& m, ShellState& s, const Vec2& a, const Vec2& b) {
  const int from = s.cracks.graph.add_vertex(a), to = s.cracks.graph.add_vertex(b);
  return insert_edge(m, s, from, to, s.cracks.graph.new_crack(), 0.0, 1, true);
}

void step(const ShellModel& m, ShellState& s, int times) {
  for (int n = 0; n < times; ++n) {
    compute_forces(m, s, false, 1.0, 1);
    kick(m, s, Vec3::Zero(), kStep);
    constrain(m, s, kStep);
    drift(m, s, kStep);
  }
}

double energy(const ShellModel& m, ShellState& s) {
  const double stored = compute_forces(m, s, true, 0.0, 1);
  apply_force_discontinuity({{&m, &s}}, kStep);
  const double half = 0.5 * kStep * external_power(m, s);  // as in Run::total_energy
  return stored + kinetic_energy(m, s, kStep) - half + s.book.lost();
}

// In motion, strained all over, a crack with faces that bear in it, and another one about to cross its surroundings.
ShellState moving(const ShellModel& m, double brittleness = 0.0, bool heals = true) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  s.layers.brittleness = brittleness, s.layers.heals = heals;
  insert(m, s, {0.0312, 0.0305}, {0.0351, 0.0331});
  disturb(s, m, 5e-6);
  step(m, s, 40);
  return s;
}

struct Case {
  const char* name;
  double yield_stress, brittleness;
  bool heals;
};
const Case kCases[] = {{"elastic", 0, 0, true},
                       {"yields", 50e6, 0, true},
                       {"weakens", 0, 0.4, true},
                       {"weakens irreversibly", 0, 0.4, false}};

double largest(const std::vector<double>& a) {
  double most = 0.0;
  for (const double x : a) most = std::max(most, std::abs(x));
  return most;
}

}  // namespace

TEST(Discontinuity, IsTheForceBeforeLessThatAfter) {
  for (const Case& c : kCases) {
    const ShellModel m = sheet(c.yield_stress);
    ShellState s = moving(m, c.brittleness, c.heals);
    compute_forces(m, s, true, 0.0, 1);
    const std::vector<double> before = s.motion.force;
    ASSERT_TRUE(s.cracks.force_discontinuity.empty());
    ASSERT_GE(insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318}), 0);  // crosses the faces' visibility
    ASSERT_FALSE(s.cracks.force_discontinuity.empty());
    release_interlocks(m, s, {}, true);
    compute_forces(m, s, true, 0.0, 1);
    double changed = 0.0, off = 0.0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      changed = std::max(changed, std::abs(before[k] - s.motion.force[k]));
      off = std::max(off, std::abs(before[k] - s.motion.force[k] - s.cracks.force_discontinuity[k]));
    }
    EXPECT_GT(changed, 1e-2 * largest(before)) << c.name;
    EXPECT_LT(off, 1e-11 * largest(before)) << c.name;
  }
}

TEST(Discontinuity, TakenUpItKeepsEnergyAndMomenta) {
  for (const Case& c : kCases) {
    const ShellModel m = sheet(c.yield_stress);
    ShellState s = moving(m, c.brittleness, c.heals);
    const double before = energy(m, s);
    const auto momenta = [&](Vec3& linear, Vec3& angular) {
      linear = angular = Vec3::Zero();
      for (int i = 0; i < m.control_points(); ++i) {
        const int slot = m.tables.slot(i);
        const Vec3 p = s.motion.mass[slot] * s.velocity(slot);
        linear += p, angular += s.position(slot).cross(p);
      }
    };
    Vec3 linear, angular, then_linear, then_angular;
    momenta(linear, angular);
    double scale = 0.0;
    for (int i = 0; i < m.control_points(); ++i)
      scale += s.motion.mass[m.tables.slot(i)] * s.velocity(m.tables.slot(i)).norm();
    insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318});
    release_interlocks(m, s, {}, true);
    EXPECT_NEAR(energy(m, s), before, 1e-10 * before) << c.name;
    EXPECT_TRUE(s.cracks.force_discontinuity.empty());
    momenta(then_linear, then_angular);
    EXPECT_LT((then_linear - linear).norm(), 1e-13 * scale) << c.name;
    EXPECT_LT((then_angular - angular).norm(), 1e-14 * scale) << c.name;  // arms of 0.1 m
  }
}

// All of the half kick where less of it would add more energy, else as much as keeps it.
TEST(Discontinuity, AsMuchOfTheHalfKickIsChangedAsKeepsTheEnergy) {
  for (const Case& c : kCases)
    for (const double towards : {1.0, -1.0}) {  // as it moves, and back
      const ShellModel m = sheet(c.yield_stress);
      ShellState s = moving(m, c.brittleness, c.heals);
      for (double& v : s.motion.v) v *= towards;
      insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318});
      release_interlocks(m, s, {}, true);
      compute_forces(m, s, true, 0.0, 1);
      const std::vector<double> then = s.motion.v, discontinuity = s.cracks.force_discontinuity;
      const EnergyBook book = s.book;
      apply_force_discontinuity({{&m, &s}}, kStep);
      double along = 0.0, all = 0.0;
      for (std::size_t k = 0; k < discontinuity.size(); ++k) {
        const double half = 0.5 * kStep * s.motion.inverse_mass[k % m.tables.component_stride] * discontinuity[k];
        along += half * (s.motion.v[k] - then[k]), all += half * half;
      }
      const double share = along / all;
      for (std::size_t k = 0; k < discontinuity.size(); ++k)
        EXPECT_NEAR(s.motion.v[k] - then[k],
                    share * 0.5 * kStep * s.motion.inverse_mass[k % m.tables.component_stride] * discontinuity[k],
                    1e-12 * largest(then));
      if (towards > 0.0) {
        EXPECT_NEAR(share, 1.0, 1e-9) << c.name;
      } else {
        EXPECT_GT(share, 0.5) << c.name;
        EXPECT_LT(share, 0.95) << c.name;
        EXPECT_LT(s.book.injected - book.injected + s.book.fracture - book.fracture, 1e-15) << c.name;
      }
    }
}

// What tips release beyond the cost of their edges opens the crack: motion gains it, and fracture has not taken it.
TEST(Discontinuity, TheSurplusOfTipsStaysMotion) {
  for (const Case& c : {kCases[0], kCases[1]})
    for (const double share : {0.1, 0.6, 1.0}) {
      const ShellModel m = sheet(c.yield_stress);
      ShellState s = moving(m);
      const double before = energy(m, s), fracture = s.book.fracture;
      insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318});
      const double released = s.cracks.released, kept = (1.0 - share) * released;
      ASSERT_GT(released, 1e-6 * before);
      s.cracks.taken = released, s.cracks.surplus = share * released;
      Vec3 momentum = Vec3::Zero(), then = Vec3::Zero();
      for (int i = 0; i < m.control_points(); ++i)
        momentum += s.motion.mass[m.tables.slot(i)] * s.velocity(m.tables.slot(i));
      EXPECT_NEAR(energy(m, s), before, 1e-10 * before) << c.name;
      EXPECT_NEAR(s.book.fracture - fracture, kept, 1e-9 * released) << c.name;
      EXPECT_NEAR(s.cracks.taken, kept, 1e-9 * released) << c.name;
      EXPECT_EQ(s.cracks.surplus, 0.0);
      for (int i = 0; i < m.control_points(); ++i)
        then += s.motion.mass[m.tables.slot(i)] * s.velocity(m.tables.slot(i));
      EXPECT_LT((then - momentum).norm(), 1e-12 * std::sqrt(before)) << c.name;  // of 1 kg at that energy, at most
    }
}

// No longer than a wave passes an element: what does not fit into that stays with the crack.
TEST(Discontinuity, FacesAreDrivenApartForThePassageOfAWaveAtMost) {
  const ShellModel m = sheet();
  ShellState s = moving(m);
  insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318});
  const std::vector<double> then = s.motion.v, discontinuity = s.cracks.force_discontinuity;
  const double much = 1e3 * s.cracks.released;
  s.cracks.released = s.cracks.taken = s.cracks.surplus = much;
  compute_forces(m, s, true, 0.0, 1);
  apply_force_discontinuity({{&m, &s}}, kStep);
  for (std::size_t k = 0; k < discontinuity.size(); ++k) {
    const double most = m.response_time() * s.motion.inverse_mass[k % m.tables.component_stride] * discontinuity[k];
    EXPECT_NEAR(then[k] - s.motion.v[k], most, 1e-12 * largest(then));
  }
  EXPECT_GT(s.cracks.taken, 0.5 * much);
}

// What half a kick gains is taken from what the same cracks have released; only where it is more has the crack added
// it.
TEST(Discontinuity, IsBookedAsInjectedAsFarAsItIsMoreThanTheCracksReleased) {
  const ShellModel m = sheet(0.0);
  double gained = 0.0;
  for (const double released : {0.0, 0.4, 2.0}) {  // of what is gained
    ShellState s = moving(m);
    s.book.fracture = 0.0;  // rounding of the first crack
    insert(m, s, {0.0333, 0.0342}, {0.0371, 0.0318});
    EXPECT_GT(s.cracks.released, 0.0);
    EXPECT_EQ(s.cracks.released, s.book.fracture);
    // a force that pulls on along the force discontinuity, which no share of it can make up for
    compute_forces(m, s, true, 0.0, 1);
    for (double& v : s.motion.v) v = 0.0;
    for (std::size_t k = 0; k < s.motion.force.size(); ++k) s.motion.force[k] = s.cracks.force_discontinuity[k];
    for (std::size_t k = 0; k < s.cracks.force_discontinuity.size(); ++k)
      s.motion.v[k] =
          -0.3 * kStep * s.motion.inverse_mass[k % m.tables.component_stride] * s.cracks.force_discontinuity[k];
    const double fracture = s.book.fracture, injected = s.book.injected;
    s.cracks.released = released * gained;
    apply_force_discontinuity({{&m, &s}}, kStep);
    const double added = s.book.injected - injected, lost = s.book.fracture - fracture;
    if (released == 0.0) {
      gained = added;
      EXPECT_GT(gained, 0.0);
    }
    EXPECT_NEAR(added, std::max(0.0, 1.0 - released) * gained, 1e-12 * gained);
    EXPECT_NEAR(added - lost, gained, 1e-9 * gained);  // the book closes in any case
    EXPECT_EQ(s.cracks.released, 0.0);
  }
}

// Control points that supports hold, tie together or drive, where cracks reach them.
TEST(Discontinuity, BesideSupportsTheBooksCloseToo) {
  const ShellModel m =
      sheet(0.0, {{.edges = kUMin},
                  {.edges = kUMax, .clamped = false, .motion = {{0.0, Vec3::Zero()}, {1e-3, Vec3(1e-4, 0, 5e-5)}}},
                  {.edges = kVMax, .symmetry = 1},
                  {.edges = kVMin, .clamped = false, .axes = {false, false, true}}});
  ASSERT_FALSE(m.constraints.driven.empty());
  for (const auto& [a, b] :
       {std::pair{Vec2(0.0012, 0.0342), Vec2(0.0062, 0.0318)}, std::pair{Vec2(0.0942, 0.0342), Vec2(0.0982, 0.0318)},
        std::pair{Vec2(0.0512, 0.0742), Vec2(0.0562, 0.0788)}, std::pair{Vec2(0.0512, 0.0012), Vec2(0.0562, 0.0058)}}) {
    ShellState s = moving(m);
    const double before = energy(m, s);
    insert(m, s, a, b);
    EXPECT_NEAR(energy(m, s), before, 1e-10 * before);
  }
}

// Beside a seam whose knots do not match: dependent points hand on what a crack has changed of their force.
TEST(Discontinuity, OverASeamItKeepsEnergyAndMomenta) {
  ShellMaterial material = glass();
  material.strength = 100e6, material.fracture_energy = 10.0;
  std::vector<ShellModel> models;
  for (const auto& [x, rows] : {std::pair{0.0, 16}, std::pair{0.1, 19}})
    models.push_back(make_shell(x == 0.0 ? "left" : "right",
                                plate(0.1, 0.08, 20, rows, Vec3(x, 0, 0), Quat::Identity()), 0.004, material, 2, 3,
                                {}));
  Stitched s(std::move(models));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-20.0, 20.0);
  for (double& v : s.state(0).motion.v) v = uniform(random);  // dependent points stay in place
  s.stitching().update_dependent_velocities(s.refs());
  const auto energy = [&] {
    const double stored = s.forces(true);
    apply_force_discontinuity(s.refs(), kStep);
    return stored + s.kinetic(kStep) + s.state(0).book.lost() + s.state(1).book.lost();
  };
  s.run(40, kStep);
  const double before = energy();
  const Stitched::Sums then = s.sums();
  for (int k = 0; k < 2; ++k) {
    const double x = k == 0 ? 0.0912 : 0.0021;
    ASSERT_GE(insert(s.model(k), s.state(k), {x, 0.0342}, {x + 0.0061, 0.0318}), 0);
    ASSERT_FALSE(s.state(k).cracks.force_discontinuity.empty());
  }
  EXPECT_NEAR(energy(), before, 1e-10 * before);
  const Stitched::Sums now = s.sums();
  EXPECT_LT((now.momentum - then.momentum).norm(), 1e-13 * now.momentum_scale);
  EXPECT_LT((now.angular - then.angular).norm(), 1e-13 * now.angular_scale);
}

TEST(Damping, LetsAModeDecayAtItsRate) {
  ShellMaterial material = glass();
  material.mass_damping = 400.0, material.stiffness_damping = 2e-6;
  const Support all{kUMin | kUMax | kVMin | kVMax, false};
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 12, 12, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {all});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  // first bending mode of a simply supported square, small: linear
  for (int i = 0; i < m.control_points(); ++i)
    if (!m.held[m.tables.slot(i)])
      s.motion.v[2 * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] =
          0.1 * std::sin(M_PI * m.parameter[i].x() / 0.2) * std::sin(M_PI * m.parameter[i].y() / 0.2);
  const double rigidity = 70e9 * std::pow(0.004, 3) / (12 * (1 - 0.22 * 0.22));
  const double omega = 2 * std::pow(M_PI / 0.2, 2) * std::sqrt(rigidity / (2500 * 0.004));
  const double dt = 0.5 * stable_step(m, s, 100, 1, false), end = 10 * 2 * M_PI / omega;
  double energy = 0.0, first = -1.0;
  // A substep by hand: kick and drift alone are asked, and the energy is that of the forces before them.
  for (double time = 0.0; time < end; time += dt) {
    energy = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
    if (first < 0.0) first = energy;
    const double before = energy + s.book.damping;
    kick(m, s, Vec3::Zero(), dt), drift(m, s, dt);
    compute_forces(m, s, false, 0.0, 1);
    ASSERT_LE(std::abs(before - first), 1e-5 * first);  // booked, but for 1e-10 J of round-off
  }
  // energy goes as exp(-(alpha + beta omega^2) t); omega of the grid is within 1 % of the plate's
  const double rate = 400.0 + 2e-6 * omega * omega;
  EXPECT_NEAR(std::log(first / energy), rate * end, 0.03 * rate * end);
}

// A support that moves a point along one axis replaces what damping takes from it there.
TEST(Damping, OfAMovingSupportIsItsWork) {
  ShellMaterial material = glass();
  material.mass_damping = 2e4, material.stiffness_damping = 1e-7;
  Support held{kUMin, false}, driven{kUMax, false};
  driven.axes = {false, false, true};
  driven.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(0.0, 0.0, 0.5)}};
  Rig rig(setup_of({{make_shell("p", plate(0.2, 0.1, 10, 5, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2,
                                {held, driven})}}),
          1);
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const double dt = 0.5 * stable_step(m, s, 100, 1, false);
  for (int k = 0; k < 3000; ++k) rig.step(dt);
  const double left = compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
  EXPECT_GT(s.book.damping, 0.1 * s.book.external);
  EXPECT_NEAR(s.book.external - s.book.damping, left, 1e-3 * s.book.external);
}

// What supports hold along one axis, or tie together, loses what its motion loses, and that is what the book has.
TEST(Damping, OfHeldAxesAndOfTiedPointsIsWhatTheirMotionLoses) {
  ShellMaterial material = glass();
  material.mass_damping = 400.0, material.stiffness_damping = 2e-7;
  Support mirrored{kUMin, false}, along_z{kUMax, false};
  mirrored.symmetry = 0, along_z.axes = {false, false, true};
  const ShellModel m = make_shell("p", plate(0.2, 0.1, 8, 4, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2,
                                  {mirrored, along_z});
  ASSERT_FALSE(m.constraints.tied[2].empty());
  ASSERT_FALSE(m.constraints.held[2].empty());
  ShellState s = make_state(m, Vec3::Zero(), 1);
  for (std::size_t k = 0; k < s.motion.v.size(); ++k)
    if (s.motion.inverse_mass[k % m.tables.component_stride] > 0.0) s.motion.v[k] = 0.01 * std::sin(1.7 * (k + 1.0));
  const double dt = 0.5 * stable_step(m, s, 100, 1, false);
  constrain(m, s, dt);
  const auto energy = [&] { return compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt); };
  const double first = energy();
  double last = first;
  for (int k = 0; k < 2000; ++k) {
    last = energy();
    ASSERT_LE(std::abs(last + s.book.damping - first), 1e-4 * first) << k;
    kick(m, s, Vec3::Zero(), dt), constrain(m, s, dt), drift(m, s, dt);
    compute_forces(m, s, false, 0.0, 1);
  }
  EXPECT_GT(s.book.damping, 0.3 * first);
}
