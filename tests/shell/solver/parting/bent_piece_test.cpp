// A piece of a curved shell keeps its curvature as a body: in its convex parts and as it is drawn.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/constants.h"
#include "shell/geometry/builders.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/prisms.h"

using namespace sunder;
using namespace sunder::shell;
using sunder::test::volume_of_prisms;

namespace {

constexpr double kThickness = 0.002;

// A dish z = (x^2 + y^2) / (2 radius) over 0.2 m by 0.2 m, with its lowest point in the middle. A square of 0.1 m is
// cut out of its middle and leaves.
Handoff middle_of_a_dish(double radius) {
  Patch dish = plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity());
  // Coefficients of x^2 by its polar form: the product of the two knots inside a function's support.
  const auto squared = [](const KnotVector& knots, int i) {
    const double middle = 0.5 * (knots.begin() + knots.end());
    return (knots.knots()[i + 1] - middle) * (knots.knots()[i + 2] - middle);
  };
  for (int j = 0; j < dish.rows(); ++j)
    for (int i = 0; i < dish.columns(); ++i)
      dish.control_points[j * dish.columns() + i].z() =
          (squared(dish.knots_u, i) + squared(dish.knots_v, j)) / (2.0 * radius);
  const ShellModel m = make_shell("dish", dish, kThickness, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const double low = 0.25 * m.patch.knots_u.end(), up = 3.0 * low;  // parameters are lengths of arc, on average
  insert_polyline(m, s, {{low, low}, {up, low}, {up, up}, {low, up}, {low, low}}, 0.0);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  const Piece& piece = pieces[0].area < pieces[1].area ? pieces[0] : pieces[1];
  return hand_off(m, s, t, piece, 7, 0.0);
}

// A cylinder of radius 0.05 m along y over `angle` [rad], `length` long, in elements of some 10 mm. A strip of it, from
// `from` to `to` [m] along y, leaves.
Handoff strip_of_a_tube(double angle, double length, double from, double to) {
  const double radius = 0.05;
  const int around = static_cast<int>(std::lround(radius * angle / 0.01)), along = static_cast<int>(length / 0.01);
  const ShellModel m =
      make_shell("tube", cylinder(radius, length, angle, around, along), kThickness, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const double first = m.patch.knots_u.begin(), last = m.patch.knots_u.end();
  for (const double v : {from, to}) insert_polyline(m, s, {{first, v}, {last, v}}, 0.0);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  const auto least = [](const Piece& a, const Piece& b) { return a.area < b.area; };
  return hand_off(m, s, t, *std::min_element(pieces.begin(), pieces.end(), least), 7, 0.0);
}

Vec3 in_world(const Handoff& h, const Vec3& x) { return h.body.motion.position + h.body.motion.orientation * x; }

// Volume inside the drawn mesh, which is closed [m^3].
double volume_of(const DrawnMesh& mesh) {
  double six = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) six += mesh.points[a].dot(mesh.points[b].cross(mesh.points[c]));
  return six / 6.0;
}

// Area of the dish over the square of 0.1 m, by the midpoint rule [m^2].
double area_of_dish(double radius) {
  const int n = 200;
  double area = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = 0.1 * ((i + 0.5) / n - 0.5), y = 0.1 * ((j + 0.5) / n - 0.5);
      area += 0.01 / (n * n) * std::sqrt(1.0 + (x * x + y * y) / (radius * radius));
    }
  return area;
}

}  // namespace

TEST(BentPiece, IsMadeOfFlatPartsThatFollowTheSurface) {
  const double radius = 0.08;  // 31 mm deep under its corners, 16 times the thickness
  const Handoff h = middle_of_a_dish(radius);
  const ConvexShape& shape = std::get<ConvexShape>(h.body.shape);
  EXPECT_NEAR(h.area, area_of_dish(radius), 0.005 * area_of_dish(radius));
  EXPECT_GE(shape.parts.size(), 16u);
  EXPECT_LE(shape.parts.size(), 200u);
  EXPECT_NEAR(volume_of_prisms(shape), kThickness * area_of_dish(radius), 0.03 * kThickness * area_of_dish(radius));
  for (const auto& part : shape.parts) {
    Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
    for (std::size_t k = 0; k + 1 < part.size(); k += 2) {
      normal += (part[k + 1] - part[k]).normalized();
      middle += (part[k] + part[k + 1]) / static_cast<double>(part.size());
      const Vec3 x = in_world(h, 0.5 * (part[k] + part[k + 1]));
      EXPECT_NEAR(x.z(), x.head<2>().squaredNorm() / (2.0 * radius), 0.1 * kThickness);
    }
    for (std::size_t k = 0; k + 1 < part.size(); k += 2)
      EXPECT_LE(std::abs(normal.normalized().dot(0.5 * (part[k] + part[k + 1]) - middle)), kBentPiece * kThickness);
  }
}

// Nothing of a narrow strip lies between its borders: they alone tell that it is bent.
TEST(BentPiece, ANarrowStripFollowsTheArc) {
  for (const double angle : {0.5 * std::numbers::pi, 0.75 * std::numbers::pi}) {
    const Handoff h = strip_of_a_tube(angle, 0.1, 0.05, 0.053);
    const ConvexShape& shape = std::get<ConvexShape>(h.body.shape);
    const double area = 0.05 * angle * 0.003;
    EXPECT_NEAR(h.area, area, 0.02 * area);
    EXPECT_NEAR(volume_of_prisms(shape), kThickness * area, 0.05 * kThickness * area) << angle;
    EXPECT_LE(shape.parts.size(), 64u);
    for (const auto& part : shape.parts) {
      Vec3 low = in_world(h, part[0]), high = low;
      for (const Vec3& x : part) low = low.cwiseMin(in_world(h, x)), high = high.cwiseMax(in_world(h, x));
      EXPECT_LT((high - low).norm(), 0.03);  // a chord of 28 mm is off the arc by the thickness
    }
  }
}

TEST(BentPiece, IsDrawnWithItsCurvature) {
  const double radius = 0.08;
  const Handoff h = middle_of_a_dish(radius);
  EXPECT_NEAR(volume_of(h.drawn), kThickness * area_of_dish(radius), 0.01 * kThickness * area_of_dish(radius));
  double lowest = 1.0;
  for (const Vec3& x : h.drawn.points) lowest = std::min(lowest, in_world(h, x).z());
  EXPECT_NEAR(lowest, -0.5 * kThickness, 0.1 * kThickness);  // its middle, which an outline alone leaves out
}

// Pictures and exports take the centre of mass from what is drawn: that of its middle surface.
TEST(BentPiece, IsDrawnAboutItsCentreOfMass) {
  for (const double radius : {0.08, 1.0, 10.0, 1e6}) {
    const DrawnMesh drawn = middle_of_a_dish(radius).drawn;
    Vec3 first = Vec3::Zero();
    double area = 0.0;
    for (const auto& c : drawn.triangles) {
      if (c[0] % 2 == 0 || c[1] % 2 == 0 || c[2] % 2 == 0) continue;  // outside only
      Vec3 x[3];
      for (int k = 0; k < 3; ++k) x[k] = 0.5 * (drawn.points[c[k] - 1] + drawn.points[c[k]]);
      const double own = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
      area += own, first += own / 3.0 * (x[0] + x[1] + x[2]);
    }
    EXPECT_LT((first / area).norm(), 1e-7) << radius;
  }
}

// What is nearly flat costs no more than what is flat.
TEST(BentPiece, NearlyFlatIsOnePart) {
  for (const double radius : {10.0, 1e6}) {  // 0.25 mm deep, and 2.5 nm
    const Handoff h = middle_of_a_dish(radius);
    EXPECT_LE(std::get<ConvexShape>(h.body.shape).parts.size(), 2u) << radius;
    EXPECT_NEAR(volume_of(h.drawn), kThickness * 0.01, 1e-3 * kThickness * 0.01) << radius;
  }
  // The outline's points draw what is flat; what is curved a little, if only for a picture, has inner ones too.
  EXPECT_GT(middle_of_a_dish(10.0).drawn.points.size(), middle_of_a_dish(1e6).drawn.points.size() + 100);
}
