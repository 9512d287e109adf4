// Soft bodies of particles: what transfers keep, and waves.
#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/soft/soft_state.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::soft_blocks;

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
