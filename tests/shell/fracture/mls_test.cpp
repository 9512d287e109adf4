// Functions of points between close cracks, where no quadratic basis is sound.
#include <random>

#include <gtest/gtest.h>

#include "shell/fracture/mls.h"
#include "shell/solver/cracking/insertion.h"
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
    Sight sight(grid, p, u, v);
    sight.update(grid, g, static_cast<int>(g.edges().size()));
    const MlsPoint gauss = mls_point(grid, sight), face = face_point(grid, sight);
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
