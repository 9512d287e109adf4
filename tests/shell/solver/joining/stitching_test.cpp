// Shells that hang together along seams, in motion.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/io/probes.h"
#include "shell/solver/joining/stitching.h"
#include "shell/solver/stepping/kick_drift.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel model(const Patch& p, const std::string& name = "p", const std::vector<Support>& supports = {}) {
  return make_shell(name, p, 0.01, glass(), 2, p.degree(), supports);
}

}  // namespace

TEST(Stitching, ImpulsesKeepMomentumAndTheirWorkIsBooked) {
  Stitched s({model(flat(0, 1, 0, 1, 5, 5)), model(flat(1, 2, 0, 1, 5, 8)), model(flat(0, 1, 1, 2, 6, 5)),
              model(flat(1, 2, 1, 2, 5, 7))});
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto any = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); ++i) s.state(k).add_velocity(s.model(k).tables.slot(i), any());
  s.stitching().update_dependent_velocities(s.refs());
  const auto energy = [&] {
    double sum = 0.0;
    for (const ShellRef& r : s.refs())
      for (std::size_t i = 0; i < r.state->motion.mass.size(); ++i)
        sum += 0.5 * r.state->motion.mass[i] * r.state->velocity(static_cast<int>(i)).squaredNorm();
    return sum;
  };
  const auto before = s.sums();
  const double start = energy();
  s.stitching().store_velocities(s.refs());
  Vec3 given = Vec3::Zero(), turning = Vec3::Zero();
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); i += 2) {
      ShellState& state = s.state(k);
      const int slot = s.model(k).tables.slot(i);
      const Vec3 j = 0.1 * any();
      // as contact does: it knows the velocity before its impulse, and what the control point yields
      state.book.contact -= j.dot(state.velocity(slot)) + 0.5 * state.motion.inverse_mass[slot] * j.squaredNorm();
      state.add_velocity(slot, state.motion.inverse_mass[slot] * j);
      given += j, turning += state.position(slot).cross(j);
    }
  s.stitching().move_impulses(s.refs());
  const auto after = s.sums();
  EXPECT_LT((after.momentum - before.momentum - given).norm(), 1e-13 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular - turning).norm(), 1e-13 * before.angular_scale);
  double booked = 0.0;
  for (const ShellRef& r : s.refs()) booked += r.state->book.contact;
  EXPECT_NEAR(energy() + booked, start, 1e-12 * start);
}

TEST(Stitching, WorkOfWhatASupportDrivesAtTheEndOfASeamIsBookedOnce) {
  Support stand, pull;
  stand.edges = kVMin, stand.clamped = false, stand.axes = {false, true, true};
  pull.edges = kVMax, pull.clamped = false, pull.axes = {false, true, false};
  pull.motion = {{0.0, Vec3::Zero()}, {1e-3, Vec3(0, 1e-5, 0)}};
  Stitched s(
      {model(flat(0, 1, 0, 1, 5, 5), "left", {stand, pull}), model(flat(1, 2, 0, 1, 5, 8), "right", {stand, pull})});
  const double dt = 0.5 * s.stable();
  double scale = 0.0;
  for (int k = 0; k * dt < 1e-3; ++k) {
    double energy = s.forces(true) + s.kinetic(dt), booked = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      energy -= 0.5 * dt * external_power(s.model(i), s.state(i));
      booked += s.state(i).book.external;
    }
    scale = std::max(scale, energy);
    EXPECT_NEAR(energy, booked, 1e-6 * scale + 1e-12) << k;  // 0.2 if it were booked twice
    // supports bear what is left of the inner forces, which sum to zero
    double borne = 0.0, left = 0.0, size = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      const int stride = s.model(i).tables.component_stride;
      borne += reaction(s.model(i), s.state(i), Vec3::Zero()).y();
      std::vector<char> supported(stride, 0);
      for (const int slot : s.model(i).constraints.held[1]) supported[slot] = 1;
      for (const int slot : s.model(i).constraints.driven[0].slots[1]) supported[slot] = 1;
      for (int slot = 0; slot < stride; ++slot) {
        if (s.state(i).motion.mass[slot] == 0.0) continue;  // depends on others, which have its force
        const double force = s.state(i).motion.force[stride + slot];
        size += std::abs(force), left += supported[slot] ? 0.0 : force;
      }
    }
    EXPECT_NEAR(borne, left, 1e-9 * size + 1e-9) << k;
    s.step(dt);
  }
  EXPECT_GT(scale, 0.01);
}

TEST(Stitching, ReleaseKeepsMassMomentumAndAngularMomentum) {
  Stitched s({model(flat(0, 1, 0, 1, 5, 5)), model(flat(1, 2, 0, 1, 5, 8)), model(flat(0, 1, 1, 2, 6, 5))});
  double own = 0.0;
  for (const ShellRef& r : s.refs())
    for (const double mass : r.model->mass) own += mass;
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); ++i) {
      const int slot = s.model(k).tables.slot(i);
      const Vec3 x = s.state(k).position(slot);
      s.state(k).add_velocity(slot, Vec3(1, 2, 3) + Vec3(0.5, -1, 2).cross(x) + Vec3(0, 0, std::sin(9.0 * x.x())));
    }
  s.stitching().update_dependent_velocities(s.refs());
  const auto before = s.sums();
  EXPECT_NEAR(before.mass, own, 1e-13 * own);
  EXPECT_TRUE(s.stitching().release(s.refs(), [](int shell, int) { return shell == 1; }));
  const auto after = s.sums();
  EXPECT_NEAR(after.mass, before.mass, 1e-14 * before.mass);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-14 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-14 * before.angular_scale);
  int links = 0;
  s.stitching().each_link([&](int a, int, int b, int) { links += a == 1 || b == 1; });
  EXPECT_EQ(links, 0);
  s.stitching().each_link([&](int, int, int, int) { ++links; });
  EXPECT_GT(links, 0);  // the others hang together still
}

// Where knots match, a dependent point at a crease or a hinge is where its independent points are, to the seam's
// tolerance: no arm to turn by.
TEST(Stitching, ReleaseAtOnePlaceChangesNothing) {
  for (const Join join : {Join::kClamped, Join::kHinge}) {
    Stitched s({model(flat(0, 1, 0, 1, 12, 12)), model(plate(1.0, 1.0, 12, 12, Vec3(1.0, 0.5, 0.5),
                                                             Quat(Eigen::AngleAxisd(-1.5707963, Vec3::UnitY()))))},
               join);
    for (const ShellRef& r : s.refs())
      for (std::size_t i = 0; i < r.state->motion.mass.size(); ++i)
        r.state->add_velocity(static_cast<int>(i), Vec3(1, 0, 3));
    s.stitching().update_dependent_velocities(s.refs());
    const auto before = s.sums();
    EXPECT_TRUE(s.stitching().release(s.refs(), [](int, int) { return true; }));
    const auto after = s.sums();
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
    for (const ShellRef& r : s.refs())
      for (std::size_t i = 0; i < r.state->motion.mass.size(); ++i)
        EXPECT_LT(r.state->motion.mass[i] * (r.state->velocity(static_cast<int>(i)) - Vec3(1, 0, 3)).norm(), 1e-9);
  }
}

TEST(Stitching, CreasesKeepTheirAngleAndMakeNoMomentum) {
  for (const double degrees : {5.0, 40.0, 90.0, 160.0}) {
    const Quat bend(Eigen::AngleAxisd(-degrees * std::numbers::pi / 180.0, Vec3::UnitY()));
    Stitched s({model(flat(0, 1, 0, 1, 5, 4)), model(placed(flat(0, 1, 0, 1, 5, 6), Vec3(1, 0, 0), bend))});
    for (int i = 0; i < s.model(1).control_points(); ++i) {
      const int slot = s.model(1).tables.slot(i);
      const Vec3 arm = s.state(1).position(slot) - Vec3(1, 0, 0);
      s.state(1).add_velocity(slot, Vec3(0, 3.0, 0).cross(arm));  // opens the crease
    }
    s.stitching().update_dependent_velocities(s.refs());
    const auto before = s.sums();
    const auto angle = [&] {
      const auto normal = [&](int shell, double u) {
        std::vector<Vec3> net;
        for (int i = 0; i < s.model(shell).control_points(); ++i)
          net.push_back(s.state(shell).position(s.model(shell).tables.slot(i)));
        const SurfacePoint x = s.model(shell).patch.evaluate({u, 0.5}, net);
        return x.u.cross(x.v).normalized();
      };
      return std::acos(std::clamp(normal(0, 1.0).dot(normal(1, 0.0)), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    };
    const double dt = 0.5 * s.stable();
    double off = 0.0, most = 0.0;
    for (int k = 0; k < 2000; ++k) {
      s.step(dt);
      off = std::max(off, std::abs(angle() - degrees));
      most = std::max(most, (s.at(1, {1.0, 0.5}) - s.model(1).patch.evaluate({1.0, 0.5}).x).norm());
    }
    EXPECT_GT(most, 0.02);  // it does swing
    EXPECT_LT(off, 1.0) << degrees;
    const auto after = s.sums();
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
  }
}

TEST(Stitching, WhatASupportHoldsAtTheEndOfASeamIsHeldInBothShells) {
  Support hold;
  hold.clamped = false, hold.edges = kVMin;
  for (const bool second : {false, true})
    for (const int finer : {4, 8})  // knots of the one or of both: both sides are the same curve then
      for (const Join join : {Join::kClamped, Join::kHinge}) {
        Stitched s(
            {model(flat(0, 1, 0, 1, 4, 4), "a", second ? std::vector<Support>{} : std::vector<Support>{hold}),
             model(flat(1, 2, 0, 1, 4, finer), "b", second ? std::vector<Support>{hold} : std::vector<Support>{})},
            join);
        for (int k = 0; k < 2; ++k)
          for (int i = 0; i < s.model(k).control_points(); ++i) {
            const int slot = s.model(k).tables.slot(i);
            if (!s.model(k).held[slot]) s.state(k).add_velocity(slot, Vec3(0.3, 0.2, 1.0));
          }
        s.stitching().update_dependent_velocities(s.refs());
        const double dt = 0.5 * s.stable();
        s.run(500, dt);
        double apart = 0.0;
        for (int k = 0; k <= 20; ++k)
          apart = std::max(apart, (s.at(0, {1.0, k / 20.0}) - s.at(1, {0.0, k / 20.0})).norm());
        EXPECT_GT((s.at(1, {0.5, 0.9}) - Vec3(1.5, 0.9, 0.0)).norm(), 1e-4) << second << finer << int(join);
        EXPECT_LT(apart, 1e-13) << "second " << second << " elements " << finer;
        EXPECT_LT((s.at(0, {1.0, 0.0}) - Vec3(1.0, 0.0, 0.0)).norm(), 1e-13);
      }
}

TEST(Stitching, ASupportAlongASeamOfOneShellOnlyIsRefused) {
  Support hold;
  hold.edges = kUMax;
  try {
    Stitched s({model(flat(0, 1, 0, 1, 4, 4), "a", {hold}), model(flat(1, 2, 0, 1, 4, 6), "b")});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("a support of shell 'a' holds its seam with shell 'b'"), std::string::npos);
  }
}
