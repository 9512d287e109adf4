// Cracks beside a clamped border run on it, and leave no strip.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/solver/clamp.h"
#include "shell/solver/handoff.h"
#include "shell/solver/tips.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSide = 0.2;

ShellModel held_at_left(bool clamped) {
  ShellMaterial g = glass();
  g.strength = 4e6, g.fracture_energy = 0.3;
  Support support;
  support.edges = kUMin, support.clamped = clamped;
  return make_shell("p", plate(kSide, kSide, 20, 20, Vec3(0.5 * kSide, 0.5 * kSide, 0), Quat::Identity()), 0.004, g, 2,
                    2, {support});
}

// Bent as a plate that is clamped at x = 0 and drawn up at the other end, most at the border; cracked until all rests.
struct Cracked {
  explicit Cracked(bool clamped) : m(held_at_left(clamped)), s(make_state(m, Vec3::Zero(), 1)) {
    const CrackRules r = make_crack_rules(m, 0.0);
    for (int k = 0; k < m.control_points(); ++k) {
      const double x = m.parameter[k].x();
      if (!m.held[m.tables.slot(k)]) s.x[2 * m.tables.plane + m.tables.slot(k)] = 0.03 * x * x * (3.0 * kSide - x);
    }
    std::uint64_t random = 1;
    for (int look = 0; look < 200; ++look) {
      compute_forces(m, s, false, 1.0, 1);
      grow_cracks(m, s, r, 1e-6 * look, 0.3 * r.advance / r.rayleigh, random);
    }
    t = triangulated(m, s, {});
    pieces = pieces_of(m, s, t);
  }

  ShellModel m;
  ShellState s;
  Triangulation t;
  std::vector<Piece> pieces;
};

}  // namespace

TEST(ClampedBorder, IsFollowedByWhatIsBesideItAndNearlyParallel) {
  const ShellModel m = held_at_left(true);
  const double h = m.spacing;
  const auto border = clamped_border(m, {0.3 * h, 0.1}, Vec2(0.1, -1.0).normalized());
  ASSERT_TRUE(border);
  EXPECT_DOUBLE_EQ(border->foot.x(), kOnBorder * h);
  EXPECT_DOUBLE_EQ(border->foot.y(), 0.1);
  EXPECT_EQ(border->along, Vec2(0.0, -1.0));
  EXPECT_TRUE(clamped_border(m, {-0.1 * h, 0.1}, {0.0, 1.0}));                    // ran over it
  EXPECT_FALSE(clamped_border(m, {1.1 * h, 0.1}, {0.0, 1.0}));                    // too far in
  EXPECT_FALSE(clamped_border(m, {0.3 * h, 0.1}, Vec2(-1.0, 1.0).normalized()));  // meets it
  EXPECT_FALSE(clamped_border(m, {0.3 * h, 0.1}, Vec2(0.4, 1.0).normalized()));   // leaves it
  EXPECT_FALSE(clamped_border(m, {kSide - 0.3 * h, 0.1}, {0.0, 1.0}));            // free
  EXPECT_FALSE(clamped_border(held_at_left(false), {0.3 * h, 0.1}, {0.0, 1.0}));  // hinged
}

TEST(ClampedBorder, BreaksWithoutAStripAndThenHoldsNothing) {
  const Cracked c(true);
  double on = 0.0;
  for (const CrackEdge& e : c.s.cracks.edges())
    if (std::max(e.a.x(), e.b.x()) < 1e-3 * c.m.spacing) on += std::abs(e.b.y() - e.a.y());
  EXPECT_GT(on, 0.99 * kSide);
  for (const CrackEdge& e : c.s.cracks.edges())  // nor does any run beside it
    EXPECT_FALSE(e.a.x() < c.m.spacing && e.b.x() < c.m.spacing && e.a.x() > 1e-3 * c.m.spacing &&
                 e.b.x() > 1e-3 * c.m.spacing)
        << e.a.transpose() << "  " << e.b.transpose();
  double area = 0.0;
  for (const Piece& p : c.pieces) {
    area += p.area;
    EXPECT_FALSE(p.held);
    double depth = 0.0;
    for (const int i : c.t.triangles_of(p.number))
      for (const int k : c.t.triangles[i]) depth = std::max(depth, c.t.vertices[k].x());
    EXPECT_GT(depth, c.m.spacing);
  }
  EXPECT_NEAR(area, kSide * kSide, 1e-12);
}

TEST(ClampedBorder, OfAHingedPlateIsNone) {
  const Cracked c(false);
  ASSERT_FALSE(c.s.cracks.edges().empty());
  for (const CrackEdge& e : c.s.cracks.edges()) EXPECT_GT(std::max(e.a.x(), e.b.x()), 0.1 * c.m.spacing);
}

// What has broken off along the clamp takes the mass that the support still has of it.
TEST(ClampedBorder, WhatBreaksOffThereWeighsWhatItDid) {
  Cracked c(true);
  const Totals before = totals(c.m, c.s);
  double mass = 0.0;
  for (const Piece& p : c.pieces) {
    const Handoff h = hand_off(c.m, c.s, c.t, p, 7, 0.0);
    mass += h.body.mass;
    EXPECT_NEAR(h.body.mass, c.m.material.density * c.m.thickness * p.area, 1e-9 * before.mass);
  }
  EXPECT_NEAR(before.mass - totals(c.m, c.s).mass, mass, 1e-12 * before.mass);
}
