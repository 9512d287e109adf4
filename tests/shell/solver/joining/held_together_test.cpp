// What forces still hold together: cracks, seams, ties and bands of full damage.
#include "shell/solver/joining/held_together.h"

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Two halves of a square of 0.3 m, sewn at x = 0.15; the elements are 7.5 mm wide.
Stitched halves() {
  return Stitched(
      {panel("left", flat(0.0, 0.15, 0.0, 0.3, 20, 40), 0.3), panel("right", flat(0.15, 0.3, 0.0, 0.3, 20, 40), 0.3)});
}

// Complete damage of the left half in elements between `low` and `high` [m] along y, of both layers or of one.
void spend(Stitched& s, double low, double high, bool both = true) {
  s.state(0).layers.brittleness = brittleness(kStrength, kYoung, kToughness, width(s.model(0)));
  damage_where(s.model(0), s.state(0), [&](const Vec2& p) {
    const double y = s.model(0).patch.evaluate(p).x.y();
    return y > low && y < high;
  });
  for (PointDamage& d : s.state(0).cracked.damage) d.now[1] = both ? d.now[0] : 0.0f;
}

}  // namespace

TEST(HeldAreas, SewnHalvesAreOnePartAndOpenOnesTwo) {
  Stitched s = halves();
  std::vector<double> areas = held_areas(s.refs(), s.stitching());
  ASSERT_EQ(areas.size(), 1u);
  EXPECT_NEAR(areas[0], 0.09, 1e-12);
  for (const Seam& seam : s.seams()) s.stitching().open(s.refs(), seam, 0.0, 1.0);
  s.stitching().release_corners(s.refs(), s.seams());
  areas = held_areas(s.refs(), s.stitching());
  ASSERT_EQ(areas.size(), 2u);
  EXPECT_NEAR(areas[1], 0.045, 1e-12);
}

TEST(HeldAreas, ACrackAcrossPartsWhatItCutsOff) {
  Stitched s = halves();
  insert_polyline(s.model(0), s.state(0), {{0.0, 0.1}, {0.15, 0.1}}, 0.0);
  EXPECT_EQ(held_areas(s.refs(), s.stitching()).size(), 1u);  // round the end of the crack, by the seam
  insert_polyline(s.model(1), s.state(1), {{0.0, 0.1}, {0.15, 0.1}}, 0.0);
  for (const Seam& seam : s.seams()) s.stitching().open(s.refs(), seam, 0.0, 1.0);
  s.stitching().release_corners(s.refs(), s.seams());
  const std::vector<double> areas = held_areas(s.refs(), s.stitching());
  ASSERT_EQ(areas.size(), 4u);
  for (const double wanted : {0.015, 0.03}) EXPECT_NEAR(wanted == 0.03 ? areas[0] : areas[3], wanted, 0.02 * wanted);
}

TEST(HeldAreas, WhatWasHandedOffIsLeftOut) {
  Stitched s = halves();
  insert_polyline(s.model(0), s.state(0), {{0.03, 0.03}, {0.09, 0.03}, {0.09, 0.09}, {0.03, 0.09}, {0.03, 0.03}}, 0.0);
  EXPECT_EQ(held_areas(s.refs(), s.stitching()).size(), 2u);
  std::vector<Piece> pieces;
  const Triangulation t = partition(s.model(0), s.state(0), pieces);
  const Piece& small = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
  hand_off(s.model(0), s.state(0), t, small, 7, 0.0);
  const std::vector<double> areas = held_areas(s.refs(), s.stitching());
  ASSERT_EQ(areas.size(), 1u);
  EXPECT_NEAR(areas[0], 0.09 - 0.0036, 0.01 * 0.0036);
}

// A Gauss point moves control points up to two elements away, so a band must be wider than that to hold nothing.
TEST(HeldAreas, ABandOfFullDamageHoldsNothing) {
  Stitched narrow = halves();
  spend(narrow, 0.15, 0.155);
  EXPECT_EQ(held_areas(narrow.refs(), narrow.stitching()).size(), 1u);
  Stitched cracked = halves();  // on one face only
  spend(cracked, 0.12, 0.18, false);
  EXPECT_NEAR(held_areas(cracked.refs(), cracked.stitching()).at(0), 0.09, 1e-12);
  Stitched wide = halves();
  spend(wide, 0.12, 0.18);
  for (const Seam& seam : wide.seams()) wide.stitching().open(wide.refs(), seam, 0.0, 1.0);
  wide.stitching().release_corners(wide.refs(), wide.seams());
  const std::vector<double> areas = held_areas(wide.refs(), wide.stitching());
  ASSERT_EQ(areas.size(), 3u);
  EXPECT_NEAR(areas[0], 0.045, 1e-12);
  EXPECT_NEAR(areas[1] + areas[2], 0.15 * 0.24, 0.02 * 0.15 * 0.24);
  EXPECT_EQ(wide.state(0).cracks.graph.edges().size(), 0u);
}
