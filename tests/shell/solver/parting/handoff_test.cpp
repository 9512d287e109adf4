#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/prisms.h"
#include "tests/shell/torn_fibres.h"

using namespace sunder;
using namespace sunder::shell;
using sunder::test::volume_of_prisms;

TEST(HandOff, CarriesMassMomentumAndAngularMomentum) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.05, 0.05}, {0.13, 0.06}, {0.12, 0.14}, {0.06, 0.13}, {0.05, 0.05}}, 0.0);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < m.control_points(); ++i)
    s.add_velocity(m.tables.slot(i), Vec3(uniform(random), uniform(random), 3.0 + uniform(random)));
  compute_forces(m, s, false, 0.0, 1);
  const auto totals = [&]() {
    std::array<double, 7> sum{};
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const Vec3 p = s.motion.mass[slot] * s.velocity(slot), l = s.position(slot).cross(p);
      sum[0] += s.motion.mass[slot];
      for (int d = 0; d < 3; ++d) sum[1 + d] += p[d], sum[4 + d] += l[d];
    }
    return sum;
  };
  const auto before = totals();
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  const Piece& piece = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
  const Handoff h = hand_off(m, s, t, piece, 7, 0.0);
  const auto after = totals();
  const Vec3 p = h.body.mass * h.body.motion.velocity;
  const Vec3 l = h.body.motion.angular_momentum + h.body.motion.position.cross(p);
  EXPECT_NEAR(h.body.mass, 2500 * 0.004 * piece.area, 1e-15);
  // sums over 484 control points: 1e-16 each, relative to the largest entries
  EXPECT_NEAR(after[0] + h.body.mass, before[0], 1e-13);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(after[1 + d] + p[d], before[1 + d], 1e-12);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(after[4 + d] + l[d], before[4 + d], 1e-12);
  for (const int slot : h.donors) EXPECT_GE(s.motion.mass[slot], 0.5 * m.mass[slot] * (1 - 1e-12));
  // volume of the convex parts: that of the piece, each part may add a tenth of a squared spacing
  EXPECT_NEAR(
      volume_of_prisms(std::get<ConvexShape>(h.body.shape)), 0.004 * piece.area,
      0.1 * m.spacing * m.spacing * 0.004 * static_cast<double>(std::get<ConvexShape>(h.body.shape).parts.size()));
}

// A Gauss point still sees across where cracks end just short of one another: here one whole side is not cut yet.
TEST(HandOff, LosesNoMomentumToAForceThatStillPullsAcross) {
  const ShellModel m = brittle_sheet();
  const std::vector<Vec2> open = {{0.05, 0.05}, {0.13, 0.06}, {0.12, 0.14}, {0.06, 0.13}};
  ShellState s = make_state(m, Vec3(1, 2, 3), 1), closed = s;
  insert_polyline(m, s, open, 0.0);
  std::vector<Vec2> all = open;
  all.push_back(open[0]);
  insert_polyline(m, closed, all, 0.0);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, closed, pieces);
  ASSERT_EQ(t.pieces, 2);
  for (int i = 0; i < m.control_points(); ++i) s.motion.x[m.tables.slot(i)] *= 1.001;
  compute_forces(m, s, false, 0.0, 1);
  const Totals before = totals(m, s);
  const Handoff h = hand_off(m, s, t, pieces[0].area < pieces[1].area ? pieces[0] : pieces[1], 7, 1e-6);
  Totals after = totals(m, s);
  const Vec3 p = h.body.mass * h.body.motion.velocity;
  after.momentum += p, after.angular += h.body.motion.angular_momentum + h.body.motion.position.cross(p);
  // the force across, some 20 kN, would leave 0.01 N s of half a substep; sums of 484 entries, 1e-16 each
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
}

TEST(HandOff, ATranslatingPieceDoesNotSpinAndCreatesNoEnergy) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3(3, -2, 5), 1);
  insert_polyline(m, s, {{0.0511, 0.0523}, {0.131, 0.062}, {0.118, 0.143}, {0.0511, 0.0523}}, 0.0);
  compute_forces(m, s, false, 0.0, 1);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  const double before = kinetic_energy(m, s, 0.0);
  const Handoff h = hand_off(m, s, t, pieces[0].area < pieces[1].area ? pieces[0] : pieces[1], 7, 0.0);
  EXPECT_LT((h.body.motion.velocity - Vec3(3, -2, 5)).norm(), 1e-12);
  EXPECT_LT(h.body.motion.angular_momentum.norm(), 1e-12 * h.body.mass * 6.0 * m.spacing);
  EXPECT_NEAR(kinetic_energy(m, s, 0.0) + h.body.kinetic_energy(), before, 1e-12 * before);
}

TEST(HandOff, ASmallPieceIsNoFasterThanWhatItIsMadeOf) {
  const ShellModel m = brittle_sheet();
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int small = 0;
  for (int k = 0; k < 40; ++k) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const Vec2 a(0.1 + 0.05 * uniform(random), 0.1 + 0.05 * uniform(random));
    const Vec2 b = a + m.spacing * Vec2(2.0 + uniform(random), 0.3 * uniform(random));
    const Vec2 c = a + m.spacing * Vec2(uniform(random), 1.0 + 0.7 * uniform(random));
    insert_polyline(m, s, {a, b, c, a}, 0.0);
    double fastest = 0.0;
    for (int i = 0; i < m.control_points(); ++i) {
      s.add_velocity(m.tables.slot(i), Vec3(uniform(random), uniform(random), uniform(random)));
      fastest = std::max(fastest, s.velocity(m.tables.slot(i)).norm());
    }
    compute_forces(m, s, false, 0.0, 1);
    std::vector<Piece> pieces;
    const Triangulation t = partition(m, s, pieces);
    if (t.pieces != 2) continue;  // the triangle was folded
    const Piece& piece = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
    const RigidBody b7 = hand_off(m, s, t, piece, 7, 0.0).body;
    small += piece.area < 2.0 * m.spacing * m.spacing;
    // its energy is at most that of its mass at the speed of the fastest control point, twice for masses that cross
    EXPECT_LE(b7.kinetic_energy(), 2.0 * 0.5 * b7.mass * fastest * fastest) << k;
    EXPECT_LE(b7.motion.velocity.norm(), 2.0 * fastest) << k;
  }
  EXPECT_GT(small, 20);
}

// Beside a strip along the border the nearest control points lie in one row, which cannot take a spin about itself.
TEST(HandOff, ALongStripLeavesWithNoMoreEnergyThanThereWas) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const double x = m.patch.knots_u.end() - 0.01 * m.spacing;
  insert_polyline(m, s, {{x, 0.0}, {x, m.patch.knots_v.end()}}, 0.0);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < m.control_points(); ++i)
    s.add_velocity(m.tables.slot(i), Vec3(uniform(random), uniform(random), uniform(random)));
  compute_forces(m, s, false, 0.0, 1);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  const double before = kinetic_energy(m, s, 0.0);
  const Totals all = totals(m, s);
  const RigidBody b = hand_off(m, s, t, pieces[0].area < pieces[1].area ? pieces[0] : pieces[1], 7, 0.0).body;
  EXPECT_LE(kinetic_energy(m, s, 0.0) + b.kinetic_energy(), 1.01 * before);
  const Totals left = totals(m, s);
  const Vec3 spin = b.motion.angular_momentum + b.mass * b.motion.position.cross(b.motion.velocity);
  EXPECT_LT((left.momentum + b.mass * b.motion.velocity - all.momentum).norm(), 1e-12 * all.momentum_scale);
  EXPECT_LT((left.angular + spin - all.angular).norm(), 1e-12 * all.angular_scale);
}

// Two ends of a long strip whose middle has left. What one end lacks it cannot get from the other, far away.
TEST(HandOff, APieceAloneTakesNothingFromAfar) {
  ShellMaterial material = glass();
  material.strength = 60e6, material.fracture_energy = 8.0;
  const ShellModel m =
      make_shell("p", plate(0.46, 0.04, 46, 4, Vec3::Zero(), Quat::Identity()), 0.02, material, 2, 2, {});
  for (const bool moves_evenly : {true, false}) {
    ShellState s = make_state(m, Vec3(3, -2, 5), 1);
    for (const double x : {6.3 * m.spacing, 39.6 * m.spacing}) insert_polyline(m, s, {{x, 0.0}, {x, 0.04}}, 0.0);
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int i = 0; i < m.control_points() && !moves_evenly; ++i)
      s.add_velocity(m.tables.slot(i), Vec3(uniform(random), uniform(random), uniform(random)));
    compute_forces(m, s, false, 0.0, 1);
    std::vector<Piece> pieces;
    const Triangulation t = partition(m, s, pieces);
    ASSERT_EQ(t.pieces, 3);
    const auto own = [&](int piece, int point) { return t.owner[point] == piece; };
    const int first = t.owner[0], last = t.owner[m.control_points() - 1], middle = 3 - first - last;
    hand_off(m, s, t, pieces[middle], 7, 0.0);
    const double before = kinetic_energy(m, s, 0.0);
    const Totals all = totals(m, s);
    const Motion motion = s.motion;
    double mass = 0.0;
    for (int i = 0; i < m.control_points(); ++i)
      if (own(first, i)) mass += s.motion.mass[m.tables.slot(i)];
    EXPECT_GT(std::abs(mass / (2500 * 0.02 * pieces[first].area) - 1.0), 1e-6);  // else there is nothing to test
    const RigidBody b = hand_off(m, s, t, pieces[first], 8, 0.0).body;
    EXPECT_NEAR(b.mass, mass, 1e-13 * mass);
    for (int i = 0; i < m.control_points(); ++i) {
      if (!own(last, i)) continue;
      const int slot = m.tables.slot(i);
      EXPECT_EQ(s.motion.mass[slot], motion.mass[slot]);
      for (int d = 0; d < 3; ++d) {
        const std::size_t k = d * s.motion.mass.size() + slot;
        EXPECT_EQ(s.motion.v[k], motion.v[k]);
      }
    }
    EXPECT_LE(kinetic_energy(m, s, 0.0) + b.kinetic_energy(), (1.0 + 1e-12) * before);
    if (moves_evenly) {
      EXPECT_LT(b.motion.angular_momentum.norm(), 1e-12 * b.mass * 6.0 * 6.0 * m.spacing);
    }
    const Totals left = totals(m, s);
    const Vec3 spin = b.motion.angular_momentum + b.mass * b.motion.position.cross(b.motion.velocity);
    EXPECT_LT((left.momentum + b.mass * b.motion.velocity - all.momentum).norm(), 1e-12 * all.momentum_scale);
    EXPECT_LT((left.angular + spin - all.angular).norm(), 1e-12 * all.angular_scale);
  }
}

TEST(HandOff, TheLastPieceTakesAllThatIsLeft) {
  const ShellModel m = brittle_sheet();
  for (const double share : {0.99, 1.0 + 1e-9, 1.01}) {  // what earlier pieces have not taken, too little or too much
    ShellState s = make_state(m, Vec3(3, -2, 5), 1);
    for (int i = 0; i < m.control_points(); ++i) s.motion.mass[m.tables.slot(i)] *= share;
    compute_forces(m, s, false, 0.0, 1);
    std::vector<Piece> pieces;
    const Triangulation t = partition(m, s, pieces);
    ASSERT_EQ(t.pieces, 1);
    const Totals before = totals(m, s);
    const RigidBody b = hand_off(m, s, t, pieces[0], 7, 0.0).body;
    EXPECT_NEAR(b.mass, before.mass, 1e-13 * before.mass) << share;
    EXPECT_LT((b.mass * b.motion.velocity - before.momentum).norm(), 1e-13 * before.momentum_scale) << share;
  }
}

// Fibres that leave with a piece make no crack in what stays.
TEST(HandOff, TakesTheDamageOfFibresAlong) {
  const ShellModel m = panel_with_fibres(30);
  ShellState s = damaging(m);
  insert_polyline(m, s, {{0.0, 0.1}, {0.3, 0.1}}, 0.0);
  for (const std::size_t side : {0u, 1u}) tear_fibres_where(m, s, side, [](const Vec2&) { return true; });
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  ASSERT_EQ(t.pieces, 2);
  hand_off(m, s, t, pieces[0].area < pieces[1].area ? pieces[0] : pieces[1], 7, 0.0);
  int left = 0, stay = 0;
  for (std::size_t k = 0; k < s.cracked.gathered.size(); ++k) {
    const GatheredPoint& g = s.cracked.gathered[k];
    EXPECT_EQ(s.worst_damage(k), g.handed_off ? 0.0f : 1.0f);
    EXPECT_EQ(s.damage(k), g.handed_off ? 0.0f : 1.0f);
    ++(g.handed_off ? left : stay);
  }
  EXPECT_NEAR(static_cast<double>(left) / (left + stay), 1.0 / 3.0, 0.03);  // within a row of points
}
