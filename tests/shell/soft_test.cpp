// Soft bodies of particles: what transfers and contact keep, waves, statics, bounces.
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/soft/soft_bodies.h"
#include "shell/solver/handoff.h"
#include "shell/solver/stable_step.h"
#include "shell/solver/step.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

SoftMaterial rubber(double young = 1e6, double poisson = 0.3) { return {1000.0, young, poisson}; }

BodyMotion at(const Vec3& x, const Quat& q = Quat::Identity()) {
  BodyMotion m;
  m.position = x, m.orientation = q;
  return m;
}

SoftSetup block(const std::string& name, const Vec3& half, const BodyMotion& pose, double spacing,
                const Vec3& velocity = Vec3::Zero(), const Vec3& angular = Vec3::Zero(),
                const SoftMaterial& material = rubber()) {
  return {make_soft(name, material, BoxShape{half}, pose, spacing, 2.0 * spacing, 8.0 * half.prod()), velocity,
          angular};
}

Proxy floor_at(double z) {
  RigidBody b;
  b.id = 1, b.name = "floor", b.is_static = true, b.shape = HalfSpaceShape{}, b.motion.position.z() = z;
  return Proxy(b);
}

std::vector<ContactLaw> laws(std::uint32_t groups, double friction) {
  std::vector<ContactLaw> out;
  for (std::uint32_t a = 0; a < groups; ++a)
    for (std::uint32_t b = a; b < groups; ++b) out.push_back({a, b, friction, 0.0});
  return out;
}

double books(const SoftBodies& s, const Vec3& gravity) {
  const SoftSums sums = s.sums(gravity);
  return sums.kinetic + sums.elastic + sums.potential + s.book().lost();
}

}  // namespace

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
  const SoftModel m = block("block", {0.05, 0.03, 0.02}, at(Vec3::Zero()), 0.01).model;
  EXPECT_EQ(m.particles(), 10 * 6 * 4);
  EXPECT_EQ(m.surface.size(), 2u * (10 * 6 + 6 * 4 + 10 * 4));  // a face each: edges have two, corners three
  for (const SoftSurface& f : m.surface) EXPECT_NEAR(f.depth, 0.005, 1e-12);
}

// Velocities that are linear over space pass through the grid unchanged, and forces are none at rest.
TEST(SoftState, TransfersKeepWhatIsLinear) {
  SoftSetup b = block("block", {0.05, 0.03, 0.02}, at({0.003, 0.007, 0.011}), 0.01, {1, 2, 3}, {4, -5, 6});
  SoftState s = make_soft_state(b.model, b.velocity, b.angular);
  const SoftState before = s;
  to_grid(b.model, s, Vec3::Zero(), 1e-12, 2), from_grid(b.model, s, 1e-12, 2);
  for (std::size_t p = 0; p < s.x.size(); ++p) {
    EXPECT_LT((s.v[p] - before.v[p]).norm(), 1e-12 * 10);
    EXPECT_LT((s.affine[p] - before.affine[p]).norm(), 1e-10);
  }
  EXPECT_NEAR(s.book.transfer, 0.0, 1e-12);
}

// A spinning block of rubber keeps momentum and angular momentum to round-off, energy with its book.
TEST(SoftState, SpinKeepsAngularMomentum) {
  const SoftSetup b = block("block", {0.05, 0.03, 0.02}, at({0.2, 0.1, 0}), 0.01, {1, 0, 0.5}, {30, 10, 60});
  SoftBodies soft({b}, 0, laws(1, 0.5));
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
    const SoftSetup b = block("block", {0.05, 0.03, 0.02}, at({0.2, 0.1, 0.0201}), 0.01, {1, 0, -2}, {30, 10, 60});
    SoftBodies soft({b}, 0, laws(2, 0.5));
    std::vector<Proxy> bodies{floor_at(0.0)};
    bodies[0].body.contact_group = 1;
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
    const SoftModel m = block("block", {0.05, 0.03, 0.02}, at(0.0013 * k * Vec3(1, 2, 3), turn), 0.01).model;
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

// A bar that cannot widen, in its first mode along: a half period is length over sqrt((lambda + 2 mu) / rho).
TEST(SoftState, WavesRunAtTheirSpeed) {
  const double length = 0.4;
  const SoftSetup b = block("bar", {0.5 * length, 0.02, 0.02}, at({0.201, 0.003, 0.004}), 0.01);
  SoftState s = make_soft_state(b.model, Vec3::Zero(), Vec3::Zero());
  const double c = b.model.material.wave_speed(), k = std::numbers::pi / length,
               dt = 0.8 * soft_stable_step(b.model, s);
  const auto phase = [&](std::size_t p) { return k * (b.model.rest[p].x() - 0.001); };
  for (std::size_t p = 0; p < s.x.size(); ++p) {
    s.v[p].x() = 1e-3 * c * std::cos(phase(p));
    s.affine[p](0, 0) = -1e-3 * c * k * std::sin(phase(p));
  }
  double time = 0.0, last = 1.0, crossed = 0.0;
  for (int crossings = 0; crossings < 3;) {
    to_grid(b.model, s, Vec3::Zero(), dt, 1);
    for (Vec3& v : s.grid.v) v.y() = v.z() = 0.0;
    from_grid(b.model, s, dt, 1);
    double now = 0.0;
    for (std::size_t p = 0; p < s.x.size(); ++p) now += b.model.mass[p] * s.v[p].x() * std::cos(phase(p));
    if (now * last < 0.0) crossed = time - 0.5 * dt + dt * last / (last - now), ++crossings;
    last = now, time += dt;
  }
  const double speed = 2.5 * length / crossed;  // two and a half half periods
  EXPECT_NEAR(speed / c, 1.0, 0.02);
}

// A bar without lateral contraction against a wall: it leaves after twice the time that a wave takes along it, as fast
// as it came and without vibration.
TEST(SoftContact, ABarBouncesOffAWall) {
  const double length = 0.2, speed = 0.5;
  const SoftSetup b = block("bar", {0.02, 0.02, 0.5 * length}, at({0, 0, 0.5 * length + 0.001}), 0.01, {0, 0, -speed},
                            Vec3::Zero(), rubber(1e6, 0.0));
  SoftBodies soft({b}, 0, laws(2, 0.0));
  std::vector<Proxy> bodies{floor_at(0.0)};
  bodies[0].body.contact_group = 1;
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
  const SoftSetup b = block("block", {0.03, 0.03, 0.03}, at({0, 0, 0.03 + drop}), 0.0075);
  SoftBodies soft({b}, 0, laws(2, 0.5));
  std::vector<Proxy> bodies{floor_at(0.0)};
  bodies[0].body.contact_group = 1;
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

TEST(SoftContact, ABlockSagsUnderItsWeight) {
  const double height = 0.1, young = 2e5;
  const Vec3 gravity(0, 0, -9.81);
  const SoftSetup b = block("block", {0.02, 0.02, 0.5 * height}, at({0, 0, 0.5 * height}), 0.01, Vec3::Zero(),
                            Vec3::Zero(), rubber(young, 0.3));
  SoftBodies soft({b}, 0, laws(2, 0.0));
  std::vector<Proxy> bodies{floor_at(0.0)};
  bodies[0].body.contact_group = 1;
  double last = 0.0;
  const double dt = 0.8 * soft.stable_step();
  for (double t = 0.0; t < 0.6; t += dt) {
    soft.step(gravity, dt, 0.8, bodies);
    const double now = soft.sums(gravity).kinetic;
    if (now < last) {  // let go of the motion where it is fastest
      for (Vec3& v : soft.states()[0].v) v.setZero();
      for (Mat3& a : soft.states()[0].affine) a.setZero();
      last = 0.0;
    } else {
      last = now;
    }
  }
  const double sag = 0.5 * height - soft.sums(gravity).centre.z();  // rho g h^2 / 3E of the mean
  EXPECT_NEAR(sag / (1000 * 9.81 * height * height / (3 * young)), 1.0, 0.02);
}

// Two blocks that fly at one another, off their middles and turned: momentum and angular momentum to round-off.
TEST(SoftContact, ACollisionKeepsMomentumAndAngularMomentum) {
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(0, 0, 1)));
  SoftSetup a = block("low", {0.04, 0.04, 0.02}, at({0, 0, 0}), 0.01, {0.3, 0, 1}, {0, 3, 0});
  SoftSetup b = block("high", {0.03, 0.03, 0.03}, at({0.02, 0.01, 0.052}, turn), 0.0075, {0, 0, -2}, {5, 0, 0});
  b.model.contact_group = 1;
  SoftBodies soft({a, b}, 0, laws(2, 0.4));
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
    SoftBodies soft({ball}, 1, laws(2, 0.4));
    std::vector<Proxy> nobody;
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
    for (int k = 0, open = 0; k < steps; ++k) {
      compute_forces(sheet, s, false, 0.0, 1);
      kick(sheet, s, Vec3::Zero(), dt);
      if (open == 0) open = soft.begin(Vec3::Zero(), dt, steps - k, 0.8, nobody, shells, 1);
      soft.touch(shells, dt);
      constrain(sheet, s, dt), drift(sheet, s, dt);
      if (--open == 0) soft.finish(1);
    }
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
      SoftSetup box = block("block", {0.03, 0.03, 0.5 * height}, at({0, 0, 0.5 * height + 0.0015}), 0.006, {0, 0, -1});
      box.model.contact_group = 1;
      SoftBodies soft({box}, 1, laws(2, 0.3));
      std::vector<Proxy> nobody;
      const double dt = 0.8 * stable_step(sheet, s, 80, 1, false);
      const int steps = static_cast<int>(0.03 / dt);
      const std::vector<ShellRef> shells{{&sheet, &s}};
      for (int k = 0, open = 0; k < steps; ++k) {
        compute_forces(sheet, s, false, 0.0, 1);
        kick(sheet, s, Vec3::Zero(), dt);
        if (open == 0) open = soft.begin(Vec3::Zero(), dt, steps - k, 0.8, nobody, shells, 1);
        soft.touch(shells, dt);
        constrain(sheet, s, dt), drift(sheet, s, dt);
        if (--open == 0) soft.finish(1);
      }
      const SoftSums end = soft.sums(Vec3::Zero());
      EXPECT_GT(end.momentum.z() / end.mass, 0.05) << height << down;
      EXPECT_GT(end.centre.z(), 0.5 * height + 0.002) << height << down;
      EXPECT_GT(soft.states()[0].book.contact, 0.0) << height << down;
    }
}
