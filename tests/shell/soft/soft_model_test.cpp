#include <numbers>

#include <gtest/gtest.h>

#include "shell/soft/soft_model.h"
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
