#include "shell/solver/interlock.h"
#include "shell/solver/forces.h"

#include <utility>

#include <gtest/gtest.h>

#include "shell/solver/cracking/insertion.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A straight crack whose faces bear on one another.
void crack(const ShellModel& m, ShellState& s, const Vec2& a, const Vec2& b) {
  const int number = s.cracks.graph.new_crack();
  const int pieces = static_cast<int>(std::ceil((b - a).norm() / m.spacing));
  int last = s.cracks.graph.add_vertex(a);
  for (int k = 1; k <= pieces; ++k) {
    const int next = s.cracks.graph.add_vertex(a + (b - a) * (static_cast<double>(k) / pieces));
    insert_edge(m, s, last, next, number, 0.0, 1, true);
    last = next;
  }
}

void forces_of_faces(const ShellModel& m, ShellState& s) {
  std::vector<double> scratch;
  s.motion.force.assign(s.motion.force.size(), 0.0);
  add_point_forces(m.tables, {}, {s.motion.x}, {}, scratch, s.motion.force,
                   [&](int chunk, int chunks, const double* x4, double* force4) {
                     interlock_forces(m, s, false, chunk, chunks, x4, force4);
                   });
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

// Faces that close softly all through what disturb(1e-3) presses together.
void soften(ShellState& s) {
  for (Interlock& lock : s.cracks.interlocks) lock.depth = 5e-3;
}

ShellModel sheet() {
  ShellMaterial material = glass();
  material.strength = 100e6;
  return make_shell("p", plate(0.1, 0.08, 20, 16, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {});
}

// Moves everything right of x = 0.05, where the sheet is cut in two.
void part(const ShellModel& m, ShellState& s, const Vec3& by) {
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.05)
      for (int d = 0; d < 3; ++d) s.motion.x[d * static_cast<std::size_t>(m.tables.plane) + m.tables.slot(i)] += by[d];
}

ShellState halves(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.05, -0.002}, {0.05, 0.082});
  return s;
}

// Two parallel cracks and one from the one to the other. Returns the number of edges of the two.
int between_close_cracks(const ShellModel& m, ShellState& s) {
  crack(m, s, {0.047, 0.0203}, {0.047, 0.0603});
  crack(m, s, {0.055, 0.0203}, {0.055, 0.0603});
  const int parallel = static_cast<int>(s.cracks.graph.edges().size());
  crack(m, s, {0.047, 0.0403}, {0.055, 0.0403});
  return parallel;
}

}  // namespace

TEST(Interlock, StartsWithoutForceInABentSheetToo) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 1e-3);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  ASSERT_GT(s.cracks.interlocks.size(), 2u);
  for (const Interlock& lock : s.cracks.interlocks) EXPECT_TRUE(lock.holds);
  const double before = compute_forces(m, s, true, 0.0, 1);
  EXPECT_LT(s.cracks.interlock_energy, 1e-20 * before);
}

TEST(Interlock, ForceIsMinusTheGradientOfEnergy) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  soften(s);
  disturb(s, m, 1e-3);
  compute_forces(m, s, true, 0.0, 1);
  ASSERT_GT(s.cracks.interlock_energy, 0.0);
  expect_gradient(m, s);
}

TEST(Interlock, BalancesForceAndTorque) {
  const ShellModel m = bent();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.1, 0.3}, {0.9, 0.6});
  soften(s);
  disturb(s, m, 1e-3);
  forces_of_faces(m, s);
  ASSERT_GT(interlock_energy(s), 0.0);
  const Balance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

TEST(Interlock, BearsPressureAndShearButNoTension) {
  const ShellModel m = sheet();
  const double k = m.material.youngs_modulus / m.spacing, gap = 1e-6, soft = closing_depth(m);
  ASSERT_GT(soft, 0.0);
  ASSERT_LT(soft, 0.5 * gap);
  // the work of a force that grows by k s / soft over the first `soft` of an approach s, by k afterwards
  const double pressed = 0.5 * (gap - 0.5 * soft) * (gap - 0.5 * soft) + soft * soft / 24.0;
  const struct {
    Vec3 by;
    double energy;  // over k A
  } cases[] = {{{gap, 0, 0}, 0.0},
               {{-gap, 0, 0}, pressed},
               {{-0.5 * soft, 0, 0}, soft * soft / 48.0},
               {{0, gap, 0}, 0.5 * gap * gap},
               {{0, 0, gap}, 0.5 * gap * gap}};
  for (const auto& c : cases) {
    ShellState s = halves(m);
    double area = 0.0;  // of the whole cut, 4 mm x 80 mm and the overhang of 4 mm
    for (const Interlock& lock : s.cracks.interlocks) area += lock.area;
    EXPECT_NEAR(area, 0.004 * 0.08, 0.004 * m.spacing);
    part(m, s, c.by);
    compute_forces(m, s, true, 0.0, 1);
    EXPECT_NEAR(s.cracks.interlock_energy, c.energy * k * area, 1e-6 * k * area * (c.energy + soft * soft));
  }
}

// Two halves that are held outside beat against each other some 150 times, slowly and fast.
TEST(Interlock, BeatingFacesMakeNoEnergy) {
  const ShellModel m = sheet();
  constexpr int kSteps = 10000, kPart = 2000;
  for (const double speed : {0.5, 10.0}) {
    RunSetup setup = setup_of({{m}});
    setup.shells[0].fracture.mode = FractureMode::kTips;  // so that faces know where a substep begins
    Rig rig(std::move(setup));
    ShellState& s = rig.state() = halves(m);
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const double x = m.parameter[i].x(), y = m.parameter[i].y();
      if (x < 1e-6 || x > 0.1 - 1e-6) s.motion.inverse_mass[slot] = 0.0;
      s.motion.v[slot] = speed * (x < 0.05 ? x : x - 0.1) / 0.05 * (0.7 + 0.3 * std::cos(200.0 * y));
    }
    const double dt = 0.8 * stable_step(m, s, 100, 1, true);
    double first = 0.0, last = 0.0;  // sums of energies: each alone is off by what leapfrog keeps instead
    int closed = 0, changes = 0;
    for (int n = 0; n < kSteps; ++n) {
      rig.step(dt);
      int now = 0;
      for (const Interlock& lock : s.cracks.interlocks) now += lock.opening < 0.0;
      changes += now != closed, closed = now;
      if (n % 20 != 19 || (n >= kPart && n < kSteps - kPart)) continue;
      (n < kPart ? first : last) += compute_forces(m, s, true, 0.0, 1) + kinetic_energy(m, s, dt);
    }
    EXPECT_GT(changes, 2000);
    EXPECT_NEAR(last, first, 0.03 * first);  // without a depth of closing 10 % and 175 % more
  }
}

TEST(Interlock, LetsGoWhenOpenedOrShearedTooFarAndBooksWhatItHeld) {
  const ShellModel m = sheet();
  const InterlockLaw law{1e-4, 1e6};
  const auto holding = [](const ShellState& s) {
    int n = 0;
    for (const Interlock& lock : s.cracks.interlocks) n += lock.holds;
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
  const double held = s.cracks.interlock_energy;
  release_interlocks(m, s, law, false);
  EXPECT_EQ(holding(s), 0);
  EXPECT_NEAR(s.book.fracture - booked, held, 1e-12 * held);
}

TEST(Interlock, KeepsItsEnergyWhenAnotherCrackCutsItsVisibility) {
  const ShellModel m = sheet();
  ShellState s = halves(m);
  part(m, s, {-1e-6, 0, 1e-6});
  compute_forces(m, s, true, 0.0, 1);
  const double before = s.cracks.interlock_energy;
  crack(m, s, {0.03, 0.041}, {0.0495, 0.0415});
  compute_forces(m, s, true, 0.0, 1);
  EXPECT_NEAR(s.cracks.interlock_energy, before, 1e-9 * before);  // the new crack's own springs start without force
}

// Between two cracks 1.6 spacings apart no basis is sound enough for a Gauss point; faces there bear all the same.
TEST(Interlock, FacesBetweenCracksThatAreCloseBear) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  between_close_cracks(m, s);
  ASSERT_EQ(s.cracks.interlocks.size(), s.cracks.graph.edges().size());
  int planes = 0;
  for (const Interlock& lock : s.cracks.interlocks) {
    EXPECT_TRUE(lock.holds);
    for (const auto* side : {&lock.plus, &lock.minus}) {
      const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
      Vec2 at = Vec2::Zero();
      bool plane = true;
      for (const GatheredFunction& f : *side)
        at += f.n[0] * m.parameter_of_slot[f.slot], plane = plane && f.n[3] == 0.0;
      planes += plane;
      EXPECT_LT((at - 0.5 * (e.a + e.b)).norm(), 2e-3 * m.spacing);  // each side's face is where the crack is
    }
  }
  EXPECT_GT(planes, 0);
  disturb(s, m, 1e-5);
  ASSERT_GT(compute_forces(m, s, true, 0.0, 1), 0.0);
  ASSERT_GT(s.cracks.interlock_energy, 0.0);
  expect_gradient(m, s);
  forces_of_faces(m, s);
  const Balance b = balance(m, s);
  EXPECT_LT(b.force.norm(), 1e-12 * b.scale);
  EXPECT_LT(b.torque.norm(), 1e-11 * b.scale);
}

// Where little mass hangs on such faces their springs are as soft as the step stands.
TEST(Interlock, FacesBetweenCracksAreNoStifferThanTheirMassStands) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.047 && m.parameter[i].x() < 0.055)
      s.motion.mass[m.tables.slot(i)] *= 0.01, s.motion.inverse_mass[m.tables.slot(i)] *= 100.0;
  const int before = between_close_cracks(m, s);
  int soft = 0;
  for (const Interlock& lock : s.cracks.interlocks) {
    if (lock.edge < before) continue;
    double mobility = 0.0;
    for (const auto* side : {&lock.plus, &lock.minus})
      for (const GatheredFunction& f : *side) mobility += f.n[0] * f.n[0] * s.motion.inverse_mass[f.slot];
    // one spring between two masses: omega^2 = k A / m, in those of the fastest wave over a spacing
    const double omega = std::sqrt(lock.stiffness * lock.area * mobility) * m.spacing / m.wave_speed();
    EXPECT_LT(omega, 2.1);
    soft += lock.stiffness < 0.5 * m.material.youngs_modulus / m.spacing;
  }
  EXPECT_GT(soft, 0);
}

// What faces remember of their visibility is not in a checkpoint: whether they do, another crack leaves them the same.
TEST(Interlock, FacesThatRememberTheirVisibilityGoOnAsThoseThatLookAnew) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  crack(m, s, {0.05, -0.002}, {0.05, 0.082});
  disturb(s, m, 1e-5);
  ShellState anew = s;
  for (Interlock& lock : anew.cracks.interlocks)
    lock.looked = false, lock.visibility = lock.uses = {}, lock.planes = {};
  const std::vector<Interlock> before = s.cracks.interlocks;
  for (ShellState* state : {&s, &anew}) {  // ends beside the first, and later crosses it
    crack(m, *state, {0.03, 0.041}, {0.0495, 0.0415});
    crack(m, *state, {0.0495, 0.0415}, {0.062, 0.043});
  }
  ASSERT_EQ(s.cracks.interlocks.size(), anew.cracks.interlocks.size());
  int changed = 0, kept = 0;
  for (std::size_t i = 0; i < s.cracks.interlocks.size(); ++i) {
    const Interlock &a = s.cracks.interlocks[i], &b = anew.cracks.interlocks[i];
    EXPECT_EQ(a.holds, b.holds);
    EXPECT_EQ(a.stiffness, b.stiffness);
    EXPECT_EQ(a.rest, b.rest);
    for (const auto side : {&Interlock::plus, &Interlock::minus}) {
      const auto same = [](const std::vector<GatheredFunction>& p, const std::vector<GatheredFunction>& q) {
        return std::equal(p.begin(), p.end(), q.begin(), q.end(),
                          [](const auto& f, const auto& g) { return f.slot == g.slot && f.n == g.n; });
      };
      EXPECT_TRUE(same(a.*side, b.*side)) << "edge " << a.edge;
      if (i < before.size()) (same(a.*side, before[i].*side) ? kept : changed) += 1;
    }
  }
  EXPECT_EQ(s.book.fracture, anew.book.fracture);
  EXPECT_GT(changed, 0);
  EXPECT_GT(kept, 0);
}
