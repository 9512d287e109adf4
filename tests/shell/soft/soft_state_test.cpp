// Soft bodies of particles: what transfers and contact keep, waves, statics, bounces.
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::soft_blocks;

TEST(SoftModel, WeighsWhatItsShapeDoes) {
  const double r = 0.05, ball = 4.0 / 3.0 * std::numbers::pi * r * r * r;
  for (const double spacing : {0.02, 0.011, 0.005}) {
    const SoftModel m = make_soft("ball", rubber(), SphereShape{r}, at({1, 2, 3}), spacing, 2 * spacing);
    double mass = 0.0;
    Vec3 centre = Vec3::Zero();
    for (int p = 0; p < m.particles(); ++p) mass += m.mass[p], centre += m.mass[p] * m.rest[p];
    EXPECT_NEAR(mass, 1000.0 * ball, 0.06 * 1000.0 * ball * spacing / 0.02);  // a quarter of a cell at the surface
    EXPECT_NEAR((centre / mass - Vec3(1, 2, 3)).norm(), 0.0, 1e-12);
  }
  const SoftModel m = block({0.05, 0.03, 0.02}, at(Vec3::Zero()), 0.01).model;
  EXPECT_EQ(m.particles(), 10 * 6 * 4);
  EXPECT_EQ(m.surface.size(), 2u * (10 * 6 + 6 * 4 + 10 * 4));  // a face each: edges have two, corners three
  for (const SoftSurface& f : m.surface) EXPECT_NEAR(f.depth, 0.005, 1e-12);
}

// Velocities that are linear over space pass through the grid unchanged, and forces are none at rest.
TEST(SoftState, TransfersKeepWhatIsLinear) {
  SoftSetup b = block({0.05, 0.03, 0.02}, at({0.003, 0.007, 0.011}), 0.01, {1, 2, 3}, {4, -5, 6});
  SoftState s = make_soft_state(b.model, b.velocity, b.angular);
  const SoftState before = s;
  to_grid(b.model, s, Vec3::Zero(), 1e-12, 2), from_grid(b.model, s, 1e-12, 2);
  for (std::size_t p = 0; p < s.motion.x.size(); ++p) {
    EXPECT_LT((s.motion.v[p] - before.v[p]).norm(), 1e-12 * 10);
    EXPECT_LT((s.motion.affine[p] - before.affine[p]).norm(), 1e-10);
  }
  EXPECT_NEAR(s.book.transfer, 0.0, 1e-12);
}

// A spinning block of rubber keeps momentum and angular momentum to round-off, energy with its book.
TEST(SoftState, SpinKeepsAngularMomentum) {
  const SoftSetup b = block({0.05, 0.03, 0.02}, at({0.2, 0.1, 0}), 0.01, {1, 0, 0.5}, {30, 10, 60});
  SoftBodies soft({b}, 0, laws(0.5));
  const SoftSums start = soft.sums(Vec3::Zero());
  std::vector<Proxy> nobody;
  const double dt = 0.5 * soft.stable_step();
  for (int k = 0; k < 500; ++k) soft.step(Vec3::Zero(), dt, 0.8, nobody);
  const SoftSums end = soft.sums(Vec3::Zero());
  EXPECT_LT((end.momentum - start.momentum).norm(), 1e-13 * 500 * start.momentum_scale);
  EXPECT_LT((end.angular - start.angular).norm(), 1e-13 * 500 * start.angular_scale);
  EXPECT_NEAR(books(soft, Vec3::Zero()) / start.kinetic, 1.0, 1e-3);
}

TEST(SoftState, IsTheSameForOneAndThreeThreads) {
  std::vector<SoftState> ends;
  for (const int threads : {1, 3}) {
    const SoftSetup b = block({0.05, 0.03, 0.02}, at({0.2, 0.1, 0.0201}), 0.01, {1, 0, -2}, {30, 10, 60});
    SoftBodies soft({b}, 0, laws(0.5));
    std::vector<Proxy> bodies = ground();
    const double dt = 0.5 * soft.stable_step();
    for (int k = 0; k < 100; ++k) {
      soft.begin({0, 0, -9.81}, dt, 1, 0.8, bodies, {}, threads);
      soft.finish(threads);
    }
    ends.push_back(soft.states()[0]);
  }
  EXPECT_EQ(0, std::memcmp(ends[0].x.data(), ends[1].x.data(), ends[0].x.size() * sizeof(Vec3)));
  EXPECT_EQ(0, std::memcmp(ends[0].f.data(), ends[1].f.data(), ends[0].f.size() * sizeof(Mat3)));
  EXPECT_EQ(ends[0].book.transfer, ends[1].book.transfer);
}

// The bound that steps are taken by is below what power iteration finds, however the body lies in its grid.
TEST(SoftState, StaysBelowTheStableStep) {
  for (int k = 0; k < 6; ++k) {
    const Quat turn(Eigen::AngleAxisd(0.37 * k, Vec3(1, 0.3 * k, 0.5).normalized()));
    const SoftModel m = block({0.05, 0.03, 0.02}, at(0.0013 * k * Vec3(1, 2, 3), turn), 0.01).model;
    SoftState s = make_soft_state(m, Vec3::Zero(), Vec3::Zero());
    // Velocities on particles; what one step of `dt` makes of the grid's is v - dt^2 M^-1 K v.
    const double tiny = 1e-7;
    std::vector<Vec3> mode;
    double lambda = 0.0;
    to_grid(m, s, Vec3::Zero(), 0.0, 1);
    for (std::size_t n = 0; n < s.grid.mass.size(); ++n) {
      const double a = static_cast<double>(n);
      mode.emplace_back(std::sin(12.9898 * a), std::sin(78.233 * a), std::sin(37.719 * a));
    }
    for (int it = 0; it < 200; ++it) {
      double norm = 0.0;
      for (std::size_t n = 0; n < mode.size(); ++n) {
        if (s.grid.mass[n] <= 0.0) mode[n].setZero();
        norm += s.grid.mass[n] * mode[n].squaredNorm();
      }
      norm = std::sqrt(norm);
      SoftState moved = s;
      for (std::size_t n = 0; n < mode.size(); ++n) mode[n] /= norm, moved.grid.v[n] = mode[n];
      from_grid(m, moved, 0.0, 1);  // the gradient, without moving
      for (std::size_t p = 0; p < moved.f.size(); ++p) moved.f[p] += tiny * moved.affine[p] * moved.f[p];
      for (auto& a : moved.affine) a.setZero();
      for (auto& v : moved.v) v.setZero();
      to_grid(m, moved, Vec3::Zero(), 0.0, 1);
      double sum = 0.0;
      for (std::size_t n = 0; n < mode.size(); ++n) {
        mode[n] = -moved.grid.acceleration[n] / tiny;
        sum += s.grid.mass[n] * mode[n].squaredNorm();
      }
      lambda = std::sqrt(sum);
    }
    const double stable = 2.0 / std::sqrt(lambda);
    EXPECT_LT(soft_stable_step(m, s), stable);
  }
}

TEST(SoftState, WavesRunAtTheirSpeed) { EXPECT_NEAR(wave_speed(0.01), 1.0, 0.02); }  // order 2: 0.2 % there

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
