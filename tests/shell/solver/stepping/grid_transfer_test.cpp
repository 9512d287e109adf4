// The background grid: weights, blocks, and what goes through it.
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "shell/grid/kernel.h"
#include "shell/grid/transfer.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/grid_transfer.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(GridWeights, SumToOneAndReproduceThePlace) {
  for (const double x : {-7.3, -0.5, -1e-9, 0.0, 0.2, 0.5, 3.49999, 1e6 + 0.123}) {
    const Weights w = grid_weights(x);
    double sum = 0.0, place = 0.0, second = 0.0;
    for (int k = 0; k < kNodes; ++k) {
      EXPECT_GE(w.w[k], 0.0);
      sum += w.w[k], place += w.w[k] * (w.base + k - x), second += w.w[k] * std::pow(w.base + k - x, 2);
    }
    EXPECT_NEAR(sum, 1.0, 1e-15);
    EXPECT_NEAR(place, 0.0, 1e-9);    // of spacings; at 1e6 that is round-off of x
    EXPECT_NEAR(second, 0.25, 1e-9);  // what APIC divides by
  }
}

TEST(SparseGrid, GivesEachBlockOneIndexBelowZeroToo) {
  SparseGrid grid;
  for (int pass = 0; pass < 2; ++pass) {
    grid.clear();
    std::map<std::array<int, 3>, int> known;
    for (int i = -20; i < 20; i += 3)
      for (int j = -20; j < 20; j += 3)
        for (int k = -20; k < 20; ++k) {
          const std::array<int, 3> at{SparseGrid::block_of(i), SparseGrid::block_of(j), SparseGrid::block_of(k)};
          const int block = grid.block(at);
          const auto [known_block, fresh] = known.try_emplace(at, block);
          EXPECT_EQ(known_block->second, block);
          const int place = SparseGrid::place_of(i, j, k);
          EXPECT_TRUE(place >= 0 && place < SparseGrid::kBlock);
        }
    EXPECT_EQ(grid.nodes(), static_cast<int>(known.size()) * SparseGrid::kBlock);
  }
}

namespace {

struct Cloud {
  std::size_t count = 300;
  std::vector<double> mass, x, before, v, moving, affine;
  Cloud() {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (std::size_t i = 0; i < count; ++i) mass.push_back(i % 17 ? 1.5 + uniform(random) : 0.0);
    for (std::size_t i = 0; i < 3 * count; ++i) x.push_back(2.0 * uniform(random)), before.push_back(uniform(random));
    for (std::size_t i = 0; i < 3 * count; ++i) v.push_back(before[i] + 0.1 * uniform(random));
  }
  // APIC's own part of the angular momentum: mass times the kernel's second moment times the affine field
  void momenta(double spacing, Vec3& p, Vec3& l) const {
    p = l = Vec3::Zero();
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 at(x[i], x[count + i], x[2 * count + i]), u(v[i], v[count + i], v[2 * count + i]);
      p += mass[i] * u, l += mass[i] * at.cross(u);
      if (affine.empty()) continue;
      const auto c = [&](int d, int e) { return affine[(3 * d + e) * count + i]; };
      l += 0.25 * spacing * spacing * mass[i] * Vec3(c(2, 1) - c(1, 2), c(0, 2) - c(2, 0), c(1, 0) - c(0, 1));
    }
  }
};

}  // namespace

TEST(GridTransfer, KeepsMomentumAndWithApicAngularMomentum) {
  for (const Transfer kind : {Transfer::kFlip, Transfer::kApic, Transfer::kPic}) {
    Cloud cloud;
    TransferBuffers buffers;
    const double spacing = 0.37;
    Vec3 p, l, q, m;
    cloud.momenta(spacing, p, l);
    for (int pass = 0; pass < 3; ++pass) {
      transfer(kind, spacing, cloud.count, cloud.mass, cloud.x, cloud.before, 2, buffers, cloud.v, cloud.moving,
               cloud.affine);
      if (kind != Transfer::kApic) cloud.affine.clear();
      cloud.momenta(spacing, q, m);
      EXPECT_LT((q - p).norm(), 1e-12 * 450.0);  // of the sum of masses times speeds
      if (kind == Transfer::kApic) {
        EXPECT_LT((m - l).norm(), 1e-12 * 900.0);
      }
      cloud.before = cloud.v;
    }
  }
}

TEST(GridTransfer, LeavesRigidMotionAndGivesFlipItsGain) {
  Cloud cloud;
  TransferBuffers buffers;
  for (std::size_t i = 0; i < 3 * cloud.count; ++i) cloud.before[i] = 1.0, cloud.v[i] = 1.5;
  for (const Transfer kind : {Transfer::kFlip, Transfer::kApic, Transfer::kPic}) {
    Cloud own = cloud;
    transfer(kind, 0.2, own.count, own.mass, own.x, own.before, 1, buffers, own.v, own.moving, own.affine);
    for (std::size_t i = 0; i < 3 * own.count; ++i) {
      if (own.mass[i % own.count] == 0.0) continue;
      EXPECT_NEAR(own.v[i], 1.5, 1e-12);
      EXPECT_NEAR(own.moving[i], 1.5, 1e-12);
    }
  }
}

// Free flight: a shell that is thrown and spins through the grid loses what the books say.
TEST(GridTransfer, BooksWhatItLoses) {
  Support held, driven;
  held.edges = kUMin, held.clamped = false, held.axes = {true, false, true};
  driven.edges = kUMax, driven.clamped = false, driven.axes = {false, false, true};
  driven.motion = {{0.0, Vec3::Zero()}, {1e-4, Vec3(0, 0, 1e-4)}, {1.0, Vec3(0, 0, 1e-4)}};
  Load load;
  load.kind = Load::Kind::kPoint, load.point = Vec2(0.31, 0.17), load.force = Vec3(0, 30.0, 300.0);
  using Supports = std::vector<Support>;
  for (const bool loaded : {false, true})
    for (const auto& supports : {Supports{}, Supports{held}, Supports{held, driven}})
      for (const Transfer kind : {Transfer::kDirect, Transfer::kFlip, Transfer::kApic, Transfer::kPic}) {
        const ShellModel m = make_shell("p", plate(0.5, 0.4, 10, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2,
                                        2, supports, loaded ? std::vector<Load>{load} : std::vector<Load>{});
        ShellState s = make_state(m, Vec3(1, 0, 2), 0);
        const std::size_t plane = m.tables.plane;
        for (int i = 0; i < m.control_points(); ++i)
          s.motion.v[2 * plane + m.tables.slot(i)] += std::cos(12.0 * m.parameter[i].x());
        constrain(m, s, 1.0);
        if (kind != Transfer::kDirect) s.motion.before = s.motion.v;
        const TransferRules rules{kind, m.spacing, false};
        const double dt = 0.25 * stable_step(m, s, 100, 1, false);
        const auto energy = [&] { return compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt); };
        const double start = energy();
        for (int k = 0; k < 200; ++k) {
          compute_forces(m, s, false, 0.0, 1);
          kick(m, s, Vec3::Zero(), dt);
          through_grid(m, s, rules, dt, 2);
          constrain(m, s, dt);
          drift(m, s, dt);
        }
        // trapezoidal rule: second order in the step
        EXPECT_NEAR(energy() + s.book.lost(), start, 0.02 * start)
            << static_cast<int>(kind) << " " << supports.size() << loaded;
        if (supports.empty() && !loaded && kind != Transfer::kDirect) {
          EXPECT_GT(s.book.transfer, kind == Transfer::kFlip ? -0.01 * start : 0.001 * start);
        }
      }
}
