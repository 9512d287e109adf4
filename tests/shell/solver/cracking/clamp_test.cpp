// Cracks beside a clamped border run on it, and leave no strip.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "shell/geometry/edges.h"
#include "shell/solver/cracking/clamp.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/grow_cracks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSide = 0.2;

struct Held {
  int edge = kUMin, degree = 2, elements_u = 20, elements_v = 20;
  bool clamped = true;
};

ShellModel held_plate(const Held& what) {
  ShellMaterial g = glass();
  g.strength = 4e6, g.fracture_energy = 0.3;
  Support support;
  support.edges = what.edge, support.clamped = what.clamped;
  const Patch p = plate(kSide, kSide, what.elements_u, what.elements_v, Vec3(0.5 * kSide, 0.5 * kSide, 0),
                        Quat::Identity(), what.degree);
  return make_shell("p", p, 0.004, g, 2, what.degree, {support});
}

// From the edge that is held [m].
double depth(const Held& what, const Vec2& p) {
  const double along = what.edge < kVMin ? p.x() : p.y();
  return what.edge == kUMin || what.edge == kVMin ? along : kSide - along;
}

// Bent as a plate that is clamped along one edge and drawn up at the other, most at the border; cracked until all
// rests.
struct Cracked {
  explicit Cracked(const Held& what) : held(what), m(held_plate(what)), s(make_state(m, Vec3(1, 2, 3), 1)) {
    const CrackRules r = make_crack_rules(m, 0.0);
    for (int k = 0; k < m.control_points(); ++k) {
      const double x = depth(what, m.parameter[k]);
      if (!m.held[m.tables.slot(k)])
        s.motion.x[2 * m.tables.component_stride + m.tables.slot(k)] = 0.03 * x * x * (3.0 * kSide - x);
    }
    std::uint64_t random = 1;
    for (int look = 0; look < 200; ++look) {
      compute_forces(m, s, false, 1.0, 1);
      grow_cracks(m, s, r, 1e-6 * look, 0.3 * r.advance / r.rayleigh, random);
    }
    t = triangulated(m, s, {});
    pieces = pieces_of(m, s, t);
    // slivers leave first: once all else has left, nothing beside them has mass to give
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.area < b.area; });
  }
  double mass_at_border() const {
    double sum = 0.0;
    for (const int i : edge_row(m.patch, held.edge, 0)) sum += s.motion.mass[m.tables.slot(i)];
    return sum;
  }
  // The piece with the control point that is nearest to the edge that is held.
  const Piece* beside_border() const {
    const Piece* found = nullptr;
    double least = kSide;
    for (const Piece& p : pieces)
      for (const int point : p.control_points)
        if (const double d = depth(held, m.parameter[point]); d < least) least = d, found = &p;
    return found;
  }

  Held held;
  ShellModel m;
  ShellState s;
  Triangulation t;
  std::vector<Piece> pieces;
};

}  // namespace

TEST(ClampedBorder, IsFollowedByWhatIsBesideItAndNearlyParallel) {
  const ShellModel m = held_plate({});
  const double h = m.spacing;
  const auto border = clamped_border(m, {0.3 * h, 0.1}, Vec2(0.1, -1.0).normalized(), h);
  ASSERT_TRUE(border);
  EXPECT_DOUBLE_EQ(border->foot.x(), kOnBorder * h);
  EXPECT_DOUBLE_EQ(border->foot.y(), 0.1);
  EXPECT_EQ(border->along, Vec2(0.0, -1.0));
  const Vec2 aslant = Vec2(1.0, 1.0).normalized();
  const auto met = met_at(*border, {h, 0.1}, aslant, 1.1 * h);
  ASSERT_TRUE(met);
  EXPECT_EQ(met->x(), border->foot.x());
  EXPECT_NEAR(met->y(), 0.1 - (1.0 - kOnBorder) * h, 1e-15);
  EXPECT_FALSE(met_at(*border, {h, 0.1}, aslant, 0.9 * h));
  EXPECT_FALSE(met_at(*border, {h, 0.1}, {0.0, 1.0}, h));                                   // never
  EXPECT_TRUE(clamped_border(m, {-0.1 * h, 0.1}, {0.0, 1.0}, h));                           // ran over it
  EXPECT_FALSE(clamped_border(m, {1.1 * h, 0.1}, {0.0, 1.0}, h));                           // too far in
  EXPECT_FALSE(clamped_border(m, {0.3 * h, 0.1}, Vec2(-1.0, 1.0).normalized(), h));         // meets it
  EXPECT_FALSE(clamped_border(m, {0.3 * h, 0.1}, Vec2(0.4, 1.0).normalized(), h));          // leaves it
  EXPECT_FALSE(clamped_border(m, {kSide - 0.3 * h, 0.1}, {0.0, 1.0}, h));                   // free
  EXPECT_FALSE(clamped_border(held_plate({.clamped = false}), {0.3 * h, 0.1}, {0, 1}, h));  // hinged
}

TEST(ClampedBorder, IsThatOfLinesBesideItWhateverTheirSense) {
  for (const int edge : kEdges) {
    const ShellModel m = held_plate({.edge = edge});
    const double at = edge == kUMin || edge == kVMin ? 0.3 * m.spacing : kSide - 0.3 * m.spacing;
    const Vec2 p = edge < kVMin ? Vec2(at, 0.1) : Vec2(0.1, at);
    for (const double degrees : {-40.0, -30.0, -20.0, 0.0, 20.0, 30.0, 40.0})
      for (const double half_turn : {0.0, 180.0}) {
        const double angle = (degrees + half_turn + (edge < kVMin ? 90.0 : 0.0)) * std::numbers::pi / 180.0;
        EXPECT_EQ(clamped_start(m, CrackGraph({0, 0}, {kSide, kSide}, m.spacing, 1e-4), p,
                                Vec2(std::cos(angle), std::sin(angle)))
                      .has_value(),
                  std::abs(degrees) < 32.0)
            << "edge " << edge << ", " << degrees << " degrees";
      }
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const Vec2 border = edge < kVMin ? Vec2(1.0, 0.0) : Vec2(0.0, 1.0), along(border.y(), border.x());
    const Vec2 between = p + (at < 0.1 ? -0.1 : 0.1) * m.spacing * border;
    insert_polyline(m, s, {between - 0.02 * along, between + 0.02 * along}, 0.0);
    EXPECT_FALSE(clamped_start(m, s.cracks.graph, p, along)) << "edge " << edge << ", does not see it";
  }
}

TEST(ClampedBorder, BreaksWithoutAStripAndThenHoldsNothing) {
  for (const Held& what : {Held{}, Held{.edge = kUMax}, Held{.edge = kVMin}, Held{.edge = kVMax}, Held{.degree = 3},
                           Held{.elements_u = 26}, Held{.elements_v = 32}}) {
    const std::string label =
        fmt::format("edge {}, degree {}, {} x {}", what.edge, what.degree, what.elements_u, what.elements_v);
    const Cracked c(what);
    const double across = what.edge < kVMin ? c.m.spacing_u : c.m.spacing_v;
    double on = 0.0;
    for (const CrackEdge& e : c.s.cracks.graph.edges()) {
      const double a = depth(what, e.a), b = depth(what, e.b);
      if (std::max(a, b) < kBorderTolerance * c.m.spacing)
        on += (e.b - e.a).norm();
      else  // nor does any run beside it
        EXPECT_GT(std::max(a, b), 0.5 * across) << label << ": " << e.a.transpose() << "  " << e.b.transpose();
    }
    const bool whole = what.elements_u == what.elements_v;  // else a bit is left, before which tips rest in this bend
    EXPECT_GT(on, (whole ? 0.99 : 0.85) * kSide) << label;
    double area = 0.0;
    for (const Piece& p : c.pieces) {
      double inside = 0.0;
      for (const int i : c.t.triangles_of(p.number))
        for (const int k : c.t.triangles[i]) inside = std::max(inside, depth(what, c.t.vertices[k]));
      EXPECT_GT(inside, across) << label;
      EXPECT_TRUE(!whole || !p.held) << label;
      area += p.area;
    }
    EXPECT_NEAR(area, kSide * kSide, 1e-12) << label;
  }
}

TEST(ClampedBorder, OfAHingedPlateIsNone) {
  const Cracked c({.clamped = false});
  ASSERT_FALSE(c.s.cracks.graph.edges().empty());
  for (const CrackEdge& e : c.s.cracks.graph.edges()) EXPECT_GT(std::max(e.a.x(), e.b.x()), 0.1 * c.m.spacing);
}

// However long: a strip of 60 spacings is more than a sliver.
TEST(ClampedBorder, IsThatOfThePieceWhereACrackRunsOnIt) {
  Support support;
  support.edges = kVMin;
  ShellMaterial material = glass();
  for (const bool laminated : {false, true}) {
    if (laminated) material.interlayer = {0.001, 1100, 1e7, 0.4};
    const ShellModel m = make_shell("p", plate(0.6, 0.1, 60, 10, Vec3(0.3, 0.05, 0), Quat::Identity()), 0.004, material,
                                    2, 2, {support});
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{-0.01, kOnBorder * m.spacing}, {0.61, kOnBorder * m.spacing}}, 0.0);
    std::vector<Piece> pieces;
    partition(m, s, pieces);
    ASSERT_EQ(pieces.size(), 1u);
    EXPECT_EQ(pieces[0].held, laminated);  // what is between still hangs on it
    EXPECT_EQ(pieces[0].parted, !laminated);
    EXPECT_EQ(pieces[0].control_points.size(), (laminated ? 12u : 11u) * 62u);
  }
}

// One that is further off than half an edge goes its own way.
TEST(ClampedBorder, IsReachedByATipInOneEdge) {
  const ShellModel m = held_plate({});
  for (const double depth : {0.1, 0.3, 0.6}) {  // spacings
    ShellState s = make_state(m, Vec3::Zero(), 1);
    for (int k = 0; k < m.control_points(); ++k) {
      const double x = m.parameter[k].x();
      if (!m.held[m.tables.slot(k)]) s.motion.x[2 * m.tables.component_stride + m.tables.slot(k)] = 0.2 * x * x;
    }
    std::fill(s.layers.strength.begin(), s.layers.strength.end(), 1e12);  // nothing else cracks
    insert_polyline(m, s, {{depth * m.spacing, -0.01}, {depth * m.spacing, 0.05}}, 0.0);
    start_at_ends(m, s, 0, static_cast<int>(s.cracks.graph.edges().size()));
    ASSERT_EQ(s.cracks.tips.size(), 1u);
    s.cracks.tips[0].first_turn = 0.0;
    CrackRules r = make_crack_rules(m, 0.0);
    r.branch_ratio = 1e6;  // never
    std::uint64_t random = 1;
    int last = s.cracks.tips[0].edge, edges = 0;
    for (int look = 0; look < 60 && s.cracks.tips[0].alive; ++look) {
      compute_forces(m, s, false, 1.0, 1);
      grow_cracks(m, s, r, 1e-6 * look, 0.3 * r.advance / r.rayleigh, random);
      if (s.cracks.tips[0].edge == last) continue;
      last = s.cracks.tips[0].edge;
      if (++edges == 1) continue;
      const CrackEdge& e = s.cracks.graph.edges()[last];
      if (depth < 0.5 * r.advance / m.spacing) {
        EXPECT_LT(std::max(e.a.x(), e.b.x()), kBorderTolerance * m.spacing) << depth << ", edge " << edges;
      } else if (edges == 2) {
        EXPECT_GT(e.a.x(), 0.4 * m.spacing) << "goes its own way";
      }
    }
    EXPECT_GT(edges, 3) << depth;
  }
}

// What has broken off along the clamp takes the mass that the support still has of it, with the support's motion.
TEST(ClampedBorder, WhatBreaksOffThereWeighsWhatItDid) {
  for (const double speed : {0.0, 5.0}) {
    Cracked c({});
    for (const auto& held : c.m.constraints.held[2])
      c.s.motion.v[2 * c.m.tables.component_stride + held] = speed;  // as if it were driven
    for (const Piece& p : c.pieces) {
      const Totals before = totals(c.m, c.s);
      const double at_border = c.mass_at_border();
      const Handoff h = hand_off(c.m, c.s, c.t, p, 7, 0.0);
      const RigidBody& b = h.body;
      EXPECT_NEAR(b.mass, c.m.material.density * c.m.thickness * p.area, 1e-9 * before.mass);
      const Totals after = totals(c.m, c.s);
      EXPECT_NEAR(before.mass - after.mass, b.mass, 1e-12 * before.mass);
      const Vec3 momentum = after.momentum + b.mass * b.motion.velocity - before.momentum;
      EXPECT_LT(momentum.norm(), 1e-12 * before.momentum_scale) << speed;
      if (&p == c.beside_border()) {
        EXPECT_GT(at_border - c.mass_at_border(), 0.5 * h.mass_moved);  // before what is further off
      }
    }
    EXPECT_NEAR(c.mass_at_border(), 0.0, 1e-12);
    for (const GatheredPoint& g : c.s.cracked.gathered) EXPECT_TRUE(g.handed_off);
  }
}
