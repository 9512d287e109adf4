// The grid that layers with fibres share.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shell/contact/fibre_grid.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(FibreGrid, LayersHaveTheGradientBetweenThemAtAnySpacing) {
  for (const double spacing : {0.02, 0.05, 0.2}) {
    FibreGrid grid(spacing, {{1, 0}, {0, 1}});
    std::vector<LayerSample> samples;
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j)
        for (const int shell : {0, 1}) {
          LayerSample q;
          q.x = q.rest = Vec3(0.01 * i, 0.01 * j, 0.0137 + 0.009 * shell);
          q.v = Vec3(3.0 * shell, 0, -2.0 * shell);
          q.normal = Vec3::UnitZ(), q.gradient = Mat3::Zero();
          q.mass = shell == 0 ? 1.0 : 0.3, q.area = 1e-4, q.thickness = 0.01, q.shell = shell;
          samples.push_back(q);
        }
    ASSERT_TRUE(grid.find(samples));
    const LayerSample &low = samples[2 * (30 * 60 + 30)], &high = samples[2 * (30 * 60 + 30) + 1];
    EXPECT_EQ(low.share[0], 0.0);
    EXPECT_EQ(high.share[1], 0.0);
    // spread of 2 % of the thickness against a variance of m1 m2 / (m1 + m2)^2 d^2: 0.0028; nodes that only one layer
    // reaches have (d/h)^2 / 2 of its weight, and those that one of them nearly leaves have some
    const double exact = 1.0 / 0.009, near = 0.003 + 0.7 * std::pow(0.009 / spacing, 2);
    for (const Mat3& l : {low.together[1], high.together[0]}) {
      EXPECT_NEAR(l(2, 2), -2.0 * exact, 2.0 * exact * near) << spacing;
      EXPECT_NEAR(l(0, 2), 3.0 * exact, 3.0 * exact * near) << spacing;
    }
  }
}

TEST(FibreGrid, ALayerBetweenTwoOthersIsPressedByOneAndLeavesTheOther) {
  FibreGrid grid(0.05, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  std::vector<LayerSample> samples;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j)
      for (const int shell : {0, 1, 2}) {
        LayerSample q;
        q.x = q.rest = Vec3(0.02 * i, 0.02 * j, 0.0137 + 0.009 * shell);
        q.v = Vec3(0, 0, shell == 1 ? 1.0 : 0.0);
        q.normal = Vec3::UnitZ(), q.gradient = Mat3::Zero();
        q.mass = 1.0, q.area = 4e-4, q.thickness = 0.01, q.shell = shell;
        samples.push_back(q);
      }
  ASSERT_TRUE(grid.find(samples));
  const LayerSample& middle = samples[3 * (15 * 30 + 15) + 1];
  const double exact = 1.0 / 0.009, near = 0.002 + 0.7 * std::pow(0.009 / 0.05, 2);  // as above
  EXPECT_NEAR(middle.together[0](2, 2), exact, near * exact);
  EXPECT_NEAR(middle.together[1](2, 2), -exact, near * exact);
}

TEST(FibreGrid, WhatIsFurtherApartThanItsThicknessDoesNotKnowOfIt) {
  for (const double gap : {-1e-6, 1e-6}) {
    FibreGrid grid(0.1, {{1, 0}, {0, 1}});
    std::vector<LayerSample> samples;
    for (const int shell : {0, 1}) {
      LayerSample q;
      q.x = q.rest = Vec3(0.01, 0.02, (0.01 + gap) * shell);
      q.v = Vec3(0, 0, -2.0 * shell);
      q.normal = Vec3::UnitZ(), q.gradient = Mat3::Zero();
      q.mass = 1.0, q.area = 1e-4, q.thickness = 0.01, q.shell = shell;
      samples.push_back(q);
    }
    EXPECT_EQ(grid.find(samples), gap < 0.0);
  }
}
