// Shape functions of points beside cracks.
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/mls.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Position and tangents of a plane of values are exact, lengths in spacings.
void expect_planes(const ShellModel& m, const MlsPoint& point, const Vec2& p) {
  const double h = m.spacing;
  double sum[3] = {}, x[3] = {}, y[3] = {};
  for (const MlsFunction& f : point.functions) {
    const Vec2 d = (m.parameter[f.control_point] - p) / h;
    for (int k = 0; k < 3; ++k) {
      const double n = k == 0 ? f.n[0] : h * f.n[k];
      sum[k] += n, x[k] += n * d.x(), y[k] += n * d.y();
    }
    EXPECT_EQ(f.n[3], 0.0);
  }
  constexpr double kRoundOff = 1e-10;  // of a condition up to 1e4
  EXPECT_NEAR(sum[0], 1.0, kRoundOff);
  EXPECT_NEAR(sum[1], 0.0, kRoundOff);
  EXPECT_NEAR(sum[2], 0.0, kRoundOff);
  EXPECT_NEAR(x[0], 0.0, kRoundOff);
  EXPECT_NEAR(x[1], 1.0, kRoundOff);
  EXPECT_NEAR(x[2], 0.0, kRoundOff);
  EXPECT_NEAR(y[0], 0.0, kRoundOff);
  EXPECT_NEAR(y[1], 0.0, kRoundOff);
  EXPECT_NEAR(y[2], 1.0, kRoundOff);
}

}  // namespace

TEST(LinearBasis, ReproducesPlanesWhereCracksAreClose) {
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  const ControlGrid grid = control_grid(m);
  std::mt19937_64 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int linear = 0, planes = 0, none = 0;
  for (int k = 0; k < 300; ++k) {
    // two parallel lines and one across them
    const double angle = uniform(0.0, 3.1), apart = uniform(1.0, 2.6) * m.spacing;
    const Vec2 along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    const Vec2 c(uniform(0.05, 0.15), uniform(0.05, 0.15));
    CrackGraph g(Vec2::Zero(), Vec2(0.2, 0.2), 6.0 * m.spacing, 1e-3 * m.spacing);
    const auto line = [&](const Vec2& a, const Vec2& b) {
      g.add_edge(g.add_vertex(a), g.add_vertex(b), g.new_crack(), 0.0, 0);
    };
    line(c - 0.05 * along, c + 0.05 * along);
    line(c + apart * across - 0.05 * along, c + apart * across + 0.05 * along);
    line(c - 0.002 * across, c + (apart + 0.002) * across);
    const Vec2 p = c + uniform(0.05, 0.95) * apart * across + uniform(0.05, 1.0) * m.spacing * along;
    const auto [u, v] = std::pair(m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
    Visibility visibility(grid, p, u, v);
    visibility.update(grid, g, static_cast<int>(g.edges().size()));
    const MlsPoint gauss = mls_point(grid, visibility), face = face_point(grid, visibility);
    if (gauss.basis == MlsBasis::kLinear) ++linear, expect_planes(m, gauss, p);
    if (gauss.basis != MlsBasis::kNone || face.basis == MlsBasis::kNone) continue;
    ++planes, expect_planes(m, face, p);
    double value = 0.0;
    for (const MlsFunction& f : face.functions) value += f.n[0] * f.n[0];
    EXPECT_LE(value, kFaceAmplification);
    none += gauss.functions.empty();
  }
  EXPECT_GT(linear, 5);
  EXPECT_GT(planes, 5);
  EXPECT_EQ(none, planes);
}

TEST(Mls, ReproducesQuadraticsAndTheirDerivativesBesideACrack) {
  const ShellModel m = brittle_sheet();
  CrackGraph g({0, 0}, {0.2, 0.2}, 0.02, 1e-4);
  const int a = g.add_vertex({0.02, 0.1}), b = g.add_vertex({0.18, 0.117});
  g.add_edge(a, b, g.new_crack(), 0.0, 0);
  const auto f = [](const Vec2& p) {
    return 1 + 2 * p.x() - p.y() + 3 * p.x() * p.x() + p.x() * p.y() - 2 * p.y() * p.y();
  };
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0.03, 0.17);
  int quadratic = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec2 p(uniform(random), 0.1 + 0.1 * (uniform(random) - 0.1));
    const MlsPoint q = mls_point(control_grid(m), g, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
    if (q.basis != MlsBasis::kQuadratic) continue;
    ++quadratic;
    double sum[6] = {}, one = 0.0;
    for (const MlsFunction& n : q.functions) {
      EXPECT_TRUE(g.visible(p, m.parameter[n.control_point]));
      one += n.n[0];
      for (int k = 0; k < 6; ++k) sum[k] += n.n[k] * f(m.parameter[n.control_point]);
    }
    const double h = m.spacing;  // conditioning up to 2500, derivatives scale with 1/h and 1/h^2
    EXPECT_NEAR(one, 1.0, 1e-12);
    EXPECT_NEAR(sum[0], f(p), 1e-11);
    EXPECT_NEAR(sum[1], 2 + 6 * p.x() + p.y(), 1e-11 / h);
    EXPECT_NEAR(sum[2], -1 + p.x() - 4 * p.y(), 1e-11 / h);
    EXPECT_NEAR(sum[3], 6.0, 1e-11 / (h * h));
    EXPECT_NEAR(sum[4], -4.0, 1e-11 / (h * h));
    EXPECT_NEAR(sum[5], 1.0, 1e-11 / (h * h));
  }
  EXPECT_GT(quadratic, 150);
}

TEST(Mls, KeepsTheStableStepOfACutSheet) {
  for (const double angle : {0.0, 10.0, 30.0, 45.0}) {
    const ShellModel m = brittle_sheet(24);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const double intact = stable_step(m, s, 200, 1, true);
    const Vec2 d(std::cos(angle * M_PI / 180), std::sin(angle * M_PI / 180)), c(0.1013, 0.0987);
    insert_polyline(m, s, {c - 0.07 * d, c + 0.07 * d}, 0.0);
    EXPECT_GE(stable_step(m, s, 200, 1, true), 0.8 * intact) << angle << " degrees";
    const double whole = stable_step(m, s, 200, 1, true);
    EXPECT_NEAR(stable_step(m, s, 60, 1, true, {c}), whole, 0.1 * intact);
    const double few = stable_step(m, s, kLocalIterations, 1, true, {c});  // as a run takes: from above, and not far
    EXPECT_GE(few, (1.0 - 1e-6) * whole);
    EXPECT_LE(few, 1.1 * whole);  // a cut in twelve was 5 % off
  }
}

// The Gauss points beside these cuts see their first row of control points 0.7 spacings off.
TEST(Mls, KeepsTheStableStepBesideARowOfControlPoints) {
  const ShellModel m = brittle_sheet();
  const ShellState uncut = make_state(m, Vec3::Zero(), 1);
  ShellState s = uncut;
  const double intact = stable_step(m, s, 200, 1, true);
  const auto after = [&](const std::vector<double>& heights) {
    s = uncut;
    for (const double y : heights) insert_polyline(m, s, {{0.0, y * m.spacing}, {0.2, y * m.spacing}}, 0.0);
    return stable_step(m, s, 200, 1, true) / intact;
  };
  EXPECT_GE(after({4.23}), 0.8);
  EXPECT_GE(after({8.73}), 0.8);
  EXPECT_GE(after({8.63, 13.23}), 0.8);  // a strip of four rows, both its sides like that
}
