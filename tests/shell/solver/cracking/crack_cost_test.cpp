// What an edge of a crack costs.
#include <algorithm>

#include <gtest/gtest.h>

#include "shell/solver/cracking/crack_cost.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// 8 J/m^2 over 4 mm: of a metre of a crack [J].
constexpr double kOfAMetre = 8.0 * 0.004;

CrackEdge edge(const Vec2& a, const Vec2& b, double resistance = 1.0) {
  CrackEdge e;
  e.a = a, e.b = b, e.resistance = resistance;
  return e;
}

}  // namespace

TEST(CrackCost, IsTheAreaTimesTheFractureEnergyAtItsSpeed) {
  const ShellModel m = brittle_sheet(10);
  EXPECT_NEAR(edge_cost(m, edge({0.05, 0.05}, {0.08, 0.09})), 0.05 * kOfAMetre, 1e-14);
  EXPECT_NEAR(edge_cost(m, edge({0.08, 0.09}, {0.05, 0.05}, 2.5)), 2.5 * 0.05 * kOfAMetre, 1e-14);
}

TEST(CrackCost, CountsNothingBeyondTheBorder) {
  const ShellModel m = brittle_sheet(10);
  EXPECT_NEAR(edge_cost(m, edge({0.18, 0.1}, {0.22, 0.1})), 0.02 * kOfAMetre, 1e-14);
  EXPECT_NEAR(edge_cost(m, edge({0.1, -0.03}, {0.1, 0.01})), 0.01 * kOfAMetre, 1e-14);
  EXPECT_NEAR(edge_cost(m, edge({-0.03, -0.04}, {0.03, 0.04})), 0.05 * kOfAMetre, 1e-14);  // through the corner
  EXPECT_NEAR(edge_cost(m, edge({0.1, 0.0}, {0.15, 0.0})), 0.05 * kOfAMetre, 1e-14);       // on the border
  EXPECT_EQ(edge_cost(m, edge({0.21, 0.1}, {0.23, 0.1})), 0.0);
}

TEST(CrackCost, GrowsWithTheSquareOfTheStrengthFactorAtItsMiddle) {
  ShellModel m = brittle_sheet(10);
  const int of_element = m.tables.gauss * m.tables.gauss;
  m.strength_factor.assign(static_cast<std::size_t>(m.tables.blocks()) * m.tables.lanes, 1.0f);
  for (int a = 0; a < of_element; ++a)  // the element of 2 cm that begins at (0.06, 0.04)
    m.strength_factor[static_cast<std::size_t>(2 * of_element + a) * m.tables.lanes + 3] = 1.5f;
  EXPECT_EQ(fracture_energy_at(m, {0.07, 0.05}), 2.25 * 8.0);
  EXPECT_EQ(fracture_energy_at(m, {0.05, 0.07}), 8.0);
  EXPECT_NEAR(edge_cost(m, edge({0.065, 0.05}, {0.077, 0.05})), 2.25 * 0.012 * kOfAMetre, 1e-14);
  EXPECT_NEAR(edge_cost(m, edge({0.075, 0.05}, {0.091, 0.05})), 0.016 * kOfAMetre, 1e-14);  // ends in it
}

TEST(CrackCost, IsThatOfThePliesAndNotOfTheInterlayer) {
  ShellModel m = brittle_sheet(10);
  m.material.interlayer.thickness = 0.001;
  EXPECT_NEAR(edge_cost(m, edge({0.05, 0.1}, {0.15, 0.1})), 0.75 * 0.1 * kOfAMetre, 1e-14);
}
