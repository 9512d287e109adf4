// Newton steps of an uncracked shell.
#include <algorithm>
#include <cmath>
#include <numbers>
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

Load end_force(const Vec3& force) {
  Load l;
  l.kind = Load::Kind::kEdgeForce, l.edges = kUMax, l.force = force;
  return l;
}

double norm_of_free(const FreeDegrees& free, const std::vector<double>& force) {
  double sum = 0.0;
  for (std::size_t k = 0; k < force.size(); ++k)
    if (free.number[k] >= 0) sum += force[k] * force[k];
  return std::sqrt(sum);
}

}  // namespace

// Bars and beams whose loads are so small that they answer linearly. Differences of the force leave 1e-6 of the
// tangent.
TEST(NewtonStep, FindsALinearAnswerAtOnce) {
  const double length = 1.0, young = 70e9, thickness = 0.01;
  struct Case {
    Vec3 load;     // at the end [N/m]
    double exact;  // along it [m]
    double share;
    std::vector<Support> supports;
  };
  Support hold, guide;  // a clamp would stiffen the bar's first element
  hold.edges = kUMin, guide.edges = kUMax, hold.clamped = guide.clamped = false, guide.axes = {false, true, true};
  const double bar = 1e3 * length / (young * thickness);
  const double beam = 1e-3 * std::pow(length, 3) / (3.0 * young * std::pow(thickness, 3) / 12.0);
  for (const Case& c :
       {Case{Vec3(1e3, 0, 0), bar, 1e-4, {hold, guide}}, Case{Vec3(0, 0, 1e-3), beam, 0.01, {clamp(kUMin)}}}) {
    const ShellModel m = strip(c.supports, {end_force(c.load)});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    const auto forces = [&] { compute_forces(m, s, false, 0.0, 1); };
    forces();
    const FreeDegrees free = free_degrees(m, s);
    const std::vector<double> residual = s.motion.force;
    const std::vector<double> step = newton_step(m, s, free, residual, Differences::kOneSided, forces).u;
    ASSERT_EQ(step.size(), residual.size());
    EXPECT_EQ(s.motion.force, residual);  // as it was
    for (std::size_t k = 0; k < step.size(); ++k) {
      if (free.number[k] < 0) {
        EXPECT_EQ(step[k], 0.0);
      }
      s.motion.x[k] += step[k];
    }
    EXPECT_NEAR(displacement(m, s, {1.0, 0.1}).dot(c.load.normalized()), c.exact, c.share * c.exact);
    forces();
    // bent, a spurious stretch of 1e-14 m is left: it takes a large part of so small a load
    if (c.load.x() > 0.0) {
      EXPECT_LT(norm_of_free(free, s.motion.force), 1e-4 * norm_of_free(free, residual));
    }
  }
}

// Euler's load of a strip that is clamped at one end: pi^2 E I/(4 L^2), 14.4 kN/m.
TEST(NewtonStep, TellsWhetherTheShellIsStable) {
  for (const Differences differences : {Differences::kOneSided, Differences::kCentral})
    for (const double load : {0.9, 1.1}) {
      const double euler = std::numbers::pi * std::numbers::pi * 70e9 * 1e-6 / 12.0 / 4.0;
      const ShellModel m = strip({clamp(kUMin)}, {end_force(Vec3(-load * euler, 0, 0))});
      ShellState s = make_state(m, Vec3::Zero(), 0);
      const auto forces = [&] { compute_forces(m, s, false, 0.0, 1); };
      const FreeDegrees free = free_degrees(m, s);
      bool unstable = false;
      for (int k = 0; k < 3; ++k) {  // straight, it is compressed only
        forces();
        const NewtonStep step = newton_step(m, s, free, std::vector<double>(s.motion.force), differences, forces);
        ASSERT_FALSE(step.u.empty());
        for (std::size_t i = 0; i < step.u.size(); ++i) s.motion.x[i] += step.u[i];
        unstable = step.unstable;
      }
      EXPECT_EQ(unstable, load > 1.0);
    }
}
