// What a look at the cracks asks of flaws: where tension is above strength, and which cracks are near.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/critical_sheet.h"
#include "tests/shell/grow_cracks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kParallel = 0.85;

ShellModel sheet() {
  ShellMaterial m = glass();
  m.strength = 60e6, m.fracture_energy = 8.0;
  return make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, m, 2, 2, {});
}

bool is_above(const ShellModel& m, const ShellState& s, int block, int lane) {
  double six[6];
  for (int k = 0; k < 6; ++k) six[k] = s.layers.surface_stress[m.tables.at(block, 6, k, lane)];
  const double high = std::max(principal(six[0], six[1], six[2]).high, principal(six[3], six[4], six[5]).high);
  return high > s.layers.strength[m.tables.at(block, 1, 0, lane)];
}

// A sheet drawn along x to 12 MPa within `half_width` [m] of y = 0.1 and to half of that beyond; a stretched crack
// across needs a half-length of `spacings` for its energy at a strength of 10 MPa.
struct OverstressedBand {
  OverstressedBand(double half_width, double spacings, double times = 1.0)
      : m(sheet_that_needs(spacings)), s(make_state(m, Vec3::Zero(), 1)) {
    for (int k = 0; k < m.control_points(); ++k) {
      const Vec2& p = m.parameter[k];
      const double beyond = std::clamp((std::abs(p.y() - 0.1) - half_width) / m.spacing + 0.5, 0.0, 1.0);
      const double strain = (1.0 - 0.5 * beyond) * times * 12e6 / m.material.youngs_modulus;
      s.motion.x[m.tables.slot(k)] += strain * (p.x() - 0.1);
      s.motion.x[m.tables.plane + m.tables.slot(k)] -= m.material.poisson_ratio * strain * (p.y() - 0.1);
    }
  }
  bool opens(double ground = 1.0) {
    compute_forces(m, s, false, 1.0, 1);
    const double half_length = critical_length(m.material, 10e6, 1.0, 0.0);
    return opens_along(m, s, make_crack_rules(m, 0.0),
                       line_through(m, s.cracks.graph, {0.1, 0.1}, {0.0, 1.0}, half_length), 1,
                       {half_length, 10e6, ground}, 0.0);
  }

  ShellModel m;
  ShellState s;
};

}  // namespace

TEST(Flaws, NoPointAboveItsStrengthIsInABlockThatIsNotTold) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& strength : s.layers.strength) strength *= 1.0 + 0.4 * uniform(random);
  insert_polyline(m, s, {{0.1, 0.04}, {0.11, 0.17}}, 0.0);
  int above = 0, gathered = 0, quiet = 0;
  for (int step = 0; step < 8; ++step) {
    for (int k = 0; k < m.control_points(); ++k) {  // bends one side more and more, about the cut as well
      const Vec2& p = m.parameter[k];
      s.motion.x[2 * m.tables.plane + m.tables.slot(k)] = 0.02 * step * p.y() * p.y() + 2e-6 * step * uniform(random);
    }
    compute_forces(m, s, false, 0.6, 1);
    for (int q = 0; q < m.tables.blocks(); ++q) {
      quiet += s.caches.over[q] == 0;
      for (int lane = 0; lane < m.tables.spans_u; ++lane) {
        if (!is_above(m, s, q, lane)) continue;
        EXPECT_TRUE(s.caches.over[q]) << "step " << step << ", block " << q << ", lane " << lane;
        ++above, gathered += s.cracked.point_of[m.tables.at(q, 1, 0, lane)] >= 0;
      }
    }
  }
  EXPECT_GT(above, 100);
  EXPECT_GT(gathered, 10);
  EXPECT_GT(quiet, 100);
}

// Where nothing but points beside a crack is in tension, they tell of their block themselves.
TEST(Flaws, PointsBesideACrackTellOfTheirBlock) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, 0.04}, {0.11, 0.17}}, 0.0);
  for (std::size_t g = 0; g < s.layers.strength.size(); ++g)
    s.layers.strength[g] = s.cracked.point_of[g] < 0 ? 1e12 : 1e5;
  for (int k = 0; k < m.control_points(); ++k)
    if ((m.parameter[k] - Vec2(0.1, 0.1)).norm() < 1.2 * m.spacing)
      s.motion.x[2 * m.tables.plane + m.tables.slot(k)] = m.parameter[k].x() < 0.1 ? 1e-5 : -1e-5;
  compute_forces(m, s, false, 1.0, 1);
  int told = 0;
  for (int q = 0; q < m.tables.blocks(); ++q) {
    bool above = false, others = false;  // of points that no crack has touched: any stress
    for (int lane = 0; lane < m.tables.spans_u; ++lane) {
      const bool beside = s.cracked.point_of[m.tables.at(q, 1, 0, lane)] >= 0;
      above = above || (beside && is_above(m, s, q, lane));
      for (int k = 0; k < 6 && !beside; ++k)
        others = others || std::abs(s.layers.surface_stress[m.tables.at(q, 6, k, lane)]) > 3e4;
    }
    if (!above || others) continue;
    EXPECT_TRUE(s.caches.over[q]) << "block " << q;
    ++told;
  }
  EXPECT_GT(told, 5);
}

TEST(Flaws, KindsOfPointsAreThoseOfTheirEntries) {
  const ShellModel m = sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  for (int k = 0; k < 4; ++k)  // a strip of less than a spacing leaves points that bear little or nothing
    insert_polyline(m, s, {{0.03, 0.05 + 0.003 * k}, {0.17, 0.06 + 0.003 * k}}, 0.0);
  int other = 0;
  for (std::size_t g = 0; g < s.cracked.point_of.size(); ++g) {
    const PointKind kind =
        s.cracked.point_of[g] < 0 ? PointKind::kQuadratic : s.cracked.gathered[s.cracked.point_of[g]].kind;
    EXPECT_EQ(s.cracked.kind(g), kind) << "point " << g;
    other += kind != PointKind::kQuadratic;
  }
  EXPECT_GT(other, 20);
}

TEST(CriticalLength, IsGriffithsStretchedAndThatOfWilliamsFieldBent) {
  ShellMaterial m = glass();
  m.youngs_modulus = 70e9, m.poisson_ratio = 0.22, m.fracture_energy = 8.0;
  EXPECT_NEAR(critical_length(m, 60e6, 2.0, 0.0), 4.95149e-5, 1e-10);
  EXPECT_NEAR(critical_length(m, 60e6, 0.0, 3.0), 3.92061e-4, 1e-9);   // 3 (3 + nu) / (1 + nu) times as long
  EXPECT_NEAR(critical_length(m, 60e6, -1.0, 3.0), 3.92061e-4, 1e-9);  // pressed as well: it opens by bending
  EXPECT_TRUE(std::isinf(critical_length(m, 60e6, -1.0, 0.0)));
  // both release energy: half a stress by each
  EXPECT_NEAR(1.0 / critical_length(m, 60e6, 1.0, 1.0), 0.25 / 4.95149e-5 + 0.25 / 3.92061e-4, 0.1);
}

// The energy of a sheet per area, h E e^2 / 2 or h E k^2 h^2 / 24 in one direction, times the circle's area is the
// energy of the crack's faces.
TEST(GroundRadius, StoresWhatTheCrackCosts) {
  ShellMaterial m = glass();
  m.youngs_modulus = 70e9, m.poisson_ratio = 0.22, m.fracture_energy = 8.0;
  const double strength = 60e6, thickness = 1.3e-3, strain = strength / m.youngs_modulus;
  const double curvature = 2.0 * strain / thickness;
  for (const double bent : {0.0, 0.3, 0.7, 1.0}) {
    const double half_length = critical_length(m, strength, 1.0 - bent, bent);
    const double radius = ground_radius(m, half_length, 1.0 - bent, bent);
    const double e = (1.0 - bent) * strain, k = bent * curvature;
    const double stored = m.youngs_modulus * thickness * (e * e / 2.0 + k * k * thickness * thickness / 24.0);
    EXPECT_NEAR(std::numbers::pi * radius * radius * stored / (2.0 * half_length * thickness * m.fracture_energy), 1.0,
                1e-9)
        << "bent " << bent;
  }
  EXPECT_EQ(ground_radius(m, 1e-3, 0.0, 3.0), ground_radius(m, 1e-3, -1.0, 3.0));  // what is pressed drives nothing
}

TEST(Flaws, ACrackNeedsMoreThanItsStrengthTheLongerItIs) {
  OverstressedBand band(0.04, 6.0);
  compute_forces(band.m, band.s, false, 1.0, 1);
  const CrackRules r = make_crack_rules(band.m, 0.0);
  Start start;
  start.p = {0.1, 0.1}, start.direction = {0.0, 1.0}, start.strength = 10e6;
  std::vector<double> needed;  // stress over that which drives [Pa]
  for (const double grown : {0.0, 0.5, 1.0, 2.0}) {
    start.grown = grown;
    needed.push_back(12e6 / drive_at(band.m, band.s, r, start).ratio);
  }
  EXPECT_NEAR(needed[0], 10e6, 1e5);
  EXPECT_NEAR(needed[1] * needed[1], 0.5 * (needed[0] * needed[0] + needed[2] * needed[2]),
              1e-9 * needed[2] * needed[2]);
  EXPECT_NEAR(needed[2], r.tip_strength, 0.01 * r.tip_strength);
  EXPECT_EQ(needed[2], needed[3]);
  EXPECT_GT(r.tip_strength, 12e6);  // what opens a short crack would not open a sharp one here
}

TEST(Flaws, OpenNothingWhereTooShortALineIsOverstressed) {
  EXPECT_TRUE(OverstressedBand(0.04, 6.0).opens());
  EXPECT_FALSE(OverstressedBand(0.015, 6.0).opens());  // half of the line that its energy asks for
  EXPECT_TRUE(OverstressedBand(0.015, 0.5).opens());   // all of it
}

TEST(Flaws, NeedMoreStressWhereOtherCracksHaveTheGround) {
  OverstressedBand band(0.04, 6.0);  // 1.2 times the strength: 1.44 times the energy
  EXPECT_TRUE(band.opens(0.75));
  EXPECT_FALSE(band.opens(0.65));
}

// Against samples of the circle by the thousand, each asked by itself; edges come one by one.
TEST(Flaws, GroundIsWhatIsNearerToThemThanToACrackAndBeforeCuts) {
  ShellModel m = sheet();  // 0.2 m
  const double radius = 0.03;
  for (const Vec2& p : {Vec2(0.1, 0.1), Vec2(0.012, 0.09), Vec2(0.004, 0.197)})
    for (const int joined : {0, static_cast<int>(kVMax)}) {
      m.joined = joined;
      ShellState s = make_state(m, Vec3::Zero(), 1);
      OwnGround kept;
      const std::vector<std::pair<Vec2, Vec2>> edges = {
          {{0.12, 0.05}, {0.11, 0.15}},     {{0.02, 0.08}, {0.06, 0.085}},    {{0.103, 0.06}, {0.1, 0.094}},
          {{0.01, 0.186}, {0.04, 0.188}},   {{0.085, 0.1}, {0.09, 0.115}},    {{0.0, 0.075}, {0.02, 0.1}},
          {{0.009, 0.187}, {0.007, 0.199}}, {{0.106, 0.101}, {0.104, 0.099}},
      };
      double before = 1.0;
      for (std::size_t c = 0; c <= edges.size(); ++c) {
        int own = 0, all = 0;
        for (double x = -radius; x <= radius; x += radius / 60)
          for (double y = -radius; y <= radius; y += radius / 60) {
            const double away = std::hypot(x, y);
            if (away > radius) continue;
            const Vec2 q = p + Vec2(x, y);
            bool mine = q.minCoeff() >= 0.0 && q.x() <= 0.2 && (joined != 0 || q.y() <= 0.2);
            for (std::size_t e = 0; e < s.cracks.graph.edges().size() && mine; ++e) {
              const CrackEdge& edge = s.cracks.graph.edges()[e];
              const Vec2 d = edge.b - edge.a;
              mine =
                  edge.face == 0
                      ? !segments_meet(p, q, edge.a, edge.b)
                      : (q - edge.a - std::clamp((q - edge.a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm() >= away;
            }
            own += mine, ++all;
          }
        OwnGround fresh;
        const double share = kept.share(m, s.cracks.graph, p, radius);
        OwnGround other;  // what was asked before decides nothing: runs may be resumed
        for (const double times : {0.917, 0.3, 2.5}) other.share(m, s.cracks.graph, p, times * radius);
        EXPECT_NEAR(share, static_cast<double>(own) / all, 0.05) << p.transpose() << ", " << c << " edges";
        EXPECT_EQ(share, other.share(m, s.cracks.graph, p, radius));
        EXPECT_EQ(share, fresh.share(m, s.cracks.graph, p, radius));
        EXPECT_LE(share, before);
        before = share;
        if (c == edges.size()) break;
        const int from = s.cracks.graph.add_vertex(edges[c].first), to = s.cracks.graph.add_vertex(edges[c].second);
        s.cracks.graph.add_edge(from, to, s.cracks.graph.new_crack(), 0.0, c < 4 ? 1 : 0);  // cracks, then cuts
      }
      EXPECT_LT(before, 0.6);
      EXPECT_GT(kept.share(m, s.cracks.graph, p, 0.1 * radius), before);  // a shorter crack relieves less
    }
}

// A sheet that is stretched alike everywhere, by a tenth more than it bears, whatever cracks. Once tips rest only
// their ground keeps flaws from starting as near to one another as the rules' clearances let them.
TEST(Flaws, StartOnlyWhereTheyHaveTheGround) {
  OverstressedBand band(1.0, 2.0, 11.0 / 12.0);
  const CrackRules rules = make_crack_rules(band.m, 0.0);
  std::uint64_t random = 1;
  for (int look = 0; look < 200; ++look) {
    compute_forces(band.m, band.s, false, 1.0, 1);
    const std::size_t before = band.s.cracks.graph.edges().size();
    const CrackGraph older = band.s.cracks.graph;
    nucleate(band.m, band.s, rules, 1e-6 * look, random);
    if (band.s.cracks.graph.edges().size() == before) break;
    const CrackEdge& e = band.s.cracks.graph.edges()[before];
    const double half_length = critical_length(band.m.material, 10e6, 1.0, 0.0);
    OwnGround ground;
    EXPECT_GE(1.3 * ground.share(band.m, older, 0.5 * (e.a + e.b), 2.0 * half_length), 0.5) << "edge " << before;
    for (Tip& tip : band.s.cracks.tips) tip.alive = false;
  }
  EXPECT_GT(band.s.cracks.graph.edges().size(), 4u);
}

// In the field of a crack that opens with four times the energy that it takes; one divides at twice.
TEST(Tips, DivideOnlyAfterTheLengthOfAWholeCrack) {
  const auto tips_after_an_edge = [](double flaw, double since) {
    const ShellModel m = sheet();
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{0.1, -0.01}, {0.1, 0.08}}, 0.0);
    const double e = m.material.youngs_modulus, nu = m.material.poisson_ratio, kappa = (3.0 - nu) / (1.0 + nu);
    const double k1 = 2.0 * std::sqrt(e * m.material.fracture_energy), shear = 0.5 * e / (1.0 + nu);
    for (int k = 0; k < m.control_points(); ++k) {
      const Vec2 d = m.parameter[k] - Vec2(0.1, 0.08);
      const double angle = std::atan2(-d.x(), d.y()), sine = std::sin(0.5 * angle), cosine = std::cos(0.5 * angle);
      const double u = 0.5 * k1 / shear * std::sqrt(d.norm() / (2.0 * std::numbers::pi));
      s.motion.x[m.tables.slot(k)] -= u * sine * (kappa + 1.0 - 2.0 * cosine * cosine);
      s.motion.x[m.tables.plane + m.tables.slot(k)] += u * cosine * (kappa - 1.0 + 2.0 * sine * sine);
    }
    compute_forces(m, s, false, 1.0, 1);
    start_at_ends(m, s, 0, static_cast<int>(s.cracks.graph.edges().size()));
    EXPECT_EQ(s.cracks.tips.size(), 1u);
    s.cracks.tips[0].since_branch = since, s.cracks.tips[0].flaw = flaw, s.cracks.tips[0].grown = 1.0,
    s.cracks.tips[0].first_turn = 0.0;
    const CrackRules r = make_crack_rules(m, 0.0);
    std::uint64_t random = 1;
    std::fill(s.layers.strength.begin(), s.layers.strength.end(), 1e12);  // nothing else cracks
    for (int looks = 0; looks < 100 && s.cracks.tips[0].grown == 1.0; ++looks)
      grow_cracks(m, s, r, 0.0, 0.3 * r.advance / r.rayleigh, random);
    EXPECT_GT(s.cracks.tips[0].grown, 1.0);
    return s.cracks.tips.size();
  };
  EXPECT_EQ(tips_after_an_edge(0.0, 0.09), 2u);   // 9 spacings
  EXPECT_EQ(tips_after_an_edge(0.0, 0.07), 1u);   // 7
  EXPECT_EQ(tips_after_an_edge(0.04, 0.09), 2u);  // a crack of 8
  EXPECT_EQ(tips_after_an_edge(0.05, 0.09), 1u);  // of 10
}

TEST(Flaws, OpenWhereTheStrengthIsAShareOfTheMaterialsAsElsewhere) {
  OverstressedBand weak(0.04, 6.0);
  weak.m.strength_factor.assign(weak.s.layers.strength.size(), 0.5f);
  for (int k = 0; k < weak.m.control_points(); ++k)
    for (int d = 0; d < 2; ++d)
      weak.s.motion.x[d * weak.m.tables.plane + weak.m.tables.slot(k)] =
          0.5 * (weak.s.motion.x[d * weak.m.tables.plane + weak.m.tables.slot(k)] + weak.m.parameter[k][d]);
  EXPECT_TRUE(weak.opens());
}

TEST(Flaws, OpenNothingBetweenTwoThatAreTooClose) {
  OverstressedBand one(0.04, 6.0), two(0.04, 6.0);
  for (OverstressedBand* band : {&one, &two}) insert_polyline(band->m, band->s, {{0.05, 0.1085}, {0.15, 0.10851}}, 0.0);
  insert_polyline(two.m, two.s, {{0.05, 0.0915}, {0.15, 0.0916}}, 0.0);
  EXPECT_TRUE(one.opens());  // runs on from the other
  EXPECT_FALSE(two.opens());
  OverstressedBand shorter(0.04, 2.0), more(0.04, 6.0, 2.0);  // which fits between, as does that at twice the stress
  for (OverstressedBand* band : {&shorter, &more})
    for (const double y : {0.1085, 0.0915}) insert_polyline(band->m, band->s, {{0.05, y}, {0.15, y + 1e-4}}, 0.0);
  EXPECT_TRUE(shorter.opens());
  EXPECT_TRUE(more.opens());
}

TEST(NearCracks, KeptWhileCracksGrowAreThoseFoundAnew) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 0.2);
  const double reach = 0.025, clearance = 0.02;
  CrackGraph g({0, 0}, {0.2, 0.2}, 0.02, 1e-4);
  std::vector<Vec2> points;
  for (int i = 0; i < 80; ++i) points.emplace_back(uniform(random), uniform(random));
  std::vector<NearCracks> kept(points.size());
  int shielded = 0, open = 0;
  for (int step = 0; step < 40; ++step) {
    for (int k = 0; k < 12; ++k) {
      const Vec2 a(uniform(random), uniform(random)), d(uniform(random) - 0.1, uniform(random) - 0.1);
      const int from = g.add_vertex(a);
      g.add_edge(from, g.add_vertex(a + 0.01 * d.normalized()), g.new_crack(), 0.0, 0);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::vector<SeenEdge>& seen = kept[i].seen(g, points[i], reach, clearance, kParallel);
      std::vector<SeenEdge> all;
      for (int e = 0; e < static_cast<int>(g.edges().size()); ++e) {
        Vec2 foot;
        const double distance = g.distance(points[i], e, foot);
        if (distance < reach && g.visible(points[i], foot + 0.02 * (points[i] - foot), e))
          all.push_back({distance, foot, (g.edges()[e].b - g.edges()[e].a).normalized()});
      }
      ASSERT_EQ(seen.size(), all.size()) << "step " << step << ", point " << i;
      for (std::size_t k = 0; k < all.size(); ++k) {
        EXPECT_EQ(seen[k].distance, all[k].distance);
        EXPECT_EQ(seen[k].foot, all[k].foot);
        EXPECT_EQ(seen[k].along, all[k].along);
      }
      int unshielded = 0;  // of directions
      for (int angle = 0; angle < 3600; ++angle) {
        const Vec2 d(std::cos(angle * std::numbers::pi / 3600), std::sin(angle * std::numbers::pi / 3600));
        unshielded += std::none_of(all.begin(), all.end(), [&](const SeenEdge& e) {
          return e.distance < clearance && std::abs(e.along.dot(d)) > kParallel;
        });
      }
      EXPECT_EQ(kept[i].shield_all(), unshielded == 0) << "step " << step << ", point " << i;
      ++(kept[i].shield_all() ? shielded : open);
    }
  }
  EXPECT_GT(shielded, 100);
  EXPECT_GT(open, 100);
}
