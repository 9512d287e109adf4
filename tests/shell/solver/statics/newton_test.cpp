// Newton steps of an uncracked shell.
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/newton.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Support clamp(int edges) {
  Support s;
  s.edges = edges;
  return s;
}

Load end_force(double newton_per_m) {
  Load l;
  l.kind = Load::Kind::kEdgeForce, l.edges = kUMax, l.force = Vec3(0, 0, newton_per_m);
  return l;
}

double norm_of_free(const FreeDegrees& free, const std::vector<double>& force) {
  double sum = 0.0;
  for (std::size_t k = 0; k < force.size(); ++k)
    if (free.number[k] >= 0) sum += force[k] * force[k];
  return std::sqrt(sum);
}

}  // namespace

TEST(FreeDegrees, AreThoseThatNoSupportHolds) {
  const ShellModel m = strip({clamp(kUMin)}, {});
  const FreeDegrees free = free_degrees(m, make_state(m, Vec3::Zero(), 0));
  EXPECT_EQ(free.count, 3 * (m.tables.columns - 2) * m.tables.rows);  // both columns of the clamped edge are held
  std::set<int> numbers;
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d) {
      const int n = free.number[static_cast<std::size_t>(d) * m.tables.plane + m.tables.slot(i)];
      EXPECT_EQ(n < 0, i % m.tables.columns < 2);
      if (n >= 0) numbers.insert(n);
    }
  EXPECT_EQ(static_cast<int>(numbers.size()), free.count);
  EXPECT_EQ(*numbers.rbegin(), free.count - 1);
}

TEST(FreeDegrees, OfWhatMovesTogetherAreOne) {
  Support mirror;
  mirror.edges = kVMin, mirror.clamped = false, mirror.symmetry = 1;
  const ShellModel m = strip({clamp(kUMin), mirror}, {});
  ASSERT_FALSE(m.constraints.tied[2].empty());
  const FreeDegrees free = free_degrees(m, make_state(m, Vec3::Zero(), 0));
  for (const auto& group : m.constraints.tied[2]) {
    std::set<int> numbers;
    for (const int slot : group) numbers.insert(free.number[2 * static_cast<std::size_t>(m.tables.plane) + slot]);
    EXPECT_EQ(numbers.size(), 1u);
  }
}

// A load so small that the shell answers linearly: one step is equilibrium, and the deflection that of a beam.
TEST(NewtonStep, FindsALinearAnswerAtOnce) {
  const double load = 1e-3, length = 1.0, young = 70e9, thickness = 0.01;
  const ShellModel m = strip({clamp(kUMin)}, {end_force(load)});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const auto forces = [&] { compute_forces(m, s, false, 0.0, 1); };
  forces();
  const FreeDegrees free = free_degrees(m, s);
  const std::vector<double> residual = s.motion.force;
  const std::vector<double> step = newton_step(m, s, free, residual, forces);
  ASSERT_EQ(step.size(), residual.size());
  for (std::size_t k = 0; k < step.size(); ++k) {
    if (free.number[k] < 0) {
      EXPECT_EQ(step[k], 0.0);
    }
    s.motion.x[k] += step[k];
  }
  forces();
  // differences leave 1e-6 of the tangent, and the deflection of 1e-8 m is not infinitely small
  EXPECT_LT(norm_of_free(free, s.motion.force), 1e-4 * norm_of_free(free, residual));
  const double beam = load * std::pow(length, 3) / (3.0 * young * std::pow(thickness, 3) / 12.0);
  EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).z(), beam, 0.01 * beam);
}
