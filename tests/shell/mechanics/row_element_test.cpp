// The kernels of one row of elements, called one row at a time.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/mechanics/row_element.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

struct RowOfForces {
  RowSums sums;
  std::vector<double> force;  // [control row][x y z][stride]
  Vec3 total(const RowTables& t) const {
    Vec3 sum = Vec3::Zero();
    for (int j = 0; j < t.support(); ++j)
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < t.stride; ++i) sum[c] += force[(j * 3 + c) * t.stride + i];
    return sum;
  }
  double largest() const {
    double out = 0.0;
    for (const double f : force) out = std::max(out, std::abs(f));
    return out;
  }
};

RowOfForces one_row(const ShellModel& m, const std::vector<double>& x, int row, bool energy,
                    const SurfaceStress& stress = {}) {
  const RowTables& t = m.tables;
  const LayerMemory memory;
  RowScratch scratch;
  const RowFunction f = t.varies()      ? varying_row(t.degree, memory, energy, stress.values != nullptr)
                        : t.degree == 3 ? cubic_row(t.rational, memory, energy, stress.values != nullptr)
                                        : quadratic_row(t.rational, memory, energy, stress.values != nullptr);
  RowOfForces out;
  out.force.assign(static_cast<std::size_t>(3) * t.support() * t.stride, 7.0);  // overwritten
  const double* const weighted = homogeneous(t, x, scratch);
  out.sums = f(t, weighted, stress, memory, row, out.force.data());
  return out;
}

ShellModel plate_of_rows(int degree) {
  return make_shell("p", plate(0.5, 0.4, 11, 4, Vec3::Zero(), Quat::Identity(), degree), 0.01, glass(), 2, degree, {});
}

std::vector<double> stretched_along_u(const ShellModel& m, double strain) {
  std::vector<double> x = m.rest;
  for (int k = 0; k < m.tables.component_stride; ++k) x[k] *= 1.0 + strain;
  return x;
}

}  // namespace

TEST(ElementRow, AtRestThereIsNoForceAndNoEnergy) {
  for (const int degree : {2, 3}) {
    const ShellModel m = plate_of_rows(degree);
    const double scale = one_row(m, stretched_along_u(m, 1e-3), 1, true).largest();
    ASSERT_GT(scale, 0.0);
    const RowOfForces rest = one_row(m, m.rest, 1, true);
    EXPECT_LT(rest.largest(), 1e-9 * scale);  // 1e-3 of strain against round-off of it
    EXPECT_LT(std::abs(rest.sums.energy), 1e-12 * one_row(m, stretched_along_u(m, 1e-3), 1, true).sums.energy);
  }
}

TEST(ElementRow, HasTheEnergyOfItsOwnArea) {
  const double strain = 1e-5, poisson = 0.22;
  const double density = 0.5 * 70e9 / (1.0 - poisson * poisson) * strain * strain * 0.01;  // [J/m^2]
  for (const int degree : {2, 3}) {
    const ShellModel m = plate_of_rows(degree);
    for (int row = 0; row < 4; ++row) {
      const RowOfForces found = one_row(m, stretched_along_u(m, strain), row, true);
      EXPECT_NEAR(found.sums.energy, density * 0.5 * 0.1, 1e-4 * density * 0.05) << degree;  // ten times the strain
      EXPECT_EQ(found.sums.booked, 0.0);
      EXPECT_EQ(one_row(m, stretched_along_u(m, strain), row, false).sums.energy, 0.0);
    }
  }
}

// A row stretched along u pulls its ends with the membrane force, and by nothing in sum.
TEST(ElementRow, ForcesSumToZeroAndArePlaneForAPlaneSheet) {
  for (const int degree : {2, 3}) {
    const ShellModel m = plate_of_rows(degree);
    const RowOfForces found = one_row(m, stretched_along_u(m, 1e-3), 2, false);
    EXPECT_LT(found.total(m.tables).norm(), 1e-12 * found.largest());
    double pull = 0.0;
    for (int j = 0; j < m.tables.support(); ++j) {
      pull += found.force[(j * 3) * m.tables.stride];
      for (int i = 0; i < m.tables.stride; ++i)
        EXPECT_NEAR(found.force[(j * 3 + 2) * m.tables.stride + i], 0.0, 1e-12 * found.largest());
    }
    const double exact = 70e9 / (1.0 - 0.22 * 0.22) * 1e-3 * 0.01 * 0.1;
    EXPECT_NEAR(pull, exact, 1e-2 * exact);  // ten times the strain
  }
}

TEST(ElementRow, WritesTheStressOfFacesAndWhereItIsOverTheStrength) {
  const ShellModel m = plate_of_rows(2);
  const RowTables& t = m.tables;
  const double strain = 1e-6, along = 70e9 / (1.0 - 0.22 * 0.22) * strain;
  std::vector<double> values(static_cast<std::size_t>(6) * t.blocks() * t.lanes, 0.0), least(t.blocks(), 2.0 * along);
  std::vector<char> over(t.blocks(), 7);
  least[t.gauss * t.gauss] = 0.4 * along;  // the first block of row 1
  one_row(m, stretched_along_u(m, strain), 1, false, {&values, 0.5, &least, &over});
  for (int block = 0; block < t.blocks(); ++block) {
    const bool own = block / (t.gauss * t.gauss) == 1;
    EXPECT_EQ(over[block], !own ? 7 : block == t.gauss * t.gauss ? 1 : 0);
    for (const int face : {0, 3})  // half of the new value is in the mean
      EXPECT_NEAR(values[t.at(block, 6, face, 2)], own ? 0.5 * along : 0.0, 1e-5 * along);
  }
}

TEST(ElementRow, EnergiesOfRowsAreThatOfThePatch) {
  for (const Patch& patch : {rational_patch(), cubic_patch()}) {
    const ShellModel m = make_shell("p", patch, 0.02, glass(), 3, 4, {});
    ASSERT_TRUE(m.tables.rational);
    ShellState s = make_state(m, Vec3::Zero(), 0);
    disturb(s, m, 5e-3);
    RowScratch scratch;
    std::vector<double> force(s.motion.x.size());
    const double whole = row_forces(m.tables, {s.motion.x, true}, {}, scratch, force);
    double sum = 0.0;
    for (int row = 0; row < m.tables.spans_v; ++row) sum += one_row(m, s.motion.x, row, true).sums.energy;
    EXPECT_GT(whole, 0.0);
    EXPECT_NEAR(sum, whole, 1e-14 * whole);
  }
}
