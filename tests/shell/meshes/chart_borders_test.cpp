// Borders of charts as chains and curves.
#include "shell/meshes/chart_borders.h"

#include <gtest/gtest.h>

#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

TEST(ChartBorders, ChainsAreSharedAndLoopsClose) {
  const TriangleMesh m = lattice(10, 10, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh();
  std::vector<int> chart;
  for (std::size_t k = 0; k < m.triangles.size(); ++k) {
    const Vec3 x = m.middle(static_cast<int>(k));
    chart.push_back((x.x() > 0.5 ? 1 : 0) + (x.y() > 0.5 ? 2 : 0));
  }
  const ChartBorders b = borders_of(m, creases_of(m, 0.5), chart, 4);
  int shared = 0;
  for (const BorderChain& c : b.chains) shared += c.right >= 0;
  EXPECT_GE(shared, 4);
  for (const auto& loops : b.loops) {
    ASSERT_EQ(loops.size(), 1u);
    const auto ends = [&](const ChainUse& u) {
      const std::vector<int>& p = b.chains[u.chain].points;
      return u.reversed ? std::pair(p.back(), p.front()) : std::pair(p.front(), p.back());
    };
    for (std::size_t k = 0; k < loops[0].size(); ++k)
      EXPECT_EQ(ends(loops[0][k]).second, ends(loops[0][(k + 1) % loops[0].size()]).first);
  }
}

TEST(ChartBorders, ABorderThatGoesRoundIsOneClosedChain) {
  const TriangleMesh m = ball(1.0, 6).mesh();
  std::vector<int> chart;
  for (std::size_t k = 0; k < m.triangles.size(); ++k) chart.push_back(m.middle(static_cast<int>(k)).z() > 0.05);
  const ChartBorders b = borders_of(m, creases_of(m, 0.7), chart, 2);
  ASSERT_EQ(b.chains.size(), 1u);
  EXPECT_TRUE(b.chains[0].closed);
  EXPECT_EQ(b.chains[0].points.front(), b.chains[0].points.back());
}

TEST(ChartBorders, ACurvePassesItsPointsAndIsSmooth) {
  std::vector<Vec2> p;
  for (int k = 0; k <= 24; ++k) p.emplace_back(std::cos(2.0 * M_PI * k / 24), std::sin(2.0 * M_PI * k / 24));
  p.back() = p.front();
  const PlaneCurve c = curve_through(p, true), back = reversed(c);
  double most = 0.0;
  for (int k = 0; k <= 1000; ++k) most = std::max(most, std::abs(c.at(k / 1000.0).norm() - 1.0));
  EXPECT_LT(most, 2e-4);  // third order in the angle between points, 0.26: slopes are off by its square over 6
  EXPECT_LT((c.at(0.25) - Vec2(0, 1)).norm(), 1e-3);
  EXPECT_LT((c.at(1e-4) - c.at(0.0) + (c.at(1.0) - c.at(1.0 - 1e-4))).norm() / 2e-4, 2.0 * M_PI * 1.001);
  EXPECT_EQ(back.at(0.25), c.at(0.75));
  EXPECT_TRUE(c.closed);
}

// A border along edges that zigzag becomes a curve that is hardly longer than the way across.
TEST(ChartBorders, ARaggedBorderIsSmoothedAndACreaseIsNot) {
  const TriangleMesh m = lattice(16, 16, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh();
  std::vector<int> chart;
  for (std::size_t k = 0; k < m.triangles.size(); ++k) chart.push_back(m.middle(static_cast<int>(k)).x() > 0.52);
  const ChartBorders b = borders_of(m, creases_of(m, 0.5), chart, 2);
  std::vector<ChartPatch> patches;
  for (int c = 0; c < 2; ++c) {
    patches.push_back({plate(1.0, 1.0, 16, 16, Vec3(0.5, 0.5, 0.0), Quat::Identity()), {}});
    for (const Vec3& x : m.points) patches.back().at.emplace_back(x.x(), x.y());
  }
  for (const BorderChain& c : b.chains) {
    if (c.right < 0) continue;
    EXPECT_FALSE(c.crease);
    EXPECT_GT(c.length, 1.15);
    const auto length = [](const std::vector<PlaneCurve>& curves) {
      double sum = 0.0;
      for (const PlaneCurve& curve : curves)
        for (int k = 0; k < 200; ++k) sum += (curve.at((k + 1) / 200.0) - curve.at(k / 200.0)).norm();
      return sum;
    };
    const ChainCurves smooth = curves_of(m, c, patches, 1.0 / 16.0);
    EXPECT_LT(length(smooth.left), 1.08);
    EXPECT_LT(smooth.gap, 1e-12);
    for (int k = 0; k <= 10; ++k) EXPECT_LT((smooth.left[0].at(k / 10.0) - smooth.right[0].at(k / 10.0)).norm(), 1e-9);
    BorderChain crease = c;
    crease.crease = true;
    EXPECT_GT(length(curves_of(m, crease, patches, 1.0 / 16.0).left), 1.1);
  }
}

}  // namespace
