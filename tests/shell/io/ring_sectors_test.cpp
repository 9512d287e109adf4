// Rings of a scene: their sectors, deflection and modes against exact plates.
#include "shell/io/ring_sectors.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/io/build_seams.h"
#include "shell/io/probes.h"
#include "shell/run/simulation.h"
#include "shell/solver/statics/modes.h"
#include "tests/coupler/small_scene.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kYoung = 7e10, kPoisson = 0.3, kDensity = 2500.0, kThickness = 0.002;
const double kStiffness = kYoung * std::pow(kThickness, 3) / (12.0 * (1.0 - kPoisson * kPoisson));

std::string ring(const std::string& annulus, const std::string& more) {
  return "gravity {}\nmaterials { name: \"m\" density: 2500 youngs_modulus: 7e10 poisson_ratio: 0.3 }\n"
         "shells { name: \"ring\" material: \"m\" thickness_m: 0.002\nannulus { " +
         annulus + " }\n" + more + " equilibrium {} }\n";
}

RunSetup setup_of_text(const std::string& text) {
  const std::string path = small_scene::own_file("ring_sectors_test.textproto");
  std::ofstream(path) << text;
  RunSetup setup = build(scene::load(path, {}));
  std::remove(path.c_str());
  return setup;
}

/// A scene in which nothing moves, in its first equilibrium.
struct Still {
  explicit Still(const std::string& text) : setup(setup_of_text(text)), simulation(setup, 1) {
    simulation.prepare();
    simulation.make_states();
    simulation.find_equilibria(0, [] {});
  }
  JoinedShells joined() {
    JoinedShells out;
    for (ShellPart& part : simulation.state.shells)
      out.numbers.push_back(static_cast<int>(out.shells.size())),
          out.shells.push_back({&part.model(), part.state.get()}), out.gravity.push_back(Vec3::Zero());
    out.stitching = &simulation.state.stitching;
    return out;
  }
  RunSetup setup;
  Simulation simulation;
};

// w = q r^4 / (64 D) + c0 + c1 ln r + c2 r^2 + c3 r^2 ln r; clamped at `inner`, free at `outer`. Returns w at `outer`.
double rim_deflection(double inner, double outer, double load) {
  const auto row = [](double r, int derivative) {
    const double l = std::log(r);
    const Eigen::RowVector4d rows[] = {{1, l, r * r, r * r * l},
                                       {0, 1 / r, 2 * r, r * (2 * l + 1)},
                                       {0, -1 / (r * r), 2, 2 * l + 3},
                                       {0, 2 / (r * r * r), 0, 2 / r}};
    return rows[derivative];
  };
  const double q = load / (64.0 * kStiffness), b = outer;
  Eigen::Matrix4d m;
  Eigen::Vector4d right;
  m.row(0) = row(inner, 0), right[0] = -q * std::pow(inner, 4);
  m.row(1) = row(inner, 1), right[1] = -4 * q * std::pow(inner, 3);
  m.row(2) = row(b, 2) + kPoisson / b * row(b, 1), right[2] = -q * b * b * (12 + 4 * kPoisson);
  m.row(3) = row(b, 3) + row(b, 2) / b - row(b, 1) / (b * b), right[3] = -q * b * (24 + 12 - 4);
  const Eigen::Vector4d c = m.fullPivLu().solve(right);
  return q * std::pow(b, 4) + row(b, 0).dot(c);
}

double mass_of(const RunSetup& setup) {
  double sum = 0.0;
  for (const ShellSetup& s : setup.shells)
    for (const double m : s.model.mass) sum += m;
  return sum;
}

}  // namespace

TEST(RingSectors, OfAWholeRingAreFourAndMeet) {
  const RunSetup r = setup_of_text(ring("inner_m: 0.1 outer_m: 0.3 element_m: 0.05", ""));
  ASSERT_EQ(r.shells.size(), 4u);
  EXPECT_EQ(r.shells[3].model.name, "ring.4");
  EXPECT_EQ(r.stitches.seams.size(), 4u);
  for (const Seam& s : r.stitches.seams) EXPECT_TRUE(s.smooth);
  EXPECT_EQ(joined_groups(r).size(), 1u);
  const double exact = kDensity * kThickness * kPi * (0.09 - 0.01);
  EXPECT_NEAR(mass_of(r), exact, 1e-6 * exact);  // Gauss points on a rational surface
  for (const ShellSetup& s : r.shells) {
    const SurfacePoint p = s.model.patch.evaluate({0.1, 0.05});
    EXPECT_GT(p.u.cross(p.v).normalized().z(), 0.999);
    EXPECT_NEAR(p.x.z(), 0.0, 1e-15);
  }
}

TEST(RingSectors, ASlitRingAndAPartHaveEnds) {
  const RunSetup slit = setup_of_text(ring("inner_m: 6 outer_m: 10 element_m: 2 slit: true",
                                           "supports { edges: U_MAX kind: CLAMPED } supports { edges: ALL kind: "
                                           "SIMPLY_SUPPORTED axes: Z }"));
  EXPECT_EQ(slit.shells.size(), 4u);
  EXPECT_EQ(slit.stitches.seams.size(), 3u);
  const auto clamped = [&](int k) { return slit.shells[k].model.constraints.held[0].size(); };
  EXPECT_EQ(clamped(0), 0u);
  EXPECT_GT(clamped(3), 0u);
  const RunSetup part = setup_of_text(ring("inner_m: 0.1 outer_m: 0.2 element_m: 0.05 angle_deg: 120", ""));
  EXPECT_EQ(part.shells.size(), 2u);
  EXPECT_EQ(part.stitches.seams.size(), 1u);
  EXPECT_NEAR(mass_of(part), kDensity * kThickness * kPi * 0.03 / 3.0, 1e-6 * kDensity * kThickness);
}

namespace {

std::string tube(const std::string& patch, const std::string& more = "") {
  return "gravity {}\nmaterials { name: \"m\" density: 2500 youngs_modulus: 7e10 poisson_ratio: 0.3 }\n"
         "shells { name: \"tube\" material: \"m\" thickness_m: 0.002\n" +
         patch + "\n" + more + " equilibrium {} }\n";
}

}  // namespace

TEST(RingSectors, AWholeCylinderAndAWholeConeClose) {
  const RunSetup whole =
      setup_of_text(tube("cylinder { radius_m: 0.1 length_m: 0.4 angle_deg: 360 elements_u: 30 elements_v: 8 }"));
  ASSERT_EQ(whole.shells.size(), 4u);
  EXPECT_EQ(whole.shells[0].model.name, "tube.1");
  EXPECT_EQ(whole.shells[0].model.patch.columns(), 8 + 2);  // a quarter of 30, rounded up
  EXPECT_EQ(whole.stitches.seams.size(), 4u);
  for (const Seam& s : whole.stitches.seams) EXPECT_TRUE(s.smooth);
  const double exact = kDensity * kThickness * 2.0 * kPi * 0.1 * 0.4;
  EXPECT_NEAR(mass_of(whole), exact, 1e-6 * exact);
  const RunSetup cone = setup_of_text(
      tube("cone { bottom_m: 0.1 top_m: 0.06 height_m: 0.03 angle_deg: 360 elements_u: 32 elements_v: 4 }"));
  EXPECT_EQ(cone.stitches.seams.size(), 4u);
  EXPECT_NEAR(mass_of(cone), kDensity * kThickness * kPi * 0.16 * 0.05, 1e-6 * exact);
}

// As before: the middle of the arc is over the x axis, and its ends are edges.
TEST(RingSectors, AWideArcIsWhereANarrowOneIs) {
  const auto ends = [](const std::string& angle) {
    const RunSetup r = setup_of_text(
        tube("cylinder { radius_m: 0.1 length_m: 0.4 angle_deg: " + angle + " elements_u: 12 elements_v: 4 }",
             "supports { edges: U_MIN kind: CLAMPED }"));
    EXPECT_FALSE(r.shells.front().model.constraints.held[0].empty()) << angle;
    const Patch &first = r.shells.front().model.patch, &last = r.shells.back().model.patch;
    return std::pair(first.evaluate({0.0, 0.0}).x, last.evaluate({last.knots_u.end(), 0.0}).x);
  };
  for (const double angle : {149.0, 150.0, 200.0, 300.0}) {
    const auto [from, to] = ends(std::to_string(angle));
    const double half = 0.5 * angle * kPi / 180.0;
    EXPECT_NEAR((from - 0.1 * Vec3(std::cos(half), -std::sin(half), 0.0)).norm(), 0.0, 1e-12) << angle;
    EXPECT_NEAR((to - 0.1 * Vec3(std::cos(half), std::sin(half), 0.0)).norm(), 0.0, 1e-12) << angle;
  }
}

// Far from its clamped end, by many boundary layers of sqrt(R t), a tube widens by p R^2 / (E t).
TEST(RingSectors, ATubeWidensUnderPressureAlikeAllAround) {
  Still still(tube("cylinder { radius_m: 0.1 length_m: 0.4 angle_deg: 360 elements_u: 32 elements_v: 24 degree: 3 }",
                   "supports { edges: V_MIN kind: CLAMPED }\nloads { pressure: 1e5 }"));
  const double exact = 1e5 * 0.1 * 0.1 / (kYoung * kThickness);
  for (const ShellPart& part : still.simulation.state.shells)
    for (const double share : {0.0, 0.4, 1.0}) {
      const ShellModel& m = part.model();
      const Vec2 at(share * m.patch.knots_u.end(), 0.5 * m.patch.knots_v.end());
      const Vec3 out = Vec3(1, 1, 0).cwiseProduct(m.patch.evaluate(at).x).normalized();
      EXPECT_NEAR(displacement(m, *part.state, at).dot(out), exact, 5e-3 * exact) << m.name << " " << share;
    }
}

TEST(RingSectors, ARingClampedAtItsInnerRimSagsAsAPlate) {
  Still still(ring("inner_m: 0.1 outer_m: 0.3 element_m: 0.03 degree: 3",
                   "supports { edges: INNER kind: CLAMPED }\nloads { pressure: -10 }"));
  const double exact = rim_deflection(0.1, 0.3, -10.0);
  double borne = 0.0;
  still.simulation.total_energy(0.0);  // forces, with those of seams
  for (const ShellPart& part : still.simulation.state.shells) {
    const ShellModel& m = part.model();
    for (const double share : {0.0, 0.3, 1.0})
      EXPECT_NEAR(displacement(m, *part.state, {share * m.patch.knots_u.end(), 0.0}).z(), exact, 5e-3 * std::abs(exact))
          << m.name << " " << share;
    borne += reaction(m, *part.state, Vec3::Zero()).z();
  }
  EXPECT_NEAR(borne, 10.0 * kPi * 0.08, 1e-6 * 10.0 * kPi * 0.08);
}

namespace {

// omega b^2 sqrt(rho h / D) of a mode.
double plate_number(double outer, const Mode& mode) {
  return 2.0 * kPi * mode.frequency * outer * outer * std::sqrt(kDensity * kThickness / kStiffness);
}

}  // namespace

// A disc but for a pinhole, which softens it by about the square of its share: 10.2158 (Leissa 1969, zero of
// J0(k) I1(k) + I0(k) J1(k), squared).
TEST(RingSectors, ADiscWithAPinholeVibratesAsAClampedDisc) {
  Still still(ring("inner_m: 0.004 outer_m: 0.2 element_m: 0.02 degree: 3", "supports { edges: OUTER kind: CLAMPED }"));
  const ModeSet found = vibration_modes(still.joined(), 3, 1);
  EXPECT_NEAR(plate_number(0.2, found.modes[0]), 10.2158, 0.01 * 10.2158);
  EXPECT_NEAR(plate_number(0.2, found.modes[1]), 21.2604, 0.01 * 21.2604);
  EXPECT_NEAR(plate_number(0.2, found.modes[2]), 21.2604, 0.01 * 21.2604);
  EXPECT_EQ(found.rigid, 0);
}
