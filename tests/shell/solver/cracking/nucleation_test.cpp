// What a look at the cracks asks of flaws: where tension is above strength, and which cracks are near.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/critical_sheet.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

bool is_above(const ShellModel& m, const ShellState& s, int block, int lane) {
  double face_stress[6];
  for (int k = 0; k < 6; ++k) face_stress[k] = s.layers.face_stress[m.tables.at(block, 6, k, lane)];
  const double high = std::max(principal(face_stress[0], face_stress[1], face_stress[2]).high,
                               principal(face_stress[3], face_stress[4], face_stress[5]).high);
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
      s.motion.x[m.tables.component_stride + m.tables.slot(k)] -= m.material.poisson_ratio * strain * (p.y() - 0.1);
    }
  }
  bool opens(double zone = 1.0) {
    compute_forces(m, s, false, 1.0, 1);
    const double half_length = critical_length(m.material, 10e6, 1.0, 0.0);
    return opens_along(m, s, make_crack_rules(m, 0.0),
                       line_through(m, s.cracks.graph, {0.1, 0.1}, {0.0, 1.0}, half_length), 1,
                       {half_length, 10e6, zone}, 0.0);
  }

  ShellModel m;
  ShellState s;
};

ShellModel glass_sheet(int degree = 2) {
  return make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity(), degree), 0.004, glass(), 2, degree,
                    {});
}

}  // namespace

TEST(Flaws, NoPointAboveItsStrengthIsInABlockThatIsNotTold) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& strength : s.layers.strength) strength *= 1.0 + 0.4 * uniform(random);
  insert_polyline(m, s, {{0.1, 0.04}, {0.11, 0.17}}, 0.0);
  int above = 0, gathered = 0, quiet = 0;
  for (int step = 0; step < 8; ++step) {
    for (int k = 0; k < m.control_points(); ++k) {  // bends one side more and more, about the cut as well
      const Vec2& p = m.parameter[k];
      s.motion.x[2 * m.tables.component_stride + m.tables.slot(k)] =
          0.02 * step * p.y() * p.y() + 2e-6 * step * uniform(random);
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
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, 0.04}, {0.11, 0.17}}, 0.0);
  for (std::size_t g = 0; g < s.layers.strength.size(); ++g)
    s.layers.strength[g] = s.cracked.point_of[g] < 0 ? 1e12 : 1e5;
  for (int k = 0; k < m.control_points(); ++k)
    if ((m.parameter[k] - Vec2(0.1, 0.1)).norm() < 1.2 * m.spacing)
      s.motion.x[2 * m.tables.component_stride + m.tables.slot(k)] = m.parameter[k].x() < 0.1 ? 1e-5 : -1e-5;
  compute_forces(m, s, false, 1.0, 1);
  int told = 0;
  for (int q = 0; q < m.tables.blocks(); ++q) {
    bool above = false, others = false;  // of points that no crack has touched: any stress
    for (int lane = 0; lane < m.tables.spans_u; ++lane) {
      const bool beside = s.cracked.point_of[m.tables.at(q, 1, 0, lane)] >= 0;
      above = above || (beside && is_above(m, s, q, lane));
      for (int k = 0; k < 6 && !beside; ++k)
        others = others || std::abs(s.layers.face_stress[m.tables.at(q, 6, k, lane)]) > 3e4;
    }
    if (!above || others) continue;
    EXPECT_TRUE(s.caches.over[q]) << "block " << q;
    ++told;
  }
  EXPECT_GT(told, 5);
}

TEST(Flaws, KindsOfPointsAreThoseOfTheirEntries) {
  const ShellModel m = brittle_sheet();
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

TEST(Flaws, NeedMoreStressWhereOtherCracksHaveTheZone) {
  OverstressedBand band(0.04, 6.0);  // 1.2 times the strength: 1.44 times the energy
  EXPECT_TRUE(band.opens(0.75));
  EXPECT_FALSE(band.opens(0.65));
}

// Against samples of the circle by the thousand, each asked by itself; edges come one by one.
TEST(Flaws, ZoneIsWhatIsNearerToThemThanToACrackAndBeforeCuts) {
  ShellModel m = brittle_sheet();  // 0.2 m
  const double radius = 0.03;
  for (const Vec2& p : {Vec2(0.1, 0.1), Vec2(0.012, 0.09), Vec2(0.004, 0.197)})
    for (const int joined : {0, static_cast<int>(kVMax)}) {
      m.joined = joined;
      ShellState s = make_state(m, Vec3::Zero(), 1);
      EnergyReleaseZone kept;
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
        EnergyReleaseZone fresh;
        const double share = kept.share(m, s.cracks.graph, p, radius);
        EnergyReleaseZone other;  // what was asked before decides nothing: runs may be resumed
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
// their zone keeps flaws from starting as near to one another as the rules' clearances let them.
TEST(Flaws, StartOnlyWhereTheyHaveTheZone) {
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
    EnergyReleaseZone zone;
    EXPECT_GE(1.3 * zone.share(band.m, older, 0.5 * (e.a + e.b), 2.0 * half_length), 0.5) << "edge " << before;
    for (Tip& tip : band.s.cracks.tips) tip.alive = false;
  }
  EXPECT_GT(band.s.cracks.graph.edges().size(), 4u);
}

TEST(Flaws, OpenWhereTheStrengthIsAShareOfTheMaterialsAsElsewhere) {
  OverstressedBand weak(0.04, 6.0);
  weak.m.strength_factor.assign(weak.s.layers.strength.size(), 0.5f);
  for (int k = 0; k < weak.m.control_points(); ++k)
    for (int d = 0; d < 2; ++d)
      weak.s.motion.x[d * weak.m.tables.component_stride + weak.m.tables.slot(k)] =
          0.5 * (weak.s.motion.x[d * weak.m.tables.component_stride + weak.m.tables.slot(k)] + weak.m.parameter[k][d]);
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

TEST(EnergyReleaseZone, LinesEndAtCracksAndAtTheBorder) {
  const ShellModel m = glass_sheet();  // 0.2 m
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const Vec2 p(0.08, 0.11), along = Vec2(3, 4).normalized();
  const FlawLine alone = line_through(m, s.cracks.graph, p, along, 0.02);
  EXPECT_EQ(alone.ahead, 0.02);
  EXPECT_EQ(alone.behind, 0.02);
  const FlawLine whole = line_through(m, s.cracks.graph, p, along, 1e9);
  EXPECT_NEAR(whole.ahead, 0.09 / 0.8, 1e-12);  // to v = 0.2
  EXPECT_NEAR(whole.behind, 0.08 / 0.6, 1e-12);
  const auto crack = [&](const Vec2& a, const Vec2& b) {
    s.cracks.graph.add_edge(s.cracks.graph.add_vertex(a), s.cracks.graph.add_vertex(b), s.cracks.graph.new_crack(), 0.0,
                            1);
  };
  crack({0.14, 0.02}, {0.14, 0.2});  // crosses ahead at 0.1 m
  crack({0.1, 0.12}, {0.13, 0.14});  // beside
  crack({0.11, 0.1}, {0.11, 0.16});  // crosses ahead at 0.05 m
  crack({0.02, 0.08}, {0.1, 0.08});  // behind at 0.03 / 0.8 m
  const FlawLine between = line_through(m, s.cracks.graph, p, along, 1.0);
  EXPECT_NEAR(between.ahead, 0.05, 1e-12);
  EXPECT_NEAR(between.behind, 0.0375, 1e-12);
  EXPECT_EQ(between.length(), between.ahead + between.behind);
  EXPECT_EQ(line_through(m, s.cracks.graph, p, along, 0.03).length(), 0.06);
  crack({0.1, 0.01}, {0.13, 0.01});  // on its line ahead, beside it and over it
  EXPECT_NEAR(line_through(m, s.cracks.graph, {0.04, 0.01}, {1.0, 0.0}, 0.1).ahead, 0.06, 0.01 * m.spacing);
  EXPECT_EQ(line_through(m, s.cracks.graph, {0.04, 0.01}, {-1.0, 0.0}, 0.03).ahead, 0.03);
  EXPECT_EQ(line_through(m, s.cracks.graph, {0.04, 0.0101}, {1.0, 0.0}, 0.1).ahead, 0.1);
  EXPECT_EQ(line_through(m, s.cracks.graph, {0.11, 0.01}, {1.0, 0.0}, 0.1).length(), 0.0);
}

// Stress is written into the points, as no sheet need bear it.
TEST(EnergyReleaseZone, StoredIsWhatTensionAcrossThemDoesInTheirZone) {
  for (const int degree : {2, 3}) {
    const ShellModel m = glass_sheet(degree);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const Vec2 p(0.1, 0.1), u(1, 0), v(0, 1);
    const double radius = 0.06, bent = 1e14 / 3.0;       // to 10 MPa
    const auto fill = [&](double below, auto&& above) {  // across v, on the lower face a share of the upper's
      for (int q = 0; q < m.tables.blocks(); ++q)
        for (int lane = 0; lane < m.tables.spans_u; ++lane)
          for (int k = 0; k < 6; ++k)
            s.layers.face_stress[m.tables.at(q, 6, k, lane)] =
                k % 3 == 1 ? (k < 3 ? below : 1.0) * above(gauss_point(m.patch, m.tables, q, lane).parameter) : 0.0;
    };
    const auto stored = [&](int face, const Vec2& along, double even) {
      EnergyReleaseZone own;
      return stored_in_zone(m, s, own, radius, p, along, face, even);
    };
    const auto everywhere = [](const Vec2&) { return 12e6; };
    fill(-1.0, everywhere);
    EXPECT_NEAR(stored(1, u, bent), 1.44, 1e-9);
    EXPECT_EQ(stored(-1, u, bent), 0.0);  // pressed
    EXPECT_EQ(stored(1, v, bent), 0.0);   // nothing opens it
    fill(1.0, everywhere);                // stretched, it stores three times as much
    EXPECT_NEAR(stored(1, u, bent), 3.0 * 1.44, 1e-9);
    EXPECT_NEAR(stored(1, u, stored_by(10e6, 0.0)), 1.44, 1e-9);
    fill(0.0, everywhere);  // half and half
    EXPECT_NEAR(stored(1, u, stored_by(5e6, 5e6)), 1.44, 1e-9);
    fill(-11.0, everywhere);  // pulled by 12 MPa on its face, though all in all it is pressed
    EXPECT_NEAR(stored(1, u, bent), 1.44, 1e-9);
    fill(-1.0 / 3.0, everywhere);  // 4 MPa stretch it, 8 bend it
    EXPECT_NEAR(stored(1, u, 1e14), 0.16 + 0.64 / 3.0, 1e-9);
    // in a strip of half the circle's width, and half as much beyond, which is pressed on one side
    fill(-1.0, [&](const Vec2& q) {
      return std::abs(q.y() - p.y()) < 0.5 * radius ? 12e6 : q.y() > p.y() ? 6e6 : -6e6;
    });
    const double strip = (2.0 * std::asin(0.5) + std::sqrt(0.75)) / std::numbers::pi;
    EXPECT_NEAR(stored(1, u, bent), 1.44 * strip + 0.36 * 0.5 * (1.0 - strip), 0.03);
    if (degree == 3) {  // in the middle row of each element, which has 4 / 9 of it
      fill(-1.0, [&](const Vec2& q) { return std::abs(std::fmod(q.y(), 0.01) - 0.005) < 1e-3 ? 12e6 : 0.0; });
      EXPECT_NEAR(stored(1, u, bent), 1.44 * 4.0 / 9.0, 0.01);
    }
    // of what a crack relieves nothing counts
    const double below = 0.07;
    const int from = s.cracks.graph.add_vertex({0.0, below}), to = s.cracks.graph.add_vertex({0.2, below});
    s.cracks.graph.add_edge(from, to, s.cracks.graph.new_crack(), 0.0, 1);
    EnergyReleaseZone own;
    const double share = own.share(m, s.cracks.graph, p, radius);
    const double past = 0.012;  // where it ends by its middle line a sector's sides reach so much further
    EXPECT_LT(share, 0.8);
    fill(-1.0, [&](const Vec2& q) { return (q - p).norm() > std::abs(q.y() - below) + past ? 1e12 : 12e6; });
    EXPECT_NEAR(stored(1, u, bent), 1.44 * share, 1e-9);
  }
}

// Every so many elements of a large circle tell what all of them do.
TEST(EnergyReleaseZone, StoredInALargeZoneIsTheSame) {
  const ShellModel m = sheet_that_needs(6.0);  // 40 x 40
  ShellState s = make_state(m, Vec3::Zero(), 1);
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int lane = 0; lane < m.tables.spans_u; ++lane) {
      const Vec2 p = gauss_point(m.patch, m.tables, q, lane).parameter;
      s.layers.face_stress[m.tables.at(q, 6, 3, lane)] =
          10e6 * std::cos(8.0 * (p.x() - 0.1)) * std::cos(8.0 * (p.y() - 0.1));
      s.layers.face_stress[m.tables.at(q, 6, 0, lane)] = -s.layers.face_stress[m.tables.at(q, 6, 3, lane)];
    }
  for (const double radius : {0.03, 0.09}) {  // 6 and 18 spacings: all, every other
    double sum = 0.0;
    int all = 0;
    for (double x = -radius; x <= radius; x += radius / 200)
      for (double y = -radius; y <= radius; y += radius / 200) {
        if (std::hypot(x, y) > radius) continue;
        sum += std::pow(std::cos(8.0 * x) * std::cos(8.0 * y), 2), ++all;
      }
    EnergyReleaseZone own;
    EXPECT_NEAR(stored_in_zone(m, s, own, radius, {0.1, 0.1}, {0.0, 1.0}, 1, 1e14 / 3.0), sum / all, 0.02) << radius;
  }
}

// A crack needs a line of 12 spacings at the strength, 10 MPa times a share. It also needs the energy that a circle of
// 12 spacings around it stores. At the border it needs half of both.
TEST(EnergyReleaseZone, StartOnlyWhereTheirZoneStoresTheEnergy) {
  struct Sheet {
    double half_width, stress, beside;                   // of a strip along v [m], in it and beside it [Pa]
    double weak_from = 1.0, weak_to = 1.0, share = 1.0;  // off its middle line [m], of the strength
    bool border_only = false;                            // elsewhere nothing breaks
  };
  const auto starts = [](const Sheet& sheet) {
    ShellModel m = sheet_that_needs(6.0);
    const auto at = [&](int q, int lane) { return gauss_point(m.patch, m.tables, q, lane).parameter; };
    m.strength_factor.assign(static_cast<std::size_t>(m.tables.blocks()) * m.tables.lanes, 1.0f);
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int lane = 0; lane < m.tables.spans_u; ++lane) {
        const double off = std::abs(at(q, lane).x() - 0.1);
        if (off >= sheet.weak_from && off < sheet.weak_to)
          m.strength_factor[m.tables.at(q, 1, 0, lane)] = static_cast<float>(sheet.share);
      }
    ShellState s = make_state(m, Vec3::Zero(), 1);
    compute_forces(m, s, false, 1.0, 1);
    s.caches.over.assign(s.caches.over.size(), 1);
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int lane = 0; lane < m.tables.spans_u; ++lane) {
        const Vec2 p = at(q, lane);
        const double stress = std::abs(p.x() - 0.1) < sheet.half_width ? sheet.stress : sheet.beside;
        for (int k = 0; k < 6; ++k) s.layers.face_stress[m.tables.at(q, 6, k, lane)] = k % 3 == 0 ? stress : 0.0;
        if (sheet.border_only && p.y() > 0.005) s.layers.strength[m.tables.at(q, 1, 0, lane)] = 1e12;
      }
    const CrackRules r = make_crack_rules(m, 0.0);
    const double half_length = critical_length(m.material, 10e6, 1.0, 0.0);
    EXPECT_TRUE(opens_along(m, s, r, line_through(m, s.cracks.graph, {0.1, 0.1}, {0.0, 1.0}, half_length), 1,
                            {half_length, 10e6, 1.0}, 0.0));
    std::uint64_t random = 1;
    return nucleate(m, s, r, 0.0, random) > 0;
  };
  EXPECT_TRUE(starts({0.045, 12e6, 0.0}));                     // 1.23 times the energy
  EXPECT_FALSE(starts({0.02, 12e6, 0.0}));                     // 0.6 times, though the line is as long
  EXPECT_TRUE(starts({1.0, 12e6, 0.0, 1.0, 1.0, 1.0, true}));  // 0.72 times for half a line
  // a weak line takes less, and has what all about it stores; what is weak beside a line stores no more for that
  EXPECT_TRUE(starts({1.0, 6e6, 0.0, 0.0, 0.01, 0.5}));
  EXPECT_FALSE(starts({0.03, 12e6, 1.9e6, 0.03, 1.0, 0.2}));
}
