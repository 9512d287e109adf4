// The forces of a search for equilibrium: a strip that an end force pulls.
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "shell/solver/statics/balance.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A strip held at u = 0, pulled along x by 1 kN/m over its width of 20 cm.
struct PulledStrip {
  ShellModel model;
  ShellState state;
  JoinedShells joined;

  explicit PulledStrip(std::vector<Load> loads)
      : model(strip({held()}, loads)), state(make_state(model, Vec3::Zero(), 0)) {
    joined.shells = {{&model, &state}}, joined.numbers = {0}, joined.gravity = {Vec3::Zero()};
  }
  static Support held() {
    Support s;
    s.edges = kUMin;
    return s;
  }
  static Load pull() {
    Load l;
    l.kind = Load::Kind::kEdgeForce, l.edges = kUMax, l.force = Vec3(1e3, 0, 0);
    return l;
  }
  // Sum of the unbalanced forces on free control points along an axis [N].
  double sum(const Balance& b, const std::vector<double>& of, int axis) const {
    const auto stride = static_cast<std::size_t>(model.tables.component_stride);
    double out = 0.0;
    for (std::size_t k = axis * stride; k < (axis + 1) * stride; ++k)
      if (b.inverse[k] > 0.0) out += of[k];
    return out;
  }
};

}  // namespace

TEST(Balance, HasNoForceAtShareZeroAndAllOfTheLoadAtOne) {
  PulledStrip s({PulledStrip::pull()});
  Balance b(s.joined, 1);
  std::vector<double> summed;
  for (const double share : {0.0, 0.25, 1.0}) {
    b.go_to(share);
    b.compute();
    const double residual = b.residual(summed);
    EXPECT_NEAR(s.sum(b, summed, 0), share * 200.0, 1e-10 * 200.0);  // 1e3 N/m on 0.2 m
    EXPECT_NEAR(s.sum(b, summed, 1), 0.0, 1e-10 * 200.0);
    EXPECT_NEAR(residual, share, 1e-8);  // nothing has moved yet; round-off of 70 GPa against the load
  }
}

TEST(Balance, WorkOfTheLoadIsForceTimesWay) {
  PulledStrip s({PulledStrip::pull()});
  Balance b(s.joined, 1);
  b.go_to(1.0);
  b.compute();
  std::vector<double> summed, step(b.x.size(), 0.0);
  b.residual(summed);
  EXPECT_EQ(b.work_from(b.start()), 0.0);
  const auto stride = static_cast<std::size_t>(s.model.tables.component_stride);
  for (std::size_t k = 0; k < stride; ++k)
    if (b.inverse[k] > 0.0) step[k] = 1e-3, b.x[k] += 1e-3;
  EXPECT_NEAR(b.work_on(step), 200.0 * 1e-3, 1e-9);  // internal forces at rest are round-off of 70 GPa
  EXPECT_NEAR(b.work_from(b.start()), 200.0 * 1e-3, 1e-12);
}

TEST(Balance, AShellWithoutLoadsIsInBalanceWhereItBegins) {
  PulledStrip s({});
  Balance b(s.joined, 2);
  b.go_to(1.0);
  b.compute();
  std::vector<double> summed;
  EXPECT_LT(b.residual(summed), 1e-6);  // round-off against the force of a strain of 1e-7
  EXPECT_FALSE(b.rotates());
  EXPECT_EQ(b.open(), 0.0);
}

TEST(Balance, RoundOffIsFarBelowTheLoadAndAStateThatIsNoPlaceIsNoBalance) {
  PulledStrip s({PulledStrip::pull()});
  Balance b(s.joined, 1);
  b.go_to(1.0);
  b.compute();
  const double round_off = b.round_off();
  EXPECT_GT(round_off, 0.0);
  EXPECT_LT(round_off, 1e-3);
  b.x[static_cast<std::size_t>(s.model.tables.slot(s.model.control_points() / 2))] = std::nan("");
  b.compute();
  std::vector<double> summed;
  EXPECT_FALSE(b.residual(summed) <= 1.0);
}

TEST(Balance, HeldControlPointsHaveNoMassAndOthersDo) {
  PulledStrip s({PulledStrip::pull()});
  const Balance b(s.joined, 1);
  const auto stride = static_cast<std::size_t>(s.model.tables.component_stride);
  int held = 0;
  for (int i = 0; i < s.model.control_points(); ++i)
    for (int c = 0; c < 3; ++c) {
      const std::size_t k = c * stride + static_cast<std::size_t>(s.model.tables.slot(i));
      held += b.inverse[k] == 0.0;
      EXPECT_EQ(b.inverse[k] == 0.0, b.degrees().number()[k] < 0);
      if (b.inverse[k] > 0.0) {
        EXPECT_NEAR(b.inverse[k] * b.mass[k], 1.0, 1e-15);
      }
    }
  EXPECT_EQ(held, 2 * 3 * s.model.patch.rows());  // a clamp holds two columns
}
