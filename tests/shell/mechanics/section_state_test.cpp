// Stress, strain and resultants for output, against plates whose state is known.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/mechanics/section_state.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPlateThickness = 0.004, kSmall = 1e-6;

struct Plate {
  ShellModel m =
      make_shell("p", plate(0.2, 0.1, 8, 6, Vec3::Zero(), Quat::Identity()), kPlateThickness, glass(), 4, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);

  GatheredPoint middle() const {
    GatheredPoint p;
    p.kind = PointKind::kQuadratic, p.area = 1.0;
    p.functions = patch_functions(m.patch, Vec2(0.11, 0.04), m.tables.stride);
    const Forms<double> rest = surface_forms(gather(m.tables, p, m.rest));
    p.metric = {rest.a, rest.b};
    return p;
  }
  template <class F>
  void place(F&& at) {
    const std::size_t stride = s.motion.x.size() / 3;
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const Vec3 x = at(s.at(m.rest, slot));
      for (int d = 0; d < 3; ++d) s.motion.x[d * stride + slot] = x[d];
    }
  }
  SectionState state() const {
    const auto found = section_state(m.tables, middle(), s.motion.x, kPlateThickness);
    EXPECT_TRUE(found.has_value());
    return found.value_or(SectionState{});
  }
};

}  // namespace

TEST(SectionState, OfAStretchedSheetIsHookesInAnyPose) {
  Plate p;
  const Quat turn(Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()));
  p.place([&](const Vec3& x) { return Vec3(turn * Vec3((1.0 + kSmall) * x.x(), x.y(), x.z()) + Vec3(3, -2, 1)); });
  const SectionState s = p.state();
  const double e = p.m.material.youngs_modulus, nu = p.m.material.poisson_ratio, stress = e / (1.0 - nu * nu) * kSmall;
  for (int k = 0; k < kSectionPlaces; ++k) {
    EXPECT_NEAR(s.stress[k].c11 / stress, 1.0, 1e-5);
    EXPECT_NEAR(s.stress[k].c22 / stress, nu, 1e-5);
    EXPECT_NEAR(s.stress[k].c12 / stress, 0.0, 1e-6);
    EXPECT_NEAR(s.strain[k].c11 / kSmall, 1.0, 1e-5);
    EXPECT_EQ(s.plastic[k], 0.0);
  }
  EXPECT_NEAR(s.force.c11 / (stress * kPlateThickness), 1.0, 1e-5);
  EXPECT_NEAR(s.moment.c11 / (stress * kPlateThickness * kPlateThickness), 0.0, 1e-6);
  EXPECT_NEAR((s.normal - turn * Vec3::UnitZ()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((s.first - turn * Vec3::UnitX()).norm(), 0.0, 1e-5);
  EXPECT_NEAR(s.thickness / kPlateThickness, 1.0 - nu / (1.0 - nu) * kSmall, 1e-8);
}

TEST(SectionState, OfABentSheetHasItsMomentAndItsOutsideInTension) {
  Plate p;
  const double curvature = 1e-3;  // [1/m], about the y axis: a dome
  p.place([&](const Vec3& x) { return Vec3(x.x(), x.y(), -0.5 * curvature * x.x() * x.x()); });
  const SectionState s = p.state();
  const double e = p.m.material.youngs_modulus, nu = p.m.material.poisson_ratio;
  const double rigidity = e * kPlateThickness * kPlateThickness * kPlateThickness / (12.0 * (1.0 - nu * nu));
  EXPECT_NEAR(s.moment.c11 / (rigidity * curvature), 1.0, 1e-3);  // upwards is outside, and bends into tension
  EXPECT_NEAR(s.moment.c22 / (rigidity * curvature), nu, 1e-3);
  const double face = e / (1.0 - nu * nu) * curvature * 0.5 * kPlateThickness;
  EXPECT_NEAR(s.stress[kOutside].c11 / face, 1.0, 2e-3);
  EXPECT_NEAR(s.stress[kInside].c11 / face, -1.0, 2e-3);
  EXPECT_NEAR(s.stress[kMiddle].c11 / face, 0.0, 2e-3);
}

TEST(SectionState, OfASheetThatIsFlattenedToNothingIsNone) {
  Plate p;
  p.place([](const Vec3& x) { return Vec3(0.1 * x.x(), 0.1 * x.y(), 0.0); });
  EXPECT_FALSE(section_state(p.m.tables, p.middle(), p.s.motion.x, kPlateThickness).has_value());
}
