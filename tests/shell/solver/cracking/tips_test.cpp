// Running tips: when they divide, and when an extension is refused.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/grow_cracks.h"

using namespace sunder;
using namespace sunder::shell;

TEST(ExtendCracks, ThatWouldAddEnergyIsRefusedAndChangesNothing) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& x : s.motion.x) x += 1e-5 * uniform(random);
  ShellState forgetful = s;  // of what was tried before: the same comes of it
  int refused = 0, taken = 0;
  for (int k = 0; k < 60; ++k) {
    const Vec2 from(0.1 + 0.06 * uniform(random), 0.1 + 0.06 * uniform(random));
    const Vec2 to = from + 0.75 * m.spacing * turned(Vec2(1, 0), 3.0 * uniform(random));
    const int vertex = s.cracks.graph.add_vertex(from);
    const std::size_t edges = s.cracks.graph.edges().size(), vertices = s.cracks.graph.vertices().size(),
                      points = s.cracked.gathered.size();
    const double length = s.cracks.graph.total_length(), energy = compute_forces(m, s, true, 0.0, 1);
    const int edge = extend_cracks(m, s, {{vertex, to, k, 1}}, 0.0, false);
    forgetful.cracks.add_vertex(from), forgetful.trials.clear();
    EXPECT_EQ(extend_cracks(m, forgetful, {{vertex, to, k, 1}}, 0.0, false), edge);
    if (edge < 0) {  // once more, by what is remembered
      EXPECT_LT(extend_cracks(m, s, {{vertex, to, k, 1}}, 0.0, false), 0);
    }
    EXPECT_EQ(compute_forces(m, forgetful, true, 0.0, 1), compute_forces(m, s, true, 0.0, 1));
    EXPECT_EQ(forgetful.force, s.motion.force);
    EXPECT_EQ(s.book.injected, 0.0);
    if (edge >= 0) {
      EXPECT_LE(compute_forces(m, s, true, 0.0, 1), energy * (1.0 + 1e-12));
      ++taken;
      continue;
    }
    EXPECT_EQ(s.cracks.graph.edges().size(), edges);
    EXPECT_EQ(s.cracks.graph.vertices().size(), vertices);
    EXPECT_EQ(s.cracked.gathered.size(), points);
    EXPECT_NEAR(s.cracks.graph.total_length(), length, 1e-15);
    EXPECT_EQ(compute_forces(m, s, true, 0.0, 1), energy);
    ++refused;
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(taken, 0);
}

// In the field of a crack that opens with four times the energy that it takes; one divides at twice.
TEST(Tips, DivideOnlyAfterTheLengthOfAWholeCrack) {
  const auto tips_after_an_edge = [](double flaw, double since) {
    const ShellModel m = brittle_sheet();
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{0.1, -0.01}, {0.1, 0.08}}, 0.0);
    const double e = m.material.youngs_modulus, nu = m.material.poisson_ratio, kappa = (3.0 - nu) / (1.0 + nu);
    const double k1 = 2.0 * std::sqrt(e * m.material.fracture_energy), shear = 0.5 * e / (1.0 + nu);
    for (int k = 0; k < m.control_points(); ++k) {
      const Vec2 d = m.parameter[k] - Vec2(0.1, 0.08);
      const double angle = std::atan2(-d.x(), d.y()), sine = std::sin(0.5 * angle), cosine = std::cos(0.5 * angle);
      const double u = 0.5 * k1 / shear * std::sqrt(d.norm() / (2.0 * std::numbers::pi));
      s.motion.x[m.tables.slot(k)] -= u * sine * (kappa + 1.0 - 2.0 * cosine * cosine);
      s.motion.x[m.tables.plane + m.tables.slot(k)] += u * cosine * (kappa - 1.0 + 2.0 * sine * sine);
    }
    compute_forces(m, s, false, 1.0, 1);
    start_at_ends(m, s, 0, static_cast<int>(s.cracks.graph.edges().size()));
    EXPECT_EQ(s.cracks.tips.size(), 1u);
    s.cracks.tips[0].since_branch = since, s.cracks.tips[0].flaw = flaw, s.cracks.tips[0].grown = 1.0,
    s.cracks.tips[0].first_turn = 0.0;
    const CrackRules r = make_crack_rules(m, 0.0);
    std::uint64_t random = 1;
    std::fill(s.layers.strength.begin(), s.layers.strength.end(), 1e12);  // nothing else cracks
    for (int looks = 0; looks < 100 && s.cracks.tips[0].grown == 1.0; ++looks)
      grow_cracks(m, s, r, 0.0, 0.3 * r.advance / r.rayleigh, random);
    EXPECT_GT(s.cracks.tips[0].grown, 1.0);
    return s.cracks.tips.size();
  };
  EXPECT_EQ(tips_after_an_edge(0.0, 0.09), 2u);   // 9 spacings
  EXPECT_EQ(tips_after_an_edge(0.0, 0.07), 1u);   // 7
  EXPECT_EQ(tips_after_an_edge(0.04, 0.09), 2u);  // a crack of 8
  EXPECT_EQ(tips_after_an_edge(0.05, 0.09), 1u);  // of 10
}
