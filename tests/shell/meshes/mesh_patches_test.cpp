// Surfaces of triangles as patches.
#include "shell/meshes/mesh_patches.h"

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kCrease = 0.7;  // [rad]

Vec3 on_short_tube(double u, double v) {
  return {0.2 * std::cos(2.0 * M_PI * u), 0.2 * std::sin(2.0 * M_PI * u), 0.5 * v};
}

TEST(MeshPatches, APlateIsOneWholePatchWithoutTrims) {
  const TriangleMesh m = lattice(17, 13, false, [](double u, double v) { return Vec3(u, 0.3, 0.8 * v); }).mesh();
  const MeshPatches all = patches_of(m, {0.05, kCrease, 2, {}});
  ASSERT_EQ(all.patches.size(), 1u);
  const MeshPatch& p = all.patches[0];
  EXPECT_TRUE(p.loops.empty());
  EXPECT_TRUE(all.seams.empty());
  EXPECT_EQ(p.patch.knots_u.spans() * p.patch.knots_v.spans(), 20 * 16);
  EXPECT_NEAR(p.area, 0.8, 1e-12);
  EXPECT_NEAR(p.patch.knots_u.end() * p.patch.knots_v.end(), 0.8, 1e-9);
  EXPECT_LT(p.error, 1e-9);
}

TEST(MeshPatches, AHoleIsALoop) {
  Triangles t = lattice(20, 20, false, [](double u, double v) { return Vec3(u, v, 0.0); });
  std::erase_if(t.faces, [&](const FileTriangle& f) {
    const Vec3 x = (t.points[f.corners[0]] + t.points[f.corners[1]] + t.points[f.corners[2]]) / 3.0;
    return (x - Vec3(0.5, 0.5, 0.0)).norm() < 0.2;
  });
  const MeshPatches all = patches_of(t.mesh(), {0.05, kCrease, 2, {}});
  ASSERT_EQ(all.patches.size(), 1u);
  ASSERT_EQ(all.patches[0].loops.size(), 1u);
  EXPECT_TRUE(all.patches[0].loops[0].hole);
}

// Patches of a smooth surface agree at their common border in place, and are near the surface of which the triangles
// are.
TEST(MeshPatches, PatchesOfATubeMeet) {
  const MeshPatches all = patches_of(lattice(40, 20, true, on_short_tube).mesh(), {0.025, kCrease, 2, {}});
  ASSERT_EQ(all.patches.size(), 2u);
  ASSERT_EQ(all.seams.size(), 2u);
  for (const MeshSeam& s : all.seams) {
    EXPECT_FALSE(s.crease);
    for (std::size_t k = 0; k < s.on_first.size(); ++k)
      for (int i = 0; i <= 20; ++i) {
        const Vec3 a = all.patches[s.first].patch.evaluate(s.on_first[k].at(i / 20.0)).x,
                   b = all.patches[s.second].patch.evaluate(s.on_second[k].at(i / 20.0)).x;
        EXPECT_LT((a - b).norm(), 2e-3 * 0.025);
        EXPECT_NEAR(a.head<2>().norm(), 0.2, 2e-3 * 0.025);
      }
  }
}

TEST(MeshPatches, CoarseTrianglesOfASphereAreRound) {
  const MeshPatches all = patches_of(ball(1.0, 4).mesh(), {0.1, kCrease, 2, {}});
  for (const MeshPatch& p : all.patches) {
    EXPECT_LT(p.error, 0.01 * 0.1);
    const Vec2 middle(0.5 * p.patch.knots_u.end(), 0.5 * p.patch.knots_v.end());
    EXPECT_NEAR(p.patch.evaluate(middle + Vec2(0.13, 0.07)).x.norm(), 1.0,
                0.02 * 0.1);  // triangles are 3 elements wide
  }
}

TEST(MeshPatches, AMeshOfTooManyElementsOrTooLongOnesIsRefused) {
  const TriangleMesh m = lattice(10, 10, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh();
  const auto refusal = [&](const TriangleMesh& mesh, double element, double crease = kCrease) -> std::string {
    try {
      patches_of(mesh, {element, crease, 2, {}});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(refusal(m, 1e-4).find("give a longer one"), std::string::npos);
  EXPECT_NE(refusal(m, 0.9).find("give one below 0.707 m"), std::string::npos) << refusal(m, 0.9);
  const TriangleMesh wavy = lattice(60, 60, false, [](double u, double v) {
                              return Vec3(u, v, 0.05 * std::sin(40.0 * u) * std::sin(40.0 * v));
                            }).mesh();
  EXPECT_NE(refusal(wavy, 0.12, 3.0).find("give a shorter one"), std::string::npos) << refusal(wavy, 0.12, 3.0);
  Triangles soup;  // of faces that share no point, as STL files have them where points are rounded
  for (int k = 0; k < 300; ++k) {
    for (const Vec3& x : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}) soup.points.push_back(Vec3(2.0 * k, 0, 0) + x);
    soup.add(3 * k, 3 * k + 1, 3 * k + 2);
  }
  EXPECT_NE(refusal(soup.mesh(), 0.1).find("has 300 parts that share no edge, of 1 triangles"), std::string::npos);
  EXPECT_NE(refusal(soup.mesh(), 0.1).find("weld_m"), std::string::npos);
  // a flat ring whose elements are few, and many in the square around it
  const TriangleMesh hoop = lattice(200, 1, true, [](double u, double v) {
                              const double a = 2.0 * std::numbers::pi * u, r = 1.0 + 0.008 * v;
                              return Vec3(r * std::cos(a), r * std::sin(a), 0.0);
                            }).mesh();
  EXPECT_NE(refusal(hoop, 0.001).find("the rectangles around the charts have more than"), std::string::npos)
      << refusal(hoop, 0.001);
}

}  // namespace
