// Triangles of a surface: welding, turning, components, and what is no surface.
#include "shell/meshes/triangle_mesh.h"

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "tests/shell/triangles.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Triangles square() { return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{{0, 1, 2}, 5}, {{0, 2, 3}, 6}}}; }

std::string refusal(const Triangles& t, double weld = 0.0) {
  try {
    make_triangle_mesh(t.points, t.faces, weld, "line");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(TriangleMesh, EdgesAndLoopsOfATubeAreCounted) {
  const TriangleMesh m = lattice(12, 5, true, [](double u, double v) {
                           return Vec3(std::cos(6.2831853 * u), std::sin(6.2831853 * u), v);
                         }).mesh();
  const MeshEdges e = edges_of(m);
  EXPECT_EQ(m.components, 1);
  EXPECT_EQ(e.border, 24);
  EXPECT_EQ(e.loops, 2);
  EXPECT_EQ(static_cast<int>(m.points.size()) - e.all + static_cast<int>(m.triangles.size()), 0);  // Euler
}

TEST(TriangleMesh, FacesThatAreTurnedOverAreTurnedBack) {
  Triangles t = ball(1.0, 4);
  for (std::size_t k = 0; k < t.faces.size(); k += 3) std::swap(t.faces[k].corners[0], t.faces[k].corners[1]);
  const TriangleMesh m = t.mesh();
  EXPECT_EQ(m.turned, static_cast<int>((t.faces.size() + 2) / 3));
  for (std::size_t k = 0; k < m.triangles.size(); ++k)
    EXPECT_GT(m.normal(static_cast<int>(k)).dot(m.middle(static_cast<int>(k))), 0.0);
}

TEST(TriangleMesh, PointsWithinTheWeldBecomeOne) {
  Triangles t = square();
  t.points.push_back({1e-6, 0, 0}), t.points.push_back({1, 1, 1e-6});
  t.faces[1].corners = {4, 5, 3};
  EXPECT_EQ(make_triangle_mesh(t.points, t.faces, 0.0, "line").components, 2);
  const TriangleMesh m = make_triangle_mesh(t.points, t.faces, 1e-5, "line");
  EXPECT_EQ(m.components, 1);
  EXPECT_EQ(m.welded, 2);
  EXPECT_EQ(m.points.size(), 4u);
}

TEST(TriangleMesh, CreasesAreEdgesThatTurnByMore) {
  Triangles t = square();
  t.points[3] = {0, 0.5, std::sqrt(0.5)};
  const TriangleMesh m = t.mesh();
  const auto count = [&](double angle) {
    int sum = 0;
    for (const auto& edges : creases_of(m, angle))
      for (const char c : edges) sum += c;
    return sum;
  };
  const double turn = std::acos(m.normal(0).dot(m.normal(1)));
  EXPECT_EQ(count(turn - 1e-6), 2);
  EXPECT_EQ(count(turn + 1e-6), 0);
}

TEST(TriangleMesh, AnEdgeOfThreeFacesIsRefusedWithItsPlace) {
  Triangles t = square();
  t.points.push_back({0.5, 0.5, 1}), t.faces.push_back({{0, 2, 4}, 7});
  const std::string text = refusal(t);
  expect_part(text, "has 1 edges of three faces or more, the first of 3 faces, from (0, 0, 0) to (1, 1, 0)");
  expect_part(text, "line 7");
}

TEST(TriangleMesh, AFaceWithoutAreaIsRefusedWithItsLine) {
  Triangles t = square();
  t.points.push_back({2, 1, 0}), t.faces.push_back({{3, 2, 4}, 9});
  expect_part(refusal(t), "line 9: the face at (0, 1, 0) has no area, the first of 1");
}

TEST(TriangleMesh, FacesWithTwoCornersInOnePlaceAreLeftOut) {
  Triangles t = square();
  t.faces.push_back({{0, 2, 2}, 7});
  t.points.push_back(t.points[1]), t.faces.push_back({{1, static_cast<int>(t.points.size()) - 1, 2}, 8});
  const TriangleMesh m = t.mesh();
  EXPECT_EQ(m.triangles.size(), 2u);
  EXPECT_EQ(m.dropped, 2);
  t = square(), t.faces = {{{0, 2, 2}, 7}};
  expect_part(refusal(t), "no face with an area: all 1 have two corners in one place");
}

TEST(TriangleMesh, AFaceThatIsThereTwiceIsRefused) {
  Triangles t = square();
  t.faces.push_back({{2, 1, 0}, 11});  // the first one, turned over
  expect_part(refusal(t), "line 11: the face at");
  expect_part(refusal(t), "has the corners of the one of line 5; leave one of them out");
}

// Two triangles that meet in a corner only, a third beside the second: each sheet has a point of its own there.
TEST(TriangleMesh, ASurfaceThatTouchesItselfInAPointIsPartedThere) {
  const Triangles t{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0.5, -1, 0}},
                    {{{0, 1, 2}, 1}, {{0, 3, 4}, 2}, {{0, 4, 5}, 3}}};
  const TriangleMesh m = t.mesh();
  EXPECT_EQ(m.parted, 1);
  EXPECT_EQ(m.first_parted, m.points[0]);
  EXPECT_EQ(m.components, 2);
  ASSERT_EQ(m.points.size(), 7u);
  EXPECT_EQ(m.points[6], m.points[m.triangles[0][0]]);
  EXPECT_EQ(m.of_file[6], 0);
  EXPECT_NE(m.triangles[0][0], m.triangles[1][0]);
  EXPECT_EQ(m.triangles[1][0], m.triangles[2][0]);
  EXPECT_EQ(edges_of(m).loops, 2);  // a border that goes through a point twice would be lost
  EXPECT_EQ(edges_of(m).border, 7);
}

TEST(TriangleMesh, AStripWithOneSideIsRefused) {
  Triangles t;
  constexpr int kCells = 12;
  for (int i = 0; i < kCells; ++i)
    for (const double s : {-0.3, 0.3}) {
      const double a = 2.0 * M_PI * i / kCells;
      t.points.push_back(
          {(1 + s * std::cos(a / 2)) * std::cos(a), (1 + s * std::cos(a / 2)) * std::sin(a), s * std::sin(a / 2)});
    }
  for (int i = 0; i < kCells; ++i) {
    const bool last = i + 1 == kCells;
    const int a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    t.add(a, c, b), t.add(b, c, d);
  }
  expect_part(refusal(t), "has one side only");
}

TEST(TriangleMesh, PointsWithoutFacesAreRefused) { expect_part(refusal({{{0, 0, 0}}, {}}), "has no faces"); }

}  // namespace
