// What surrounds a point near cracks: kept between two looks, it is what a whole look would find.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/surroundings.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/wanderers.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kParallel = 0.85;

void expect_same(const std::vector<SeenPoint>& a, const std::vector<SeenPoint>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    ASSERT_TRUE(a[k].block == b[k].block && a[k].lane == b[k].lane && a[k].offset == b[k].offset &&
                a[k].angle == b[k].angle && a[k].weight == b[k].weight);
}

}  // namespace

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

TEST(Surroundings, AreTheSameWhetherKeptOrFoundAnew) {
  const ShellModel m = wandered_sheet();
  Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(3)};
  std::vector<std::pair<Look, Surroundings>> kept;
  for (int k = 0; k < 40; ++k) {
    const double angle = w.uniform(0.0, 2.0 * std::numbers::pi);
    kept.push_back({{{w.uniform(0.0, kSide), w.uniform(0.0, kSide)},
                     2.5 * m.spacing,
                     k % 2 ? Vec2(std::cos(angle), std::sin(angle)) : Vec2(Vec2::Zero()),
                     k % 4 == 1 ? k : -1},
                    {}});
  }
  w.start();
  std::vector<std::size_t> uncracked;
  for (auto& [look, known] : kept) uncracked.push_back(known.seen(m, w.graph, look).size());
  int hidden = 0;
  for (int step = 0; step < 400; ++step) {
    w.step();
    if (step % 7 != 0) continue;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      auto& [look, known] = kept[i];
      expect_same(known.seen(m, w.graph, look), Surroundings().seen(m, w.graph, look));
      if (step > 390) hidden += 2 * known.seen(m, w.graph, look).size() < uncracked[i];
    }
  }
  EXPECT_GT(hidden, 20U);              // cracks did hide some
  auto& [look, known] = kept.front();  // another look is no old one
  look.p += Vec2(0.013, 0.004);
  expect_same(known.seen(m, w.graph, look), Surroundings().seen(m, w.graph, look));
}

TEST(Neighbours, AreWhatSurroundsAPointWhetherKeptOrFoundAnew) {
  const ShellModel m = wandered_sheet();
  Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(5)};
  std::vector<std::pair<Vec2, Neighbours>> kept;
  for (int k = 0; k < 40; ++k) kept.push_back({{w.uniform(0.0, kSide), w.uniform(0.0, kSide)}, {}});
  w.start();
  std::size_t most = 0, least = 1000000;
  for (int step = 0; step < 400; ++step) {
    w.step();
    if (step % 7 != 0) continue;
    for (auto& [p, known] : kept) {
      // now a larger circle, now the first again
      const double radius = (step % 91 == 0 ? 3.5 : 2.5) * m.spacing;
      const auto& near = known.seen(m, w.graph, p, radius);
      Surroundings anew;
      const auto& around = anew.seen(m, w.graph, {p, radius});
      ASSERT_EQ(near.size(), around.size());
      most = std::max(most, near.size()), least = std::min(least, near.size());
      for (std::size_t i = 0; i < near.size(); ++i) {
        EXPECT_EQ(near[i].block, around[i].block);
        EXPECT_EQ(near[i].lane, around[i].lane);
        EXPECT_EQ(near[i].weight, around[i].weight);
      }
    }
  }
  EXPECT_LT(3 * least, most);  // cracks did hide some
}
