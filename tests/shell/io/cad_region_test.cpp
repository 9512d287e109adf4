// Regions of curves that lines divide.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/io/cad_region.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RegionLoop polygon(const std::vector<Vec2>& p) {
  RegionLoop out;
  for (std::size_t k = 0; k < p.size(); ++k)
    out.push_back([a = p[k], b = p[(k + 1) % p.size()]](double t) { return Vec2(a + t * (b - a)); });
  return out;
}

RegionLoop circle(const Vec2& centre, double radius, double turns) {
  return {[=](double t) {
    const double at = 2.0 * std::numbers::pi * turns * t + 0.3;
    return Vec2(centre + radius * Vec2(std::cos(at), std::sin(at)));
  }};
}

double area(const Region& region) {
  double sum = 0.0;
  for (const RegionLoop& loop : region) sum += area_of(loop);
  return sum;
}

}  // namespace

TEST(CadRegion, PartsOfASquareWithAHoleAddUp) {
  const Region region{polygon({{0, 0}, {2, 0}, {2, 1}, {0, 1}}), circle({1.1, 0.5}, 0.3, -1)};
  for (const int axis : {0, 1})
    for (const double at : {0.45, 0.55, 0.7}) {
      const Region low = part_of(region, axis, at, true), high = part_of(region, axis, at, false);
      EXPECT_NEAR(area(low) + area(high), area(region), 1e-4);  // polygons through 128 points a circle
      EXPECT_GT(area(low), 0.0);
      for (const bool below : {true, false})
        for (const RegionLoop& loop : below ? low : high)
          for (std::size_t k = 0; k < loop.size(); ++k) {  // closed, and on its side
            EXPECT_LT((loop[k](1.0) - loop[(k + 1) % loop.size()](0.0)).norm(), 1e-12);
            for (const double t : {0.0, 0.3, 0.5, 0.8, 1.0})
              EXPECT_LT((loop[k](t)[axis] - at) * (below ? 1.0 : -1.0), 1e-9);
          }
    }
}

TEST(CadRegion, ALineThroughTheHoleLeavesOneLoopOnEachSide) {
  const Region region{polygon({{0, 0}, {2, 0}, {2, 1}, {0, 1}}), circle({1, 0.5}, 0.3, -1)};
  const Region low = part_of(region, 0, 1.0, true);
  ASSERT_EQ(low.size(), 1u);
  EXPECT_NEAR(area(low), 1.0 - 0.5 * std::numbers::pi * 0.09, 1e-4);
  EXPECT_EQ(part_of(region, 0, 0.5, true).size(), 1u);  // the hole is elsewhere
  EXPECT_EQ(part_of(region, 0, 1.5, true).size(), 2u);  // and here
  EXPECT_TRUE(part_of(region, 0, -1.0, true).empty());
}

TEST(CadRegion, PiecesThatAreApartAreSeveral) {
  const Region u{polygon({{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}),
                 circle({0.5, 1.6}, 0.2, -1)};
  const std::vector<Region> legs = connected(part_of(u, 1, 1.2, false));
  ASSERT_EQ(legs.size(), 2u);
  EXPECT_EQ(legs[0].size() + legs[1].size(), 3u);  // one of them with the hole
  for (const Region& leg : legs) EXPECT_NEAR(area(leg), leg.size() > 1 ? 0.8 - std::numbers::pi * 0.04 : 0.8, 1e-4);
}

TEST(CadRegion, AHoleOutsideOfAllBordersIsRefused) {
  const Region square{polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), circle({3, 0.5}, 0.2, -1)};
  EXPECT_THROW(connected(square), Error);
}

TEST(CadRegion, LinesNearCornersAreNotClean) {
  const Region region{polygon({{0, 0}, {2, 0}, {2, 1}, {0, 1}})};
  EXPECT_TRUE(crosses_cleanly(region, 0, 1.0, 0.01));
  EXPECT_FALSE(crosses_cleanly(region, 0, 1.995, 0.01));
}

TEST(CadRegion, ABorderThatDoesNotGoRoundIsRefused) {
  // clockwise, the region would lie outside
  EXPECT_THROW(part_of({polygon({{0, 0}, {0, 1}, {2, 1}, {2, 0}})}, 0, 1.0, true), Error);
}
