// Soft bodies that touch: bounces, statics, momentum.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/soft/soft_contact.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::soft_blocks;

// A bar without lateral contraction against a wall: it leaves after twice the time that a wave takes along it, as fast
// as it came and without vibration.
TEST(SoftContact, ABarBouncesOffAWall) {
  const double length = 0.2, speed = 0.5;
  const SoftSetup b = block({0.02, 0.02, 0.5 * length}, at({0, 0, 0.5 * length + 0.001}), 0.01, {0, 0, -speed},
                            Vec3::Zero(), rubber(1e6, 0.0));
  SoftBodies soft({b}, 0, laws(0.0));
  std::vector<Proxy> bodies = ground();
  const double c = b.model.material.wave_speed(), dt = 0.8 * soft.stable_step();
  const SoftSums start = soft.sums(Vec3::Zero());
  for (double t = 0.0; t < 0.001 / speed + 3.0 * length / c; t += dt) soft.step(Vec3::Zero(), dt, 0.8, bodies);
  const SoftSums end = soft.sums(Vec3::Zero());
  const Proxy& floor = bodies[0];
  EXPECT_LT((end.momentum - start.momentum + floor.linear_impulse).norm(), 1e-12 * start.momentum_scale);
  EXPECT_LT((floor.linear_impulse + floor.shell_linear).norm(), 1e-12 * floor.impulse_sum);
  EXPECT_LT((floor.angular_impulse + floor.shell_angular).norm(), 1e-12 * floor.moment_sum);
  EXPECT_NEAR(books(soft, Vec3::Zero()) / start.kinetic, 1.0, 2e-3);
  EXPECT_GT(end.momentum.z() / -start.momentum.z(), 0.85);
}

// Dropped, it comes back up.
TEST(SoftContact, ABlockBouncesOffTheFloor) {
  const Vec3 gravity(0, 0, -9.81);
  const double drop = 0.05;
  const SoftSetup b = block({0.03, 0.03, 0.03}, at({0, 0, 0.03 + drop}), 0.0075);
  SoftBodies soft({b}, 0, laws(0.5));
  std::vector<Proxy> bodies = ground();
  const SoftSums start = soft.sums(gravity);
  double highest = 0.0, dt = 0.8 * soft.stable_step(), worst = 0.0, time = 0.0;
  const double scale = start.mass * 9.81 * drop, first = books(soft, gravity);
  for (; time < 0.25; time += dt) {
    soft.step(gravity, dt, 0.8, bodies);
    if (time > 0.12) highest = std::max(highest, soft.sums(gravity).centre.z() - 0.03);
    worst = std::max(worst, std::abs(books(soft, gravity) - first));
  }
  const SoftSums end = soft.sums(gravity);
  const Vec3 expected =
      start.momentum + (time - 0.5 * soft.states()[0].dt) * start.mass * gravity - bodies[0].linear_impulse;
  EXPECT_LT((end.momentum - expected).norm(), 1e-11 * bodies[0].impulse_sum);
  EXPECT_LT(worst, 5e-3 * scale);
  EXPECT_GT(highest, 0.4 * drop);  // a flat face hits at once: much is left as vibration, which the grid damps
  EXPECT_LT(highest, drop);
}

TEST(SoftContact, ABlockSagsUnderItsWeight) { EXPECT_NEAR(sag(0.01), 1.0, 0.02); }

// Two blocks that fly at one another, off their middles and turned: momentum and angular momentum to round-off.
TEST(SoftContact, ACollisionKeepsMomentumAndAngularMomentum) {
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(0, 0, 1)));
  SoftSetup a = block({0.04, 0.04, 0.02}, at({0, 0, 0}), 0.01, {0.3, 0, 1}, {0, 3, 0});
  SoftSetup b = block({0.03, 0.03, 0.03}, at({0.02, 0.01, 0.052}, turn), 0.0075, {0, 0, -2}, {5, 0, 0});
  b.model.contact_group = 1;
  SoftBodies soft({a, b}, 0, laws(0.4));
  std::vector<Proxy> nobody;
  const double dt = 0.8 * soft.stable_step();
  const SoftSums start = soft.sums(Vec3::Zero());
  int touched = 0;
  const double low = soft_sums(soft.models()[0], soft.states()[0], Vec3::Zero()).momentum.z();
  for (int k = 0; k < 250; ++k) soft.step(Vec3::Zero(), dt, 0.8, nobody), touched += soft.book().contact > 0;
  const SoftSums end = soft.sums(Vec3::Zero());
  EXPECT_GT(touched, 0);
  EXPECT_LT(soft_sums(soft.models()[0], soft.states()[0], Vec3::Zero()).momentum.z(), -0.5 * low);  // thrown back
  EXPECT_LT((end.momentum - start.momentum).norm(), 1e-12 * start.momentum_scale);
  EXPECT_LT((end.angular - start.angular).norm(), 1e-12 * start.angular_scale);
  EXPECT_NEAR(books(soft, Vec3::Zero()) / start.kinetic, 1.0, 5e-3);
}

// A ball thrown at a free sheet, off its middle: what both keep together. Then at a clamped one, which stops it.
TEST(SoftContact, ABallOnASheetKeepsMomentum) {
  ShellMaterial film;
  film.density = 1200, film.youngs_modulus = 1e9, film.poisson_ratio = 0.3;
  Support clamp;
  clamp.edges = kUMin | kUMax | kVMin | kVMax;
  for (const bool held : {false, true}) {
    ShellModel sheet = make_shell("sheet", plate(0.3, 0.3, 14, 14, Vec3::Zero(), Quat::Identity()), 0.002, film, 2, 2,
                                  held ? std::vector<Support>{clamp} : std::vector<Support>{});
    ShellState s = make_state(sheet, Vec3::Zero(), 0);
    SoftSetup ball{make_soft("ball", rubber(5e5, 0.4), SphereShape{0.03}, at({0.02, 0.01, 0.033}), 0.006, 0.012),
                   {0.3, 0, -2},
                   {0, 5, 0}};
    ball.model.contact_group = 1;
    SoftBodies soft({ball}, 1, laws(0.4));
    const double dt = 0.8 * stable_step(sheet, s, 80, 1, false);
    const int steps = static_cast<int>(0.02 / dt);
    const std::vector<ShellRef> shells{{&sheet, &s}};
    const auto all = [&] {
      Totals t = totals(sheet, s);
      const SoftSums sums = soft.sums(Vec3::Zero());
      t.momentum += sums.momentum, t.angular += sums.angular;
      t.momentum_scale += sums.momentum_scale, t.angular_scale += sums.angular_scale;
      return t;
    };
    const auto energy = [&] {
      const double elastic = compute_forces(sheet, s, true, 0.0, 1);
      return elastic + kinetic_energy(sheet, s, dt) + s.book.lost() + books(soft, Vec3::Zero());
    };
    const Totals before = all();
    const double first = energy();
    for (int k = 0, open = 0; k < steps; ++k) substep(sheet, s, soft, shells, dt, steps - k, open);
    const Totals after = all();
    const SoftSums end = soft.sums(Vec3::Zero());
    EXPECT_NEAR(energy() / first, 1.0, 0.01);
    EXPECT_GT(end.centre.z(), 0.028 - (held ? 0.0 : 1.0));  // it has not passed through
    if (held) {
      EXPECT_GT(end.momentum.z(), 0.0);  // thrown back
      continue;
    }
    EXPECT_LT(end.momentum.z() / end.mass, 0.0);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-11 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-11 * before.angular_scale);
  }
}

// Faces that look along the sheet, or away from it, are no surface below it: a cube and a thin block leave again,
// whichever way the sheet's normal looks, and contact makes no energy.
TEST(SoftContact, BlocksLeaveASheetThatTheyHit) {
  ShellMaterial film;
  film.density = 1180, film.youngs_modulus = 3e9, film.poisson_ratio = 0.37;
  Support clamp;
  clamp.edges = kUMin | kUMax | kVMin | kVMax;
  const Quat turned(0.0, 1.0, 0.0, 0.0);
  for (const double height : {0.06, 0.012})
    for (const bool down : {false, true}) {
      const ShellModel sheet = make_shell(
          "sheet", plate(0.3, 0.3, 14, 14, Vec3::Zero(), down ? turned : Quat::Identity()), 0.002, film, 2, 2, {clamp});
      ShellState s = make_state(sheet, Vec3::Zero(), 0);
      SoftSetup box = block({0.03, 0.03, 0.5 * height}, at({0, 0, 0.5 * height + 0.0015}), 0.006, {0, 0, -1});
      box.model.contact_group = 1;
      SoftBodies soft({box}, 1, laws(0.3));
      const double dt = 0.8 * stable_step(sheet, s, 80, 1, false);
      const int steps = static_cast<int>(0.03 / dt);
      const std::vector<ShellRef> shells{{&sheet, &s}};
      for (int k = 0, open = 0; k < steps; ++k) substep(sheet, s, soft, shells, dt, steps - k, open);
      const SoftSums end = soft.sums(Vec3::Zero());
      EXPECT_GT(end.momentum.z() / end.mass, 0.05) << height << down;
      EXPECT_GT(end.centre.z(), 0.5 * height + 0.002) << height << down;
      EXPECT_GT(soft.states()[0].book.contact, 0.0) << height << down;
    }
}
