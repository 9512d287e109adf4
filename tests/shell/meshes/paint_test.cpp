// Values at points of a mesh over a patch.
#include "shell/meshes/paint.h"

#include <random>

#include <gtest/gtest.h>

using namespace sunder;
using namespace sunder::shell;

namespace {

// A lattice of n x n cells over a rectangle, with the values of a linear function.
Paint lattice_paint(int n, const Vec2& size) {
  std::vector<PlacedTriangle> triangles;
  std::vector<double> values;
  const auto place = [&](int i, int j) { return Vec2(size.x() * i / n, size.y() * j / n); };
  const auto number = [&](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) values.push_back(3.0 + place(i, j).x() - 2.0 * place(i, j).y());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      triangles.push_back({{place(i, j), place(i + 1, j), place(i + 1, j + 1)},
                           {number(i, j), number(i + 1, j), number(i + 1, j + 1)}});
      triangles.push_back({{place(i, j), place(i + 1, j + 1), place(i, j + 1)},
                           {number(i, j), number(i + 1, j + 1), number(i, j + 1)}});
    }
  return {triangles, values};
}

TEST(Paint, IsExactForLinearValues) {
  std::mt19937_64 random(3);
  const auto chance = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  for (const int n : {1, 7, 60}) {
    const Paint paint = lattice_paint(n, Vec2(2.0, 0.3));
    for (int k = 0; k < 500; ++k) {
      const Vec2 p(2.0 * chance(), 0.3 * chance());
      EXPECT_NEAR(paint.at(p), 3.0 + p.x() - 2.0 * p.y(), 1e-12);
    }
  }
}

TEST(Paint, BeyondAllTrianglesIsThatOfTheNearestPlace) {
  const Paint paint = lattice_paint(20, Vec2(1.0, 1.0));
  EXPECT_NEAR(paint.at(Vec2(0.33, -5.0)), 3.33, 1e-12);
  EXPECT_NEAR(paint.at(Vec2(1.4, 0.5)), 3.0, 1e-12);
  EXPECT_NEAR(paint.at(Vec2(9.0, 7.0)), 2.0, 1e-12);
}

}  // namespace
