// Running tips: when they divide.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/solver/cracking/crack_cost.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tip_speed.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/grow_cracks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A sheet with a cut whose tip has the field of a crack that opens with four times the energy that it takes. Nothing
// else cracks.
ShellState opened(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, -0.01}, {0.1, 0.08}}, 0.0);
  const double e = m.material.youngs_modulus, nu = m.material.poisson_ratio, kappa = (3.0 - nu) / (1.0 + nu);
  const double k1 = 2.0 * std::sqrt(e * m.material.fracture_energy), shear = 0.5 * e / (1.0 + nu);
  for (int k = 0; k < m.control_points(); ++k) {
    const Vec2 d = m.parameter[k] - Vec2(0.1, 0.08);
    const double angle = std::atan2(-d.x(), d.y()), sine = std::sin(0.5 * angle), cosine = std::cos(0.5 * angle);
    const double u = 0.5 * k1 / shear * std::sqrt(d.norm() / (2.0 * std::numbers::pi));
    s.motion.x[m.tables.slot(k)] -= u * sine * (kappa + 1.0 - 2.0 * cosine * cosine);
    s.motion.x[m.tables.component_stride + m.tables.slot(k)] += u * cosine * (kappa - 1.0 + 2.0 * sine * sine);
  }
  compute_forces(m, s, false, 1.0, 1);
  std::fill(s.motion.force.begin(), s.motion.force.end(), 0.0);  // the field is at rest, up to the grid
  start_at_ends(m, s, 0, static_cast<int>(s.cracks.graph.edges().size()));
  EXPECT_EQ(s.cracks.tips.size(), 1u);
  s.cracks.tips[0].first_turn = 0.0;
  std::fill(s.layers.strength.begin(), s.layers.strength.end(), 1e12);
  return s;
}

}  // namespace

// In the field of a crack that opens with four times the energy that it takes; one divides at twice.
TEST(Tips, DivideOnlyAfterTheLengthOfAWholeCrack) {
  const auto tips_after_an_edge = [](double flaw, double grown) {
    const ShellModel m = brittle_sheet();
    ShellState s = opened(m);
    s.cracks.tips[0].flaw = flaw, s.cracks.tips[0].grown = grown;
    const CrackRules r = make_crack_rules(m, 0.0);
    std::uint64_t random = 1;
    for (int looks = 0; looks < 100 && s.cracks.tips[0].grown == grown; ++looks)
      grow_cracks(m, s, r, 0.0, 0.3 * r.advance / r.rayleigh, random);
    EXPECT_GT(s.cracks.tips[0].grown, grown);
    return s.cracks.tips.size();
  };
  EXPECT_EQ(tips_after_an_edge(0.0, 0.0), 2u);    // the end of a cut, at once
  EXPECT_EQ(tips_after_an_edge(0.04, 0.09), 2u);  // a crack of 8
  EXPECT_EQ(tips_after_an_edge(0.05, 0.09), 1u);  // of 10
}

// Its edges keep what their area takes at the speed of the tip; each arm of a division has half of the drive.
TEST(Tips, KeepTheFractureEnergyAtTheirSpeed) {
  for (const bool divides : {false, true}) {
    ShellModel m = brittle_sheet();
    m.material.crack_speed_onset = 0.1, m.material.toughening = 10.0;
    m.material.branch_drive = divides ? 2.0 : 1e12;
    ShellState s = opened(m);
    CrackRules r = make_crack_rules(m, 0.0);
    std::uint64_t random = 1;
    const auto cut = s.cracks.graph.edges().size();
    for (int looks = 0; looks < 100 && s.cracks.graph.edges().size() == cut; ++looks)
      grow_cracks(m, s, r, 0.0, 0.3 * r.advance / r.rayleigh, random);
    ASSERT_EQ(s.cracks.graph.edges().size(), cut + (divides ? 2 : 1));
    const double takes = s.cracks.graph.edges()[cut].resistance;
    EXPECT_EQ(s.cracks.graph.edges().back().resistance, takes);
    // the field has four times the fracture energy, as the mean ahead of the tip sees it
    const double g = divides ? 2.0 : 4.0, exact = toughened(m.material, tip_speed(m.material, g));
    EXPECT_NEAR(takes, exact, 0.15 * exact) << divides;
    EXPECT_GT(takes, 1.5);
  }
}

// An edge releases more or less than it costs. A tip owes what is missing to its next edges; what is over is returned,
// but for the first edge of a new crack.
TEST(Tips, SettleWhatEdgesReleaseAgainstTheirCost) {
  struct Account {
    double owed, flaw, grown;
    bool returns;
  };
  const ShellModel m = brittle_sheet();
  const double cost = m.material.fracture_energy * m.thickness * m.spacing;  // of about an edge
  for (const Account& a : {Account{0.0, 0.0, 0.0, true},
                           {0.1 * cost, 0.0, 0.0, true},
                           {100.0 * cost, 0.0, 0.0, false},
                           {0.0, 0.04, 0.01, true},
                           {0.0, 0.04, 0.0, false}}) {
    ShellState s = opened(m);
    CrackRules r = make_crack_rules(m, 0.0);
    r.branch_ratio = 1e6;
    Tip& tip = s.cracks.tips[0];
    tip.owed = a.owed, tip.flaw = a.flaw, tip.grown = a.grown;
    std::uint64_t random = 1;
    const auto cut = s.cracks.graph.edges().size();
    for (int looks = 0; looks < 100 && s.cracks.graph.edges().size() == cut; ++looks)
      grow_cracks(m, s, r, 0.0, 0.3 * r.advance / r.rayleigh, random);
    ASSERT_EQ(s.cracks.graph.edges().size(), cut + 1);
    const double over = s.cracks.taken - edge_cost(m, s.cracks.graph.edges().back()) - a.owed;
    EXPECT_EQ(over > 0.0, a.owed < cost);  // in this field an edge releases more than it costs
    EXPECT_NEAR(s.cracks.surplus, a.returns ? over : 0.0, 1e-12 * cost);
    EXPECT_NEAR(s.cracks.tips[0].owed, std::max(0.0, -over), 1e-12 * cost);
  }
}
