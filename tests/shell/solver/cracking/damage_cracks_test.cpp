// Cracks that are made of damage.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/damage_lattice.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/state_archive.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

int pieces_of_graph(const CrackGraph& g) {
  std::vector<int> root(g.vertices().size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const CrackEdge& e : g.edges()) root[find(e.from)] = find(e.to);
  std::set<int> roots;
  for (const CrackEdge& e : g.edges()) roots.insert(find(e.from));
  return static_cast<int>(roots.size());
}

}  // namespace

TEST(ExtractCracks, FollowsACurvedBandStageByStageWithoutAGap) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  const auto middle = [](double x) { return 0.12 + 0.8 * x * (0.3 - x); };
  std::vector<CrackEdge> earlier;
  for (const double reach : {0.12, 0.2, 0.31}) {
    damage_where(m, s,
                 [&](const Vec2& p) { return p.x() < reach && std::abs(p.y() - middle(p.x())) < 0.9 * m.spacing; });
    extract_cracks(m, s, reach);
    const auto& edges = s.cracks.graph.edges();
    ASSERT_GT(edges.size(), earlier.size()) << reach;
    for (std::size_t k = 0; k < earlier.size(); ++k) {
      EXPECT_EQ(edges[k].a, earlier[k].a);
      EXPECT_EQ(edges[k].b, earlier[k].b);
    }
    for (const CrackEdge& e : edges) EXPECT_NEAR(e.b.y(), middle(e.b.x()), m.spacing) << reach;
    EXPECT_EQ(pieces_of_graph(s.cracks.graph), 1) << reach;
    earlier = edges;
  }
  EXPECT_LT(s.cracks.graph.total_length(), 0.38);  // once, not also beside itself: the curve is 0.315 m long
  // it runs out at both borders: nothing above sees anything below
  for (double x = 0.01; x < 0.3; x += 0.01) EXPECT_FALSE(s.cracks.graph.visible({x, 0.05}, {x, 0.25})) << x;
}

TEST(ExtractCracks, BroadDamageStartsOneCrackAcrossTheLargestStress) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 5.0 * m.spacing; });
  stretch_x(m, s, 2e-3);
  extract_cracks(m, s, 0.0);
  ASSERT_EQ(s.cracks.graph.edges().size(), 1u);
  const Vec2 d = (s.cracks.graph.edges()[0].b - s.cracks.graph.edges()[0].a).normalized();
  EXPECT_NEAR(std::abs(d.y()), 1.0, 1e-6);
  for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
  EXPECT_EQ(pieces_of_graph(s.cracks.graph), 1);
  EXPECT_GT(s.cracks.graph.total_length(), 3.0 * m.spacing);
}

// Bent to a fold along y: the stretched face is torn, the pressed one is sound, and the crack goes through both.
TEST(ExtractCracks, UnderBendingTheStretchedFaceDecides) {
  const ShellModel m = panel(40, 0.2);
  for (const double up : {1.0, -1.0}) {
    ShellState s = damaging(m);
    const double band = 2.0 * m.spacing, curvature = 44.0 * kStrength / kYoung / m.thickness;
    const auto bend = [&](double share) {  // turns by `curvature` over the band in the middle
      for (int i = 0; i < m.control_points(); ++i) {
        const int slot = m.tables.slot(i);
        const double x = m.rest[slot], from = -0.5 * band, within = std::clamp(x - from, 0.0, band);
        const double k = share * curvature, angle = k * within, after = std::max(0.0, x - from - band);
        s.motion.x[slot] = std::min(x, from) + std::sin(angle) / k + std::cos(angle) * after;
        s.motion.x[2 * m.tables.component_stride + slot] = up * ((1.0 - std::cos(angle)) / k + std::sin(angle) * after);
      }
    };
    for (int step = 1; step <= 40; ++step) {
      bend(step / 40.0);
      compute_forces(m, s, false, 1.0, 1);
      watch_stress(m, s);
    }
    compute_forces(m, s, false, 1.0, 1);
    float stretched = 0.0f, pressed = 0.0f;
    for (const PointDamage& d : s.cracked.damage) {
      stretched = std::max(stretched, d.history[up > 0.0 ? 0 : 1]);
      pressed = std::max(pressed, d.history[up > 0.0 ? 1 : 0]);
    }
    EXPECT_EQ(stretched, 1.0f);
    EXPECT_EQ(pressed, 0.0f);
    for (int k = 0; k < 20; ++k) extract_cracks(m, s, 0.0);
    for (double y = 0.02; y < 0.29; y += 0.02)
      EXPECT_FALSE(s.cracks.graph.visible({0.13, y}, {0.17, y})) << up << " " << y;
    for (const CrackEdge& e : s.cracks.graph.edges())
      EXPECT_LT(std::max(std::abs(e.a.x() - 0.15), std::abs(e.b.x() - 0.15)), 1.5 * m.spacing);
  }
}

// An end that has met a stem lies just past it: it must not walk along it, however it leans.
TEST(ExtractCracks, AnEndThatHasJoinedAStemIsNotOpen) {
  for (const double lean : {0.0, 0.03, 0.06, 0.12}) {
    const ShellModel m = panel(40, 0.2);
    ShellState s = damaging(m);
    insert_polyline(m, s, {{0.0, 0.1503}, {0.3, 0.1541}}, 0.0);
    insert_polyline(m, s, {{0.17 - lean, 0.0}, {0.17 - 0.5 * lean, 0.08}, {0.17, 0.1503 + 0.17 / 0.3 * 0.0038}}, 0.0);
    damage_where(m, s, [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 0.9 * m.spacing; });
    const std::size_t edges = s.cracks.graph.edges().size();
    for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), edges) << lean;
  }
}

// One that stops at a stem without having met it is open, and joins it once.
TEST(ExtractCracks, AnEndJustShortOfAStemJoinsItOnce) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  insert_polyline(m, s, {{0.0, 0.1503}, {0.3, 0.1503}}, 0.0);
  insert_polyline(m, s, {{0.11, 0.0}, {0.17, 0.1503 - 0.3 * m.spacing}}, 0.0);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.17, 0.15)).norm() < 0.9 * m.spacing; });
  const std::size_t edges = s.cracks.graph.edges().size();
  for (int k = 0; k < 5; ++k) extract_cracks(m, s, 0.0);
  EXPECT_EQ(s.cracks.graph.edges().size(), edges + 1);
}

// The end ahead is too far over sound material; what lies behind it on the same crack is not a way out.
TEST(ExtractCracks, AnEndDoesNotRunAlongTheCrackAheadOfIt) {
  const ShellModel m = panel(40, 0.2);
  const double l = m.spacing;
  for (const double sound : {0.55, 0.65}) {
    ShellState s = damaging(m);
    insert_polyline(m, s, {{0.0, 0.1503}, {0.1, 0.1503}}, 0.0);
    insert_polyline(m, s, {{0.1 + 2.4 * l, 0.1507}, {0.1 + 6.4 * l, 0.1513}}, 0.0);
    damage_where(m, s, [&](const Vec2& p) {
      return std::abs(p.y() - 0.15) < 0.9 * l && p.x() > 0.1 + sound * l && p.x() < 0.1 + 6.0 * l;
    });
    const std::size_t edges = s.cracks.graph.edges().size();
    for (int k = 0; k < 3; ++k) extract_cracks(m, s, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), edges) << sound;
  }
}

TEST(ExtractCracks, WhatHasHealedIsNotCut) {
  const ShellModel m = panel(40, 0.2);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return std::abs(p.y() - 0.15) < 0.9 * m.spacing; });
  for (PointDamage& d : s.cracked.damage) d.now.fill(0.0f);
  EXPECT_EQ(extract_cracks(m, s, 0.0), 0);
}

TEST(ExtractCracks, TornPointsAreReleasedAndCounted) {
  const ShellModel m = panel(32, 0.0);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 0.4 * m.spacing; });
  stretch_x(m, s, 0.05);
  const int damaged = static_cast<int>(s.cracked.gathered.size());
  ASSERT_GT(damaged, 0);
  extract_cracks(m, s, 0.0);
  EXPECT_EQ(s.rubble(), damaged);
}

TEST(ExtractCracks, PointsOfALawWhoseStressNoLongerGrowsAreTornByTheirStretch) {
  ShellMaterial cloth;
  cloth.density = 20, cloth.youngs_modulus = 3200, cloth.poisson_ratio = 0.3;
  cloth.strength = 500, cloth.fracture_energy = 1.6;
  const ShellModel m =
      make_shell("cloth", plate(0.3, 0.3, 32, 32, Vec3::Zero(), Quat::Identity()), 0.005, cloth, 2, 2, {});
  const DamageRules rules;
  for (const double share : {0.99, 1.01}) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    s.layers.brittleness = brittleness(cloth.strength, cloth.youngs_modulus, cloth.fracture_energy, width(m));
    ASSERT_GT(s.layers.brittleness, 0.0);
    damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 0.4 * m.spacing; });
    const int damaged = static_cast<int>(s.cracked.gathered.size());
    ASSERT_GT(damaged, 0);
    const double complete = cloth.strength * (1.0 + s.layers.brittleness) / s.layers.brittleness;
    const double stretch = 1.0 + share * rules.torn_stress * complete * 1.3 / cloth.youngs_modulus;
    stretch_x(m, s, 0.5 * (stretch * stretch - 1.0));
    const std::array<double, 6> face_stress = undamaged_stress(m.tables, s.cracked.gathered[0], s.motion.x);
    EXPECT_LT(face_stress[0], 0.25 * rules.torn_stress * complete);  // the stress would never tell
    extract_cracks(m, s, 0.0);
    EXPECT_EQ(s.rubble(), share > 1.0 ? damaged : 0) << stretch;
  }
}

// Its pressed layer has healed, so the law alone lets a fold bear fully however sharp it is.
TEST(ExtractCracks, AFoldSharperThanItsThicknessBendsFreelyOnceSpent) {
  const ShellModel m = panel(60, 0.2);
  ShellState flat = damaging(m), s = spent_fold(m);
  const double intact = stable_step(m, flat, kStepIterations, 1, false);
  EXPECT_LT(stable_step(m, s, kStepIterations, 1, false), 0.5 * intact);
  const double before = compute_forces(m, s, true, 0.0, 1);
  release_folds(m, s);
  const double after = compute_forces(m, s, true, 0.0, 1);
  EXPECT_LT(after, 0.1 * before);
  EXPECT_NEAR(s.book.fracture - s.book.injected, before - after, 1e-9 * before);  // round-off of sums
  EXPECT_EQ(s.rubble(), 0);
  EXPECT_GE(stable_step(m, s, kStepIterations, 1, false), 0.8 * intact);
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double scale = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i), stride = m.tables.component_stride;
    const Vec3 f(s.motion.force[slot], s.motion.force[stride + slot], s.motion.force[2 * stride + slot]);
    force += f, moment += s.position(slot).cross(f), scale += f.norm();
  }
  EXPECT_LT(force.norm(), 1e-12 * scale);
  EXPECT_LT(moment.norm(), 1e-12 * scale);
  // once more it finds nothing, also where it opens again
  const double booked = s.book.fracture;
  fold(m, s, 1e-6, 0.015);
  release_folds(m, s);
  EXPECT_EQ(s.book.fracture, booked);
  int free = 0;
  for (const GatheredPoint& g : s.cracked.gathered) free += g.kind == PointKind::kLinear;
  EXPECT_GT(free, 100);
}

// The area that its pressed layer keeps says nothing there.
TEST(ExtractCracks, AFoldThatIsDrawnLengthwiseIsReleasedLikeAnother) {
  const ShellModel m = panel(60, 0.2);
  const auto released = [&](double drawn) {
    ShellState s = spent_fold(m);
    for (int i = 0; i < m.control_points(); ++i) s.motion.x[m.tables.component_stride + m.tables.slot(i)] *= drawn;
    release_folds(m, s);
    EXPECT_EQ(s.book.injected, 0.0);
    int free = 0;
    for (const GatheredPoint& g : s.cracked.gathered) free += g.kind == PointKind::kLinear;
    return free;
  };
  const int as_it_is = released(1.0);
  EXPECT_GT(as_it_is, 100);
  EXPECT_EQ(released(8.0), as_it_is);
}

TEST(ExtractCracks, AFoldThatWasNeverSpentBendsAsBefore) {
  const ShellModel m = panel(60, 0.2);
  ShellState s = spent_fold(m);
  for (PointDamage& d : s.cracked.damage) d.history.fill(0.99f);
  release_folds(m, s);
  for (const GatheredPoint& g : s.cracked.gathered) EXPECT_EQ(g.kind, PointKind::kQuadratic);
}

// A wider fold is a sheet that is bent.
TEST(ExtractCracks, ASpentFoldWiderThanItsThicknessBendsAsBefore) {
  const ShellModel m = panel(60, 0.2);
  ShellState s = spent_fold(m);
  fold(m, s, 30.0, 0.05);
  release_folds(m, s);
  for (const GatheredPoint& g : s.cracked.gathered) EXPECT_EQ(g.kind, PointKind::kQuadratic);
}

// The middle surface of such a fold is sound, and alone it would bear where the layers together bore nothing.
TEST(ExtractCracks, AFoldThatIsInsideOutDoesNotBearAgain) {
  const ShellModel m = panel(60, 0.2);
  ShellState s = spent_fold(m);
  fold(m, s, 300.0, 0.01);
  const double before = compute_forces(m, s, true, 0.0, 1);
  release_folds(m, s);
  EXPECT_EQ(s.book.injected, 0.0);
  EXPECT_GT(s.rubble(), 0);
  EXPECT_NEAR(s.book.fracture, before - compute_forces(m, s, true, 0.0, 1), 1e-9 * before);  // round-off of sums
}

TEST(ExtractCracks, APointWhoseMiddleSurfaceIsCrushedIsReleased) {
  const ShellModel m = panel(32, 0.0);
  ShellState s = damaging(m);
  damage_where(m, s, [&](const Vec2& p) { return (p - Vec2(0.15, 0.15)).norm() < 0.4 * m.spacing; });
  const int damaged = static_cast<int>(s.cracked.gathered.size());
  ASSERT_GT(damaged, 0);
  for (const double width : {0.7, 0.5}) {
    for (int i = 0; i < m.control_points(); ++i) s.motion.x[m.tables.slot(i)] = width * m.rest[m.tables.slot(i)];
    compute_forces(m, s, false, 1.0, 1);
    const double before = compute_forces(m, s, true, 0.0, 1);
    release_folds(m, s);
    EXPECT_EQ(s.rubble(), width < kFoldedArea ? damaged : 0);
    EXPECT_NEAR(s.book.fracture, before - compute_forces(m, s, true, 0.0, 1), 1e-9 * before);
  }
}

// What has been released stays so in a state that is read, and beside a crack that comes later.
TEST(ExtractCracks, AReleasedFoldGetsNoBendingBack) {
  const ShellModel m = panel(60, 0.2);
  ShellState s = spent_fold(m);
  release_folds(m, s);
  ArchiveWriter a;
  archive_one(a, s);
  ShellState read = damaging(m);
  ArchiveReader reader(a.bytes.data(), a.bytes.size());
  archive_one(reader, read);
  compute_forces(m, s, false, 0.0, 1), compute_forces(m, read, false, 0.0, 1);
  EXPECT_EQ(s.motion.force, read.motion.force);
  const auto released = [&](const ShellState& of) {
    int sum = 0;
    for (const char kind : of.cracked.kind_of) sum += kind != static_cast<char>(PointKind::kQuadratic);
    return sum;
  };
  const int before = released(read);
  const int from = read.cracks.graph.add_vertex({0.13, 0.1512}), to = read.cracks.graph.add_vertex({0.17, 0.1512});
  ASSERT_EQ(insert_edge(m, read, from, to, read.cracks.graph.new_crack(), 0.0, 0, false), 0);
  EXPECT_GE(released(read), before);
}
