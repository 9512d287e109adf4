// Pieces within pieces: a disc in a ring in a sheet.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/prisms.h"

using namespace sunder;
using namespace sunder::shell;
using sunder::test::volume_of_prisms;

namespace {

constexpr double kRingThickness = 0.004, kInner = 0.031, kOuter = 0.067, kSpin = 40.0;
constexpr int kSides = 72;
const Vec2 kMiddle(0.1013, 0.0987);

std::vector<Vec2> circle(double radius) {
  std::vector<Vec2> points;
  for (int k = 0; k <= kSides; ++k)
    points.push_back(kMiddle + radius * Vec2(std::cos(2.0 * std::numbers::pi * (k % kSides) / kSides),
                                             std::sin(2.0 * std::numbers::pi * (k % kSides) / kSides)));
  return points;
}

// Of the polygon.
double area_within(double radius) { return 0.5 * kSides * radius * radius * std::sin(2.0 * std::numbers::pi / kSides); }
double polar_moment_within(double radius) {
  const double cosine = std::cos(2.0 * std::numbers::pi / kSides);
  return area_within(radius) * radius * radius * (2.0 + cosine) / 6.0;
}

}  // namespace

TEST(NestedPieces, LeaveOneByOneWithTheirMassInertiaAndSpin) {
  ShellMaterial material = glass();
  material.strength = 60e6, material.fracture_energy = 8.0;
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 40, 40, Vec3::Zero(), Quat::Identity()), kRingThickness, material, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, circle(kOuter), 0.0);
  insert_polyline(m, s, circle(kInner), 0.0);
  const Vec3 centre =
      s.at(m.rest, m.tables.slot(0)) + Vec3(kMiddle.x() - m.parameter[0].x(), kMiddle.y() - m.parameter[0].y(), 0);
  for (int i = 0; i < m.control_points(); ++i)
    s.add_velocity(m.tables.slot(i), Vec3(0, 0, kSpin).cross(s.position(m.tables.slot(i)) - centre));
  compute_forces(m, s, false, 0.0, 1);
  std::vector<Piece> pieces;
  partition(m, s, pieces);
  ASSERT_EQ(pieces.size(), 3u);
  const double disc = area_within(kInner), ring = area_within(kOuter) - disc, rest = 0.2 * 0.2 - disc - ring;
  const double per_area = 2500 * kRingThickness;
  for (const double area : {disc, ring, rest}) {
    const Triangulation t = partition(m, s, pieces);
    const auto piece = std::find_if(pieces.begin(), pieces.end(),
                                    [&](const Piece& p) { return std::abs(p.area - area) < 1e-6 * area; });
    ASSERT_NE(piece, pieces.end()) << area;
    ASSERT_FALSE(piece->handed_off);
    const Handoff h = hand_off(m, s, t, *piece, 7, 0.0);
    EXPECT_NEAR(h.body.mass, per_area * area, 1e-12 * per_area * area);
    EXPECT_NEAR(h.area, area, 1e-6 * area);
    if (area == rest) continue;  // its middle is elsewhere
    const double polar =
        polar_moment_within(area == ring ? kOuter : kInner) - (area == ring ? polar_moment_within(kInner) : 0.0);
    EXPECT_NEAR(h.body.principal_inertia.maxCoeff(), per_area * polar, 2e-3 * per_area * polar) << area;
    EXPECT_LT((h.body.motion.position - centre).norm(), 0.02 * m.spacing);
    // lumped masses have another moment of inertia than the piece: 1.5 % where it is 12 spacings wide
    EXPECT_NEAR(h.body.angular_velocity().z(), kSpin, 0.02 * kSpin) << area;
    EXPECT_LT(h.body.motion.velocity.norm(), 0.01 * kSpin * kOuter);
    // convex parts may cut corners, by far less than the 27 % that a filled hole adds to the ring
    EXPECT_NEAR(volume_of_prisms(std::get<ConvexShape>(h.body.shape)), kRingThickness * area,
                0.02 * kRingThickness * area);
  }
  partition(m, s, pieces);
  for (const Piece& p : pieces) EXPECT_TRUE(p.handed_off);
}
