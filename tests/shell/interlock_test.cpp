#include "shell/solver/interlock.h"

#include <gtest/gtest.h>

#include "shell/solver/insertion.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A straight crack whose faces bear on one another.
void crack(const ShellModel& m, ShellState& s, const Vec2& a, const Vec2& b) {
  const int number = s.cracks.new_crack();
  const int pieces = static_cast<int>(std::ceil((b - a).norm() / m.spacing));
  int last = s.cracks.add_vertex(a);
  for (int k = 1; k <= pieces; ++k) {
    const int next = s.cracks.add_vertex(a + (b - a) * (static_cast<double>(k) / pieces));
    insert_edge(m, s, last, next, number, 0.0, 1, true);
    last = next;
  }
}

// Curved, unequal weights, enough control points on both sides of a crack.
ShellModel bent() {
  Patch p{KnotVector::uniform(9, 1.0), KnotVector::uniform(8, 0.9), {}, {}};
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i) {
      const double u = p.knots_u.greville(i), v = p.knots_v.greville(j);
      p.control_points.emplace_back(u, v + 0.1 * u * u, 0.2 * u * u - 0.1 * u * v);
      p.weights.push_back(1.0 + 0.1 * ((i + j) % 2));
    }
  return make_shell("p", p, 0.01, glass(), 2, 3, {});
}

ShellModel sheet() {
  return make_shell("p", plate(0.1, 0.08, 20, 16, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
}

// Moves everything right of x = 0.05, where the sheet is cut in two.
void part(const ShellModel& m, ShellState& s, const Vec3& by) {
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.05)
      for (int d = 0; d < 3; ++d) s.x[d * static_cast<std::size_t>(m.tables.plane) + m.tables.slot(i)] += by[d];
}

ShellState halves(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.05, -0.002}, {0.05, 0.082});
  return s;
}

}  // namespace

TEST(Interlock, StartsWithoutForceInABentSheetToo) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 1e-3);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  ASSERT_GT(s.interlocks.size(), 2u);
  for (const Interlock& lock : s.interlocks) EXPECT_TRUE(lock.holds);
  const double before = compute_forces(m, s, true, 0.0, 1);
  EXPECT_LT(s.interlock_energy, 1e-20 * before);
}

TEST(Interlock, ForceIsMinusTheGradientOfEnergy) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  disturb(s, m, 1e-3);
  compute_forces(m, s, true, 0.0, 1);
  ASSERT_GT(s.interlock_energy, 0.0);
  expect_gradient(m, s);
}

TEST(Interlock, BalancesForceAndTorque) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  disturb(s, m, 1e-3);
  s.force.assign(s.force.size(), 0.0);
  ASSERT_GT(interlock_forces(m, s), 0.0);
  const Balance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

TEST(Interlock, BearsPressureAndShearButNoTension) {
  const ShellModel m = sheet();
  const double k = m.material.youngs_modulus / m.spacing, gap = 1e-6;
  const struct {
    Vec3 by;
    double energy;  // of springs over the whole cut, 4 mm x 80 mm and the overhang of 4 mm
  } cases[] = {{{gap, 0, 0}, 0.0}, {{-gap, 0, 0}, 1.0}, {{0, gap, 0}, 1.0}, {{0, 0, gap}, 1.0}};
  for (const auto& c : cases) {
    ShellState s = halves(m);
    double area = 0.0;
    for (const Interlock& lock : s.interlocks) area += lock.area;
    EXPECT_NEAR(area, 0.004 * 0.08, 0.004 * m.spacing);
    part(m, s, c.by);
    compute_forces(m, s, true, 0.0, 1);
    EXPECT_NEAR(s.interlock_energy, c.energy * 0.5 * k * area * gap * gap, 1e-6 * k * area * gap * gap);
  }
}

TEST(Interlock, LetsGoWhenOpenedOrShearedTooFarAndBooksWhatItHeld) {
  const ShellModel m = sheet();
  const InterlockLaw law{1e-4, 1e6};
  const auto holding = [](const ShellState& s) {
    int n = 0;
    for (const Interlock& lock : s.interlocks) n += lock.holds;
    return n;
  };
  ShellState s = halves(m);
  const int all = holding(s);
  const double booked = s.book.fracture;
  part(m, s, {0.9e-4, 0, 0});
  compute_forces(m, s, true, 0.0, 1);
  release_interlocks(m, s, law, false);
  EXPECT_EQ(holding(s), all);
  part(m, s, {0.2e-4, 0, 0});
  compute_forces(m, s, true, 0.0, 1);
  release_interlocks(m, s, law, false);
  EXPECT_EQ(holding(s), 0);
  EXPECT_NEAR(s.book.fracture, booked, 1e-20);  // open faces hold nothing but round-off [J]
  s = halves(m);
  part(m, s, {0, 0, 1.1e6 * m.spacing / m.material.youngs_modulus});
  compute_forces(m, s, true, 0.0, 1);
  const double held = s.interlock_energy;
  release_interlocks(m, s, law, false);
  EXPECT_EQ(holding(s), 0);
  EXPECT_NEAR(s.book.fracture - booked, held, 1e-12 * held);
}

TEST(Interlock, KeepsItsEnergyWhenAnotherCrackCutsItsSight) {
  const ShellModel m = sheet();
  ShellState s = halves(m);
  part(m, s, {-1e-6, 0, 1e-6});
  compute_forces(m, s, true, 0.0, 1);
  const double before = s.interlock_energy;
  crack(m, s, {0.03, 0.041}, {0.0495, 0.0415});
  compute_forces(m, s, true, 0.0, 1);
  EXPECT_NEAR(s.interlock_energy, before, 1e-9 * before);  // the new crack's own springs start without force
}
