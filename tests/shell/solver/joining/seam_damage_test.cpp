// Seams that open where damage is complete.
#include "shell/solver/joining/seam_damage.h"

#include <gtest/gtest.h>

#include "tests/shell/damaging_panel.h"
#include "tests/shell/stitched.h"
#include "tests/shell/torn_fibres.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// Two turned_halves of a square of 0.3 m, which hang together at x = 0.15; the right one has its parameters turned.
Stitched turned_halves(int turns, int right_rows = 40) {
  return Stitched({panel("left", flat(0.0, 0.15, 0.0, 0.3, 20, 40), 0.3),
                   panel("right", turned(flat(0.15, 0.3, 0.0, 0.3, 20, right_rows), turns), 0.3)});
}

/// Rest places along the seam [m] of the points that still join the turned_halves.
std::vector<double> joined_at(Stitched& s) {
  std::vector<double> out;
  s.stitching().each_dependence([&](int shell, int slot, int, int) {
    const ShellModel& m = s.model(shell);
    const Vec3 x = s.state(shell).at(m.rest, slot);
    if (std::abs(x.x() - 0.15) < 1e-9) out.push_back(x.y());
  });
  return out;
}

/// Complete damage in half k, nearer to the seam than `depth` and from `from` to `to` along it [m].
void spend_near_seam(Stitched& s, int k, double depth, double from, double to) {
  s.state(k).layers.brittleness = brittleness(kStrength, kYoung, kToughness, width(s.model(k)));
  damage_where(s.model(k), s.state(k), [&](const Vec2& p) {
    const Vec3 x = s.model(k).patch.evaluate(p).x;
    return std::abs(x.x() - 0.15) < depth && x.y() > from && x.y() < to;
  });
}

SeamDamage watched(Stitched& s) { return SeamDamage(s.seams(), {&s.model(0), &s.model(1)}, {0.075, 0.075}); }

}  // namespace

TEST(SeamDamage, ATearAlongASeamOpensItThereAndNowhereElse) {
  for (const int k : {0, 1})
    for (const int turns : {0, 1, 2, 3})
      for (const int rows : {40, 28}) {
        SCOPED_TRACE(testing::Message() << "half " << k << ", " << turns << " turns, " << rows << " rows");
        Stitched s = turned_halves(turns, rows);
        SeamDamage damage = watched(s);
        EXPECT_FALSE(damage.open(s.refs(), s.seams(), s.stitching()));
        const std::size_t before = joined_at(s).size();
        const Stitched::Sums sums = s.sums();
        spend_near_seam(s, k, s.model(k).spacing, 0.1, 0.2);
        EXPECT_TRUE(damage.open(s.refs(), s.seams(), s.stitching()));
        EXPECT_FALSE(damage.open(s.refs(), s.seams(), s.stitching()));  // nothing more
        const std::vector<double> after = joined_at(s);
        EXPECT_LT(after.size(), before);
        double below = 0.0, above = 0.3;
        for (const double y : after) {
          EXPECT_TRUE(y < 0.14 || y > 0.16) << y;
          (y < 0.15 ? below : above) = y < 0.15 ? std::max(below, y) : std::min(above, y);
        }
        EXPECT_GT(below, 0.075);
        EXPECT_LT(above, 0.225);
        EXPECT_NEAR(s.sums().mass, sums.mass, 1e-14 * sums.mass);
      }
}

TEST(SeamDamage, ATearAcrossASeamLeavesItToTheCrack) {
  Stitched s = turned_halves(0);
  SeamDamage damage = watched(s);
  for (const int k : {0, 1}) spend_near_seam(s, k, 1.0, 0.12, 0.18);
  EXPECT_FALSE(damage.open(s.refs(), s.seams(), s.stitching()));
  EXPECT_FALSE(s.stitching().parted());
}

TEST(SeamDamage, ATearAlongAllOfItPartsTheShells) {
  for (const int turns : {0, 3}) {
    Stitched s = turned_halves(turns);
    SeamDamage damage = watched(s);
    spend_near_seam(s, 1, s.model(1).spacing, -1.0, 1.0);
    EXPECT_TRUE(damage.open(s.refs(), s.seams(), s.stitching()));
    int links = 0;
    s.stitching().each_link([&](int, int, int, int) { ++links; });
    EXPECT_EQ(links, 0);
  }
}

TEST(SeamDamage, WhatHasHealedAndOtherShellsAreLeftAlone) {
  Stitched s = turned_halves(0);
  SeamDamage damage = watched(s), deaf(s.seams(), {&s.model(0), &s.model(1)}, {0.0, 0.0});
  EXPECT_TRUE(deaf.empty());
  spend_near_seam(s, 0, s.model(0).spacing, 0.05, 0.25);
  for (PointDamage& d : s.state(0).cracked.damage) d.now.fill(0.0f);
  EXPECT_FALSE(damage.open(s.refs(), s.seams(), s.stitching()));
}

// Fibres alone, of a shell whose layers are whole.
TEST(SeamDamage, FibresThatAreTornAlongASeamOpenItToo) {
  std::vector<ShellModel> halves{panel("left", flat(0.0, 0.15, 0.0, 0.3, 20, 40), 0.3),
                                 panel("right", flat(0.15, 0.3, 0.0, 0.3, 20, 40), 0.3)};
  halves[0].fibres = tearing_law();
  Stitched s(std::move(halves));
  SeamDamage damage = watched(s);
  s.state(0).layers.brittleness = brittleness(kStrength, kYoung, kToughness, width(s.model(0)));
  const auto beside = [&](const Vec2& p) {
    const Vec3 x = s.model(0).patch.evaluate(p).x;
    return std::abs(x.x() - 0.15) < s.model(0).spacing && x.y() > 0.1 && x.y() < 0.2;
  };
  const std::size_t before = joined_at(s).size();
  tear_fibres_where(s.model(0), s.state(0), 1, beside);
  EXPECT_TRUE(damage.open(s.refs(), s.seams(), s.stitching()));
  EXPECT_LT(joined_at(s).size(), before);
}
