#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/solver/compression.h"
#include "shell/solver/forces.h"
#include "shell/solver/state.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Compression, PastWhatANegativePoissonRatioPermitsIsRefusedWithTheNumber) {
  ShellMaterial g = glass();
  g.poisson_ratio = -0.5;
  const ShellModel m = make_shell("p", plate(0.5, 0.4, 6, 5, Vec3::Zero(), Quat::Identity()), 0.004, g, 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const auto squeeze = [&](double share) {
    for (int i = 0; i < m.control_points(); ++i) s.motion.x[m.tables.slot(i)] = share * m.patch.control_points[i].x();
  };
  squeeze(0.5);
  check_compression(m, s);
  squeeze(0.44);
  compute_forces(m, s, false, 0.0, 1);
  for (const double f : s.motion.force) EXPECT_TRUE(std::isfinite(f));
  try {
    check_compression(m, s);
    FAIL() << "not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kPhysics);
    EXPECT_NE(std::string(e.what()).find("0.44 of its area"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("0.446"), std::string::npos) << e.what();
  }
}
