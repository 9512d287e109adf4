// A shell as a solid: closed, with the volume of the sheet, and faces that move as the sheet does.
#include "shell/io/thick_sheet.h"

#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>

using namespace sunder;
using namespace sunder::shell;

namespace {

// Points of both arrays, and triangles; `where` keeps some squares of n by n, `place` puts a parameter in space.
VtpMesh surface(int n, const std::function<Vec3(double u, double v)>& place,
                const std::function<bool(int i, int j)>& where = nullptr) {
  VtpMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.points.push_back(place(double(i) / n, double(j) / n));
  VtpArray damage{"damage", 1, {}}, stress{"stress", 6, {}};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (where && !where(i, j)) continue;
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      for (const auto& corners : {std::vector<int>{a, b, c}, std::vector<int>{a, c, d}}) {
        damage.values.push_back(static_cast<double>(mesh.polygons.size()));
        for (int k = 0; k < 6; ++k) stress.values.push_back(10.0 * static_cast<double>(mesh.polygons.size()) + k);
        mesh.polygons.push_back(corners);
      }
    }
  const std::vector<double> zero(3 * mesh.points.size(), 0.0);
  mesh.point_data = {{"velocity", 3, zero}, {"displacement", 3, zero}, {"uv", 2, {}}};
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    mesh.point_data[2].values.insert(mesh.point_data[2].values.end(), {0.1 * static_cast<double>(i), -1.0});
  mesh.cell_data = {damage, stress};
  return mesh;
}

std::vector<double> all(const VtpMesh& mesh, double thickness) {
  return std::vector<double>(mesh.polygons.size(), thickness);
}

double volume_of(const VtpMesh& mesh) {
  double sum = 0.0;
  for (const auto& c : mesh.polygons) sum += mesh.points[c[0]].dot(mesh.points[c[1]].cross(mesh.points[c[2]])) / 6.0;
  return sum;
}

double area_of(const VtpMesh& mesh) {
  double sum = 0.0;
  for (const auto& c : mesh.polygons)
    sum += 0.5 * (mesh.points[c[1]] - mesh.points[c[0]]).cross(mesh.points[c[2]] - mesh.points[c[0]]).norm();
  return sum;
}

// Each edge belongs to two triangles, which run along it in opposite directions.
void expect_closed(const VtpMesh& mesh) {
  std::map<std::pair<int, int>, int> runs;
  for (const auto& c : mesh.polygons)
    for (int k = 0; k < 3; ++k) ++runs[{c[k], c[(k + 1) % 3]}];
  for (const auto& [edge, count] : runs) {
    EXPECT_EQ(count, 1) << edge.first << " " << edge.second;
    EXPECT_EQ(runs.count({edge.second, edge.first}), 1u) << edge.first << " " << edge.second;
  }
}

Vec3 at(const VtpArray& a, std::size_t i) { return {a.values[3 * i], a.values[3 * i + 1], a.values[3 * i + 2]}; }

}  // namespace

TEST(ThickSheet, OfAPlateIsABox) {
  const VtpMesh plate = surface(4, [](double u, double v) { return Vec3(2.0 * u, v, 0.3); });
  const VtpMesh box = thick_sheet(plate, all(plate, 0.1), all(plate, 0.1));
  expect_closed(box);
  EXPECT_NEAR(volume_of(box), 0.2, 1e-14);
  EXPECT_NEAR(area_of(box), 2 * 2.0 + 0.1 * 6.0, 1e-13);
  const VtpArray& kind = box.cell_data.back();
  ASSERT_EQ(kind.name, "face_kind");
  int count[3] = {0, 0, 0};
  for (std::size_t i = 0; i < box.polygons.size(); ++i) {
    const auto& c = box.polygons[i];
    const Vec3 n = (box.points[c[1]] - box.points[c[0]]).cross(box.points[c[2]] - box.points[c[0]]).normalized();
    const int wanted = n.z() > 0.5 ? kFaceOutside : n.z() < -0.5 ? kFaceInside : kFaceEdge;
    EXPECT_EQ(kind.values[i], wanted);
    ++count[wanted];
  }
  EXPECT_EQ(count[0], 32);
  EXPECT_EQ(count[1], 32);
  EXPECT_EQ(count[2], 2 * 16);
}

TEST(ThickSheet, CellsHaveTheValuesOfTheirTriangle) {
  const VtpMesh plate = surface(3, [](double u, double v) { return Vec3(u, v, 0.0); });
  const VtpMesh box = thick_sheet(plate, all(plate, 0.1), all(plate, 0.1));
  ASSERT_EQ(box.cell_data.size(), 3u);
  for (std::size_t i = 0; i < box.polygons.size(); ++i) {
    const auto own = static_cast<std::size_t>(box.cell_data[0].values[i]);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(box.cell_data[1].values[6 * i + k], 10.0 * own + k);
    for (const int corner : box.polygons[i]) {  // it stands over, under or at the border of that triangle
      const Vec3& x = box.points[corner];
      double nearest = 1e300;
      for (const int p : plate.polygons[own]) nearest = std::min(nearest, (plate.points[p] - x).norm());
      EXPECT_NEAR(nearest, 0.05, 1e-15);
    }
  }
  EXPECT_EQ(box.point_data[2].values.size(), 2 * box.points.size());
}

// Volume between two faces of a sphere's cap: area (h + h^3 / 12 R^2). Flat triangles miss a share (spacing / R)^2.
TEST(ThickSheet, OfACapHasTheVolumeOfAreaAndThickness) {
  static constexpr double kRadius = 1.0, kThickness = 0.05;
  for (const int n : {8, 16}) {
    const VtpMesh cap =
        surface(n, [](double u, double v) { return Vec3(kRadius * Vec3(u - 0.5, v - 0.5, 1.0).normalized()); });
    const VtpMesh solid = thick_sheet(cap, all(cap, kThickness), all(cap, kThickness));
    expect_closed(solid);
    EXPECT_NEAR(volume_of(solid) / (area_of(cap) * kThickness), 1.0, 0.5 / (n * n)) << n;
  }
}

// A square is missing in the middle, and two squares meet in a point: there are four edges through the thickness at it,
// not one with four faces.
TEST(ThickSheet, PartsThatMeetInAPointAreClosed) {
  const VtpMesh mesh = surface(
      4, [](double u, double v) { return Vec3(u, v, 0.1 * u * v); },
      [](int i, int j) { return !(i == 1 && j == 1) && !(i == 2 && j == 2); });
  const VtpMesh solid = thick_sheet(mesh, all(mesh, 0.02), all(mesh, 0.02));
  expect_closed(solid);
  EXPECT_NEAR(volume_of(solid) / (area_of(mesh) * 0.02), 1.0, 1e-3);
  EXPECT_EQ(solid.points.size(), 2 * (25u + 1u));
}

// A crack is a line of points that stand twice: both of its faces have an edge, and the solid is open there.
TEST(ThickSheet, CracksAreOpen) {
  VtpMesh mesh = surface(4, [](double u, double v) { return Vec3(u, v, 0.0); });
  const std::size_t before = mesh.points.size();
  std::map<int, int> twin;  // of points at the middle that are not on the far border: the crack ends there
  for (int j = 0; j < 4; ++j) {
    const int p = 5 * j + 2;
    twin[p] = static_cast<int>(mesh.points.size());
    mesh.points.push_back(mesh.points[p]);
    for (VtpArray& a : mesh.point_data)
      for (int k = 0; k < a.components; ++k) a.values.push_back(a.values[a.components * p + k]);
  }
  for (std::size_t i = 0; i < mesh.polygons.size(); ++i)
    if (i % 8 >= 4)
      for (int& p : mesh.polygons[i])
        if (twin.count(p)) p = twin[p];
  ASSERT_EQ(mesh.points.size(), before + 4);
  const VtpMesh solid = thick_sheet(mesh, all(mesh, 0.1), all(mesh, 0.1));
  expect_closed(solid);
  EXPECT_NEAR(volume_of(solid), 0.1, 1e-14);
  double edges = 0.0;
  for (std::size_t i = 0; i < solid.polygons.size(); ++i)
    if (static_cast<int>(solid.cell_data.back().values[i]) == kFaceEdge) {
      VtpMesh one;
      one.points = solid.points, one.polygons = {solid.polygons[i]};
      edges += area_of(one);
    }
  EXPECT_NEAR(edges, 0.1 * (4.0 + 2 * 1.0), 1e-13);  // the border, and both faces of a crack across the plate
}

TEST(ThickSheet, FacesTurnWithTheSheet) {
  VtpMesh mesh = surface(6, [](double u, double v) { return Vec3(u, v, 0.2 * u * u - 0.1 * v); });
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Vec3 spin(3.0, -1.0, 2.0), way(0.1, 0.2, 0.3);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3 rest = mesh.points[i], x = turn * rest + way, v = spin.cross(x);
    mesh.points[i] = x;
    for (int d = 0; d < 3; ++d)
      mesh.point_data[0].values[3 * i + d] = v[d], mesh.point_data[1].values[3 * i + d] = x[d] - rest[d];
  }
  const VtpMesh solid = thick_sheet(mesh, all(mesh, 0.08), all(mesh, 0.08));
  for (std::size_t i = 0; i < solid.points.size(); ++i) {
    const Vec3& x = solid.points[i];
    EXPECT_LT((at(solid.point_data[0], i) - spin.cross(x)).norm(), 1e-13);
    const Vec3 rest = turn.transpose() * (x - way);
    EXPECT_LT((x - at(solid.point_data[1], i) - rest).norm(), 1e-14);
  }
}

// Half as thick as at rest on one side: each point takes the mean of its triangles by area.
TEST(ThickSheet, HasThePresentThickness) {
  const VtpMesh plate = surface(8, [](double u, double v) { return Vec3(u, v, 0.0); });
  std::vector<double> thickness;
  for (std::size_t i = 0; i < plate.polygons.size(); ++i) thickness.push_back(i % 16 < 8 ? 0.1 : 0.05);
  const VtpMesh solid = thick_sheet(plate, thickness, all(plate, 0.1));
  expect_closed(solid);
  EXPECT_NEAR(volume_of(solid), 0.5 * (0.1 + 0.05), 1e-3);
  double most = 0.0, least = 1.0;
  for (const Vec3& x : solid.points) most = std::max(most, std::abs(x.z())), least = std::min(least, std::abs(x.z()));
  EXPECT_NEAR(most, 0.05, 1e-15);
  EXPECT_NEAR(least, 0.025, 1e-15);
}
