// Division of surfaces into charts.
#include "shell/meshes/charts.h"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSharp = 0.7;  // [rad]

// Every triangle is in one chart, every chart a disc with holes that is stretched by no more than is allowed.
std::vector<Chart> expect_charts(const TriangleMesh& m, int count, const ChartRules& rules = {0.1, 1.7, {}}) {
  const std::vector<Chart> charts = charts_of(m, creases_of(m, kSharp), rules);
  EXPECT_EQ(static_cast<int>(charts.size()), count);
  std::vector<int> uses(m.triangles.size(), 0);
  for (const Chart& c : charts) {
    double area = 0.0, above = 0.0;
    for (std::size_t k = 0; k < c.triangles.size(); ++k) {
      ++uses[c.triangles[k]];
      EXPECT_EQ(c.flat.triangles[k], c.triangles[k]);
      EXPECT_LT(c.flat.most[k], 1e8);
      area += m.area(c.triangles[k]), above += c.flat.most[k] > rules.most_stretch ? m.area(c.triangles[k]) : 0.0;
    }
    EXPECT_LE(above, 0.01 * area);
    EXPECT_EQ(shape_of(m, c.triangles).handles, 0);
    EXPECT_GE(shape_of(m, c.triangles).loops, 1);
  }
  for (const int n : uses) EXPECT_EQ(n, 1);
  return charts;
}

Vec3 on_tube(double u, double v) { return {0.2 * std::cos(2.0 * M_PI * u), 0.2 * std::sin(2.0 * M_PI * u), v}; }

TEST(Charts, APlateIsOneAndATubeTwo) {
  expect_charts(lattice(12, 12, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh(), 1);
  const TriangleMesh tube = lattice(24, 12, true, on_tube).mesh();
  for (const Chart& c : expect_charts(tube, 2)) EXPECT_EQ(shape_of(tube, c.triangles).loops, 1);
}

TEST(Charts, ABowlIsOneAndASphereTwo) {
  expect_charts(lattice(20, 20, false,
                        [](double u, double v) {
                          return Vec3(u - 0.5, v - 0.5, 0.8 * (std::pow(u - 0.5, 2) + std::pow(v - 0.5, 2)));
                        })
                    .mesh(),
                1);
  expect_charts(ball(1.0, 8).mesh(), 2);
}

TEST(Charts, SidesOfABoxAreSix) {
  Triangles t{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {}};
  for (const auto& f : std::vector<std::array<int, 4>>{
           {0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}})
    t.add(f[0], f[1], f[2]), t.add(f[0], f[2], f[3]);
  expect_charts(t.mesh(), 6);
}

TEST(Charts, AClosedSurfaceWithAHandleIsDivided) {
  const TriangleMesh m = ring().mesh();
  const int count = static_cast<int>(charts_of(m, creases_of(m, kSharp), {0.1, 1.7, {}}).size());
  EXPECT_LE(count, 8);
  expect_charts(m, count);
}

TEST(Charts, ASmallPartBetweenCreasesJoinsItsNeighbour) {
  const TriangleMesh m = lattice(10, 10, false, [](double u, double v) {
                           return Vec3(u, v, (u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5) < 0.02 ? 0.3 : 0.0);
                         }).mesh();
  const auto sharp = creases_of(m, kSharp);
  const auto parts = [&](const std::vector<std::array<char, 3>>& creases) {
    const std::vector<Chart> charts = charts_of(m, creases, {0.0, 4.0, {}});
    double least = 1e300;
    for (const Chart& c : charts) {
      double area = 0.0;
      for (const int t : c.triangles) area += m.area(t);
      least = std::min(least, area);
    }
    return std::pair(charts.size(), least);
  };
  EXPECT_LT(parts(sharp).second, 0.1);
  const auto [count, least] = parts(without_small_parts(m, sharp, 0.1));
  EXPECT_LT(count, parts(sharp).first);
  EXPECT_GT(least, 0.1);
  EXPECT_EQ(without_small_parts(m, sharp, 0.0), sharp);
}

TEST(Charts, PartsStayApart) {
  const TriangleMesh m = lattice(12, 12, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh();
  ChartRules rules{0.1, 1.7, {}};
  for (std::size_t k = 0; k < m.triangles.size(); ++k) rules.parts.push_back(m.middle(static_cast<int>(k)).x() > 0.5);
  for (const Chart& c : expect_charts(m, 2, rules))
    EXPECT_GT(c.flat.triangles.size(), c.triangles.size());  // and know their neighbours
}

TEST(Charts, NeighboursEndAtCreasesAndAtTheReach) {
  const TriangleMesh m =
      lattice(20, 4, false, [](double u, double v) { return Vec3(u, v * 0.2, u < 0.5 ? 0.0 : u - 0.5); }).mesh();
  std::vector<int> left;
  for (std::size_t k = 0; k < m.triangles.size(); ++k)
    if (m.middle(static_cast<int>(k)).x() < 0.2) left.push_back(static_cast<int>(k));
  double most = 0.0;
  for (const int t : with_neighbours(m, creases_of(m, kSharp), left, 0.15)) most = std::max(most, m.middle(t).x());
  EXPECT_GT(most, 0.25);
  EXPECT_LT(most, 0.4);
  most = 0.0;
  for (const int t : with_neighbours(m, creases_of(m, 0.3), left, 10.0)) most = std::max(most, m.middle(t).x());
  EXPECT_LT(most, 0.55);
}

}  // namespace
