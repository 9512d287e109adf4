// Layers through the thickness, and a patch laid out in rows.
#include <cmath>
#include <numeric>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/mechanics/row_tables.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double moment(const Layers& layers, int power) {
  double sum = 0.0;
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) sum += layers.weight[l] * std::pow(layers.zeta[l], power);
  return sum;
}

RowTables tables(const Patch& p, int gauss) {
  return make_row_tables(p, gauss, gauss_layers(2, 0.01), elasticity({70e9, 0.22}), "shell 'p'");
}

}  // namespace

TEST(Layers, OfGaussIntegrateThroughTheThickness) {
  const double t = 0.004;
  for (const int n : {1, 2, 3, 4}) {
    const Layers layers = gauss_layers(n, t);
    EXPECT_EQ(layers.zeta.size(), static_cast<std::size_t>(n));
    for (int power = 0; power < 2 * n; ++power) {
      const double exact = power % 2 == 1 ? 0.0 : 2.0 * std::pow(0.5 * t, power + 1) / (power + 1);
      EXPECT_NEAR(moment(layers, power), exact, 1e-15 * std::pow(0.5 * t, power)) << n << " " << power;
    }
  }
}

TEST(Layers, OfPliesLeaveOutTheCore) {
  const double t = 0.01, core = 0.002;
  const Layers layers = plies(2, t, core);
  ASSERT_EQ(layers.zeta.size(), 4u);
  EXPECT_NEAR(moment(layers, 0), t - core, 1e-16);
  EXPECT_NEAR(moment(layers, 2), (std::pow(t, 3) - std::pow(core, 3)) / 12.0, 1e-20);  // two points a ply are exact
  for (const double z : layers.zeta) EXPECT_GT(std::abs(z), 0.5 * core);
}

TEST(Layers, OfLinearBendingAreTheMiddleAndTheSecondMoment) {
  const Layers layers = linear_bending(0.004);
  ASSERT_EQ(layers.zeta.size(), 1u);
  EXPECT_EQ(layers.zeta[0], 0.0);
  EXPECT_EQ(layers.weight[0], 0.004);
  EXPECT_NEAR(layers.bending, std::pow(0.004, 3) / 12.0, 1e-24);
}

TEST(Layers, FacesOfALaminateHaveItsSectionModulus) {
  for (const double core : {0.38e-3, 1.52e-3, 6e-3}) {
    const double ply = 4e-3, whole = 2.0 * ply + core;
    const SectionFaces faces = section_faces(plies(2, whole, core));
    EXPECT_NEAR(faces.half, 0.5 * whole, 1e-12 * whole);
    EXPECT_NEAR(faces.thickness, 2.0 * ply, 1e-12 * ply);
    const double modulus = (std::pow(whole, 3) - std::pow(core, 3)) / (6.0 * whole);
    EXPECT_NEAR(faces.squared, 6.0 * modulus, 1e-12 * modulus);
  }
}

TEST(Layers, FacesOfASolidSectionHaveTheSquareOfItsThicknessToTheLastBit) {
  for (const int n : {1, 2, 3, 4, 5})
    for (const double t : {0.004, 0.0071, 1.0 / 3.0}) {
      const Layers layers = gauss_layers(n, t);
      const double thickness = thickness_of(layers);
      EXPECT_EQ(section_faces(layers).thickness, thickness);
      EXPECT_EQ(section_faces(layers).squared, thickness * thickness);
      EXPECT_EQ(section_faces(layers).half, 0.5 * thickness);
    }
  EXPECT_EQ(section_faces(linear_bending(0.004)).squared, 0.004 * 0.004);
}

TEST(RowTables, AreasSumToTheSurfaceAndSlotsAreTheirOwn) {
  const Patch p = with_parameters_as_lengths(cylinder(0.3, 0.5, 1.2, 11, 5));
  const RowTables t = tables(p, 3);
  double area = 0.0, parameter_area = 0.0;
  int points = 0;
  for (int q = 0; q < t.blocks(); ++q)
    for (int lane = 0; lane < t.lanes; ++lane) {
      const double a = t.metric[t.at(q, kMetricFields, kArea, lane)];
      area += a, points += a > 0.0;
      if (lane < t.spans_u) {
        parameter_area += gauss_point(p, t, q, lane).weight;
      } else {
        EXPECT_EQ(a, 0.0) << "padding";
      }
    }
  EXPECT_EQ(points, t.gauss_points());
  EXPECT_NEAR(area, 0.3 * 1.2 * 0.5, 1e-8);  // the arc by three points an element
  EXPECT_NEAR(parameter_area, p.knots_u.end() * p.knots_v.end(), 1e-12);
  std::set<int> slots;
  for (int i = 0; i < t.columns * t.rows; ++i) {
    slots.insert(t.slot(i));
    EXPECT_EQ(t.control_point(t.slot(i)), i);
  }
  EXPECT_EQ(slots.size(), static_cast<std::size_t>(t.columns) * t.rows);
  EXPECT_LT(*slots.rbegin(), t.component_stride);
}

TEST(RowTables, RefuseASurfaceWithoutArea) {
  Patch p = plate(1, 1, 4, 4, Vec3::Zero(), Quat::Identity());
  for (Vec3& x : p.control_points) x = Vec3(x.x(), x.x(), 0.0);
  try {
    tables(p, 2);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("shell 'p'"), std::string::npos) << e.what();
  }
}
