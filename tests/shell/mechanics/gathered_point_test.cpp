// One gathered point: its functions, forces and stresses, against what a stretched plate has exactly.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shell/mechanics/gathered_point.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kThin = 0.01;  // [m]

// Any point of a flat plate, with the functions of the patch.
GatheredPoint point_of(const ShellModel& m, int block = 5, int lane = 3) {
  const RowTables& t = m.tables;
  GatheredPoint p;
  p.block = block, p.lane = lane, p.kind = PointKind::kQuadratic, p.area = 2e-4;
  p.functions = patch_functions(m.patch, gauss_point(m.patch, t, block, lane).parameter, t.stride);
  p.metric = {{1.0, 1.0, 0.0}, {0.0, 0.0, 0.0}};
  return p;
}

ShellModel gathered_plate(double poisson = 0.22) {
  ShellMaterial material = glass();
  material.poisson_ratio = poisson;
  return make_shell("p", plate(0.5, 0.4, 7, 5, Vec3::Zero(), Quat::Identity()), kThin, material, 2, 2, {});
}

// Positions of the plate after x -> a x.
std::vector<double> mapped(const ShellModel& m, const Mat3& a) {
  std::vector<double> x = m.rest;
  const auto stride = static_cast<std::size_t>(m.tables.component_stride);
  for (std::size_t k = 0; k < stride; ++k) {
    const Vec3 to = a * Vec3(m.rest[k], m.rest[stride + k], m.rest[2 * stride + k]);
    for (int c = 0; c < 3; ++c) x[c * stride + k] = to[c];
  }
  return x;
}

Mat3 stretching(double along_x) { return Vec3(along_x, 1.0, 1.0).asDiagonal(); }

}  // namespace

TEST(GatheredPoint, FunctionsArePartsOfUnity) {
  const ShellModel m = make_shell("p", cubic_patch(), 0.02, glass(), 2, 3, {});
  std::array<double, 6> sum{};
  for (const GatheredFunction& f : patch_functions(m.patch, Vec2(0.37, 0.61), m.tables.stride))
    for (int k = 0; k < 6; ++k) sum[k] += f.n[k];
  EXPECT_NEAR(sum[0], 1.0, 1e-14);
  for (int k = 1; k < 6; ++k) EXPECT_NEAR(sum[k], 0.0, 1e-11);  // terms up to 1e3 cancel
}

TEST(GatheredPoint, TakesAnAffineMapExactly) {
  const ShellModel m = gathered_plate();
  Mat3 a;
  a << 1.1, 0.2, 0.0, -0.3, 0.9, 0.0, 0.4, 0.5, 1.0;
  const Derivatives<double> d = gather(m.tables, point_of(m), mapped(m, a));
  EXPECT_LT((Vec3(d.u.x, d.u.y, d.u.z) - a.col(0)).norm(), 1e-13);
  EXPECT_LT((Vec3(d.v.x, d.v.y, d.v.z) - a.col(1)).norm(), 1e-13);
  for (const Vector<double>& second : {d.uu, d.vv, d.uv})
    EXPECT_LT(Vec3(second.x, second.y, second.z).norm(), 1e-10);  // round-off over a squared spacing
}

TEST(GatheredPoint, ThicknessMultipliesSecondDerivativesAlone) {
  std::vector<GatheredFunction> f{{7, {1, 2, 3, 4, 5, 6}}};
  thicken(f, 0.5);
  EXPECT_EQ(f[0].n, (std::array<double, 6>{1, 2, 3, 2, 2.5, 3}));
}

TEST(GatheredPoint, HasTheStressAndTheStretchOfAStretchedPlate) {
  const double strain = 1e-6, poisson = 0.22, young = 70e9;
  const ShellModel m = gathered_plate(poisson);
  const std::vector<double> x = mapped(m, stretching(1.0 + strain));
  const std::array<double, 6> s = undamaged_stress(m.tables, point_of(m), x);
  const double along = young / (1.0 - poisson * poisson) * strain;
  for (const int face : {0, 3}) {  // large strain changes a share of the order of the strain
    EXPECT_NEAR(s[face], along, 1e-5 * along);
    EXPECT_NEAR(s[face + 1], poisson * along, 1e-5 * along);
    EXPECT_NEAR(s[face + 2], 0.0, 1e-5 * along);
  }
  EXPECT_NEAR(largest_stretch(m.tables, point_of(m), mapped(m, stretching(1.25))), 1.25, 1e-13);
  EXPECT_NEAR(point_energy(m.tables, point_of(m), x), 2e-4 * kThin * 0.5 * along * strain,
              2e-5 * 2e-4 * kThin * 0.5 * along * strain);
}

TEST(GatheredPoint, ForceIsMinusTheGradientOfItsEnergy) {
  const ShellModel m = gathered_plate();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 2e-3);
  const GatheredPoint p = point_of(m);
  const auto force = point_force(m.tables, p, s.motion.x, 1.0);
  ASSERT_TRUE(force);
  std::vector<double> spread_out(s.motion.x.size(), 0.0);
  for (int k = 0; k < 3; ++k) spread(m.tables, p, *force, k, spread_out);
  double scale = 0.0;
  for (const double f : spread_out) scale = std::max(scale, std::abs(f));
  const double epsilon = 1e-7;
  for (const GatheredFunction& f : p.functions)
    for (int c = 0; c < 3; ++c) {
      const std::size_t k = c * static_cast<std::size_t>(m.tables.component_stride) + f.slot;
      std::vector<double> x = s.motion.x;
      x[k] += epsilon;
      const double high = point_energy(m.tables, p, x);
      x[k] -= 2.0 * epsilon;
      const double low = point_energy(m.tables, p, x);
      EXPECT_NEAR(spread_out[k], -(high - low) / (2.0 * epsilon),
                  1e-5 * scale);  // O(epsilon^2), round-off over epsilon
    }
  const auto half = point_force(m.tables, p, s.motion.x, 0.5);
  EXPECT_NEAR(half->u.x, 0.5 * force->u.x, 1e-15 * scale);
}

TEST(GatheredPoint, ALinearPointDoesNotBendAndADeadOneDoesNothing) {
  const ShellModel m = gathered_plate();
  std::vector<double> bent = m.rest;
  const auto stride = static_cast<std::size_t>(m.tables.component_stride);
  for (std::size_t k = 0; k < stride; ++k) bent[2 * stride + k] = 1e-3 * m.rest[k] * m.rest[k];  // curvature 2e-3 1/m
  GatheredPoint p = point_of(m);
  const double whole = point_energy(m.tables, p, bent);
  p.kind = PointKind::kLinear;
  const double membrane = point_energy(m.tables, p, bent);
  EXPECT_GT(whole, 10.0 * membrane);
  const auto force = point_force(m.tables, p, bent, 1.0);
  ASSERT_TRUE(force);
  for (const Vector<double>& second : {force->uu, force->vv, force->uv})
    EXPECT_EQ(Vec3(second.x, second.y, second.z), Vec3::Zero());
  p.kind = PointKind::kDead;
  EXPECT_FALSE(point_force(m.tables, p, bent, 1.0));
  EXPECT_EQ(point_energy(m.tables, p, bent), 0.0);
}

TEST(GatheredPoint, APointAtNoPlaceExertsNoForce) {
  const ShellModel m = gathered_plate();
  std::vector<double> x = mapped(m, stretching(1.0));
  x.assign(x.size(), std::nan(""));
  EXPECT_FALSE(point_force(m.tables, point_of(m), x, 1.0));
}

TEST(GatheredPoint, FacesHaveTheStressOfResultants) {
  SectionFaces section{};
  section.thickness = 0.5, section.squared = 0.25;
  const double n[] = {1.0, 2.0, 3.0}, m[] = {0.5, -0.25, 0.0};
  EXPECT_EQ(linear_stress(n, m, section),
            (std::array<double, 6>{2.0 - 12.0, 4.0 + 6.0, 6.0, 2.0 + 12.0, 4.0 - 6.0, 6.0}));
}

TEST(GatheredPoint, StampsAreNeverTheSame) {
  const GatheredPoint a, b;
  EXPECT_NE(a.stamp, b.stamp);
  EXPECT_NE(fresh_stamp(), fresh_stamp());
}
