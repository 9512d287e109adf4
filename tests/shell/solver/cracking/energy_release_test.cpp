// The energy release of a tip against the singular fields of stretched and bent plates, which are exact.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/geometry/builders.h"
#include "shell/solver/cracking/energy_release.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kPi = std::numbers::pi, kThickness = 0.004;
const Vec2 kTip(0.1033, 0.0971);

// A pane with a crack from its left edge to kTip, along u.
struct Pane {
  ShellModel m;
  ShellState s;

  explicit Pane(int elements = 40)
      : m(make_shell("p", plate(0.2, 0.2, elements, elements, Vec3(0.1, 0.1, 0), Quat::Identity()), kThickness, glass(),
                     2, 2, {})),
        s(make_state(m, Vec3::Zero(), 1)) {
    insert_polyline(m, s, {Vec2(-0.01, kTip.y()), kTip}, 0.0);
  }
  // Control points take the displacement of their Greville points, then turn about the origin.
  void displace(const std::function<Vec3(double r, double theta)>& field, const Quat& turn = Quat::Identity()) {
    const std::size_t stride = s.motion.x.size() / 3;
    for (std::size_t slot = 0; slot < stride; ++slot) {
      const Vec2 d = m.parameter_of_slot[slot] - kTip;
      const Vec3 x = turn * (s.at(m.rest, static_cast<int>(slot)) + field(d.norm(), std::atan2(d.y(), d.x())));
      for (int c = 0; c < 3; ++c) s.motion.x[c * stride + slot] = x[c];
    }
  }
  Vec2 both(double angle = 0.0) const {
    return energy_release_at(m, s, {kTip, Vec2(std::cos(angle), std::sin(angle)), 2.0 * m.spacing, 8.0 * m.spacing});
  }
  double release(double angle = 0.0) const { return both(angle).x(); }
  double young() const { return m.material.youngs_modulus; }
  double nu() const { return m.material.poisson_ratio; }
};

// In-plane fields of stress intensities k1, k2 [Pa sqrt(m)], plane stress.
std::function<Vec3(double, double)> stretched(const Pane& p, double k1, double k2) {
  const double mu = p.young() / (2.0 * (1.0 + p.nu())), kappa = (3.0 - p.nu()) / (1.0 + p.nu());
  return [=](double r, double t) {
    const double f = std::sqrt(r / (2.0 * kPi)) / (2.0 * mu), c = std::cos(0.5 * t), s = std::sin(0.5 * t);
    return Vec3(f * (k1 * c * (kappa - 1.0 + 2.0 * s * s) + k2 * s * (kappa + 1.0 + 2.0 * c * c)),
                f * (k1 * s * (kappa + 1.0 - 2.0 * c * c) - k2 * c * (kappa - 1.0 - 2.0 * s * s)), 0.0);
  };
}

// Bending fields (Williams 1961) of intensities k1, k2 [Pa sqrt(m)] of the stress of a face.
std::function<Vec3(double, double)> bent(const Pane& p, double k1, double k2) {
  const double nu = p.nu(), f = (1.0 - nu * nu) / (2.0 * p.young() * kThickness * (3.0 + nu));
  return [=](double r, double t) {
    const double size = std::pow(2.0 * r, 1.5) * f;
    return Vec3(0, 0,
                size * (k1 * ((7.0 + nu) / (3.0 * (1.0 - nu)) * std::cos(1.5 * t) - std::cos(0.5 * t)) +
                        k2 * ((5.0 + 3.0 * nu) / (3.0 * (1.0 - nu)) * std::sin(1.5 * t) - std::sin(0.5 * t))));
  };
}

double of_bending(const Pane& p, double k) { return k * k * kPi * (1.0 + p.nu()) / (3.0 * p.young() * (3.0 + p.nu())); }

}  // namespace

TEST(EnergyRelease, IsThatOfTheSingularFields) {
  Pane p;
  const double k = 1e6, g = k * k / p.young();
  p.displace(stretched(p, k, 0.0));
  EXPECT_NEAR(p.release() / g, 1.0, 0.05);
  p.displace(stretched(p, 0.0, k));
  EXPECT_NEAR(p.release() / g, 1.0, 0.05);
  p.displace(bent(p, k, 0.0));
  EXPECT_NEAR(p.release() / of_bending(p, k), 1.0, 0.05);
  p.displace(bent(p, 0.0, k));  // torn out of the plane
  EXPECT_NEAR(p.release() / of_bending(p, k), 1.0, 0.05);
}

TEST(EnergyRelease, IsTheSameHoweverTheShellIsTurned) {
  Pane p;
  const auto both = [&](double r, double t) -> Vec3 { return stretched(p, 1e6, 3e5)(r, t) + bent(p, 1e6, -5e5)(r, t); };
  p.displace(both);
  const double before = p.release();
  p.displace(both, Quat(Eigen::AngleAxisd(2.0, Vec3(1, -2, 0.5).normalized())));
  EXPECT_NEAR(p.release() / before, 1.0, 1e-6);
}

TEST(EnergyRelease, IsNothingInASmoothField) {
  Pane p;
  p.s = make_state(p.m, Vec3::Zero(), 1);  // no crack
  const double strain = 1e-3,
               energy = 0.5 * p.young() * strain * strain * p.m.spacing;  // [J/m^2], what a spacing stores
  const auto field = [&](double r, double t) {
    const double x = r * std::cos(t), y = r * std::sin(t);
    return Vec3(strain * x + 2.0 * strain * x * y, -0.5 * strain * y * y / 0.1,
                0.5 * strain / kThickness * (x * x - 0.3 * y * y));
  };
  p.displace(field, Quat(Eigen::AngleAxisd(1.0, Vec3(0, 1, 1).normalized())));
  for (const double angle : {0.0, 1.0, 2.0, 3.0}) EXPECT_LT(std::abs(p.release(angle)), 0.02 * energy) << angle;
}

TEST(EnergyRelease, FindsNewEdgesAndStaysWithThem) {
  Pane p;
  p.displace(stretched(p, 1e6, 0.0));
  ReleaseRing known;
  const ReleaseLook look{kTip, Vec2(1, 0), p.m.spacing, 4.0 * p.m.spacing};
  const Vec2 first = energy_release_at(p.m, p.s, look, known);
  EXPECT_EQ(energy_release_at(p.m, p.s, look, known), first);
  insert_polyline(p.m, p.s, {kTip, kTip + Vec2(p.m.spacing, 0)}, 0.0);
  EXPECT_EQ(energy_release_at(p.m, p.s, look, known), energy_release_at(p.m, p.s, look));
  EXPECT_NE(energy_release_at(p.m, p.s, look, known), first);
}

TEST(EnergyRelease, OfATipNeedsRoom) {
  Pane p;
  p.m.material.strength = 60e6, p.m.material.fracture_energy = 8.0;
  p.displace(stretched(p, 1e6, 0.0));
  Tip tip;
  tip.p = kTip, tip.direction = Vec2(1, 0), tip.edge = 0, tip.vertex = p.s.cracks.graph.edges().back().to;
  ReleaseRing known;
  ASSERT_TRUE(tip_release(p.m, p.s, tip, known).has_value());
  EXPECT_NEAR(tip_release(p.m, p.s, tip, known)->x() * p.young() / 1e12, 1.0, 0.2);  // a ring of four spacings
  insert_polyline(p.m, p.s, {kTip + Vec2(2.0 * p.m.spacing, -0.02), kTip + Vec2(2.0 * p.m.spacing, 0.02)}, 0.0);
  EXPECT_FALSE(tip_release(p.m, p.s, tip, known).has_value()) << "another crack ahead";
  Tip young = tip;
  young.flaw = 0.01, young.grown = 0.005;
  EXPECT_FALSE(tip_release(p.m, p.s, young, known).has_value()) << "shorter than its flaw";
}

TEST(EnergyRelease, KnowsHowFarTheFacesAreApart) {
  Pane p;
  p.m.material.strength = 60e6, p.m.material.fracture_energy = 8.0;
  Tip tip;
  tip.p = kTip, tip.direction = Vec2(1, 0), tip.edge = 0, tip.vertex = p.s.cracks.graph.edges().back().to;
  const double size = 0.05;  // [1/m], curvature of the legs behind the tip, up and down
  p.displace(
      [&](double r, double t) {
        const double x = r * std::cos(t);
        return Vec3(0, 0, x < 0.0 ? 0.5 * size * x * x * (t > 0.0 ? 1.0 : -1.0) : 0.0);
      },
      Quat(Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized())));
  ReleaseRing known;
  // the mean of x^2 over what lies from 1 to 4 spacings behind the tip, within a circle of 4: 5.69 spacings squared
  ASSERT_TRUE(tip_release(p.m, p.s, tip, known).has_value());
  EXPECT_NEAR(faces_apart(p.s, known) / (size * 5.69 * p.m.spacing * p.m.spacing), 1.0, 0.15);
  p.displace(stretched(p, 1e6, 0.0));  // apart within the plane only
  EXPECT_LT(faces_apart(p.s, known), 1e-9);
}

TEST(EnergyRelease, OfAKinkIsThatOfErdoganAndSih) {
  EXPECT_DOUBLE_EQ(kink_factor(0.0), 1.0);
  EXPECT_NEAR(kink_factor(std::acos(1.0 / 3.0)), 4.0 / 3.0, 1e-12);  // pure shear: K of the kink is 2/sqrt(3) of it
  EXPECT_EQ(kink_factor(0.4), kink_factor(-0.4));
}
