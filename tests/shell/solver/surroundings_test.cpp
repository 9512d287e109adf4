// What a crack that starts has about it: how far its line is free, and what is stored in its own ground.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/critical_sheet.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel sheet(int degree = 2) {
  return make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity(), degree), 0.004, glass(), 2, degree,
                    {});
}

}  // namespace

TEST(Ground, LinesEndAtCracksAndAtTheBorder) {
  const ShellModel m = sheet();  // 0.2 m
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
TEST(Ground, StoredIsWhatTensionAcrossThemDoesInTheirGround) {
  for (const int degree : {2, 3}) {
    const ShellModel m = sheet(degree);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const Vec2 p(0.1, 0.1), u(1, 0), v(0, 1);
    const double radius = 0.06, bent = 1e14 / 3.0;       // to 10 MPa
    const auto fill = [&](double below, auto&& above) {  // across v, on the lower face a share of the upper's
      for (int q = 0; q < m.tables.blocks(); ++q)
        for (int lane = 0; lane < m.tables.spans_u; ++lane)
          for (int k = 0; k < 6; ++k)
            s.layers.surface_stress[m.tables.at(q, 6, k, lane)] =
                k % 3 == 1 ? (k < 3 ? below : 1.0) * above(gauss_point(m.patch, m.tables, q, lane).parameter) : 0.0;
    };
    const auto stored = [&](int face, const Vec2& along, double even) {
      OwnGround own;
      return stored_in_ground(m, s, own, radius, p, along, face, even);
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
    OwnGround own;
    const double share = own.share(m, s.cracks.graph, p, radius);
    const double past = 0.012;  // where it ends by its middle line a sector's sides reach so much further
    EXPECT_LT(share, 0.8);
    fill(-1.0, [&](const Vec2& q) { return (q - p).norm() > std::abs(q.y() - below) + past ? 1e12 : 12e6; });
    EXPECT_NEAR(stored(1, u, bent), 1.44 * share, 1e-9);
  }
}

// Every so many elements of a large circle tell what all of them do.
TEST(Ground, StoredInALargeGroundIsTheSame) {
  const ShellModel m = sheet_that_needs(6.0);  // 40 x 40
  ShellState s = make_state(m, Vec3::Zero(), 1);
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int lane = 0; lane < m.tables.spans_u; ++lane) {
      const Vec2 p = gauss_point(m.patch, m.tables, q, lane).parameter;
      s.layers.surface_stress[m.tables.at(q, 6, 3, lane)] =
          10e6 * std::cos(8.0 * (p.x() - 0.1)) * std::cos(8.0 * (p.y() - 0.1));
      s.layers.surface_stress[m.tables.at(q, 6, 0, lane)] = -s.layers.surface_stress[m.tables.at(q, 6, 3, lane)];
    }
  for (const double radius : {0.03, 0.09}) {  // 6 and 18 spacings: all, every other
    double sum = 0.0;
    int all = 0;
    for (double x = -radius; x <= radius; x += radius / 200)
      for (double y = -radius; y <= radius; y += radius / 200) {
        if (std::hypot(x, y) > radius) continue;
        sum += std::pow(std::cos(8.0 * x) * std::cos(8.0 * y), 2), ++all;
      }
    OwnGround own;
    EXPECT_NEAR(stored_in_ground(m, s, own, radius, {0.1, 0.1}, {0.0, 1.0}, 1, 1e14 / 3.0), sum / all, 0.02) << radius;
  }
}

// A crack needs a line of 12 spacings at the strength, 10 MPa times a share of it, and what is stored in a circle of as
// many about it; half of both at the border.
TEST(Ground, StartOnlyWhereTheirGroundStoresTheEnergy) {
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
        for (int k = 0; k < 6; ++k) s.layers.surface_stress[m.tables.at(q, 6, k, lane)] = k % 3 == 0 ? stress : 0.0;
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
