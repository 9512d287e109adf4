// What goes through the background grid.
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/grid/transfer.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

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
