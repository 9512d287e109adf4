// What tips that run abreast may spend together, against the energy release of one crack in their place, which a ring
// tells.
#include "shell/solver/cracking/abreast.h"

#include <gtest/gtest.h>

#include "shell/solver/cracking/energy_release.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A square pane held at its lower and upper edge, stretched across them or bent about them, in equilibrium, with cuts
// from its left edge to its middle at these distances [spacings] from its middle line. Each cut has a tip.
struct CutPane {
  ShellModel m;
  ShellState s;
  std::vector<Drive> drives{};  // by mean stress
  std::vector<double> rings{};  // energy release [J/m^2]; negative: no room

  CutPane(bool bent, const std::vector<double>& cuts) : m(model()), s(make_state(m, Vec3::Zero(), 1)) {
    for (const double d : cuts) {
      const double v = 0.1 + d * m.spacing;
      insert_polyline(m, s, {{-0.01, v}, {0.1, v}}, 0.0);
      const CrackEdge& e = s.cracks.graph.edges().back();
      Tip tip;
      tip.p = e.b, tip.direction = (e.b - e.a).normalized();
      tip.vertex = e.to, tip.crack = e.crack, tip.edge = static_cast<int>(s.cracks.graph.edges().size()) - 1;
      s.cracks.tips.push_back(tip);
    }
    const std::size_t stride = s.motion.x.size() / 3;
    for (std::size_t k = 0; k < stride; ++k) {
      const double v = m.parameter_of_slot[k].y() - 0.1;
      (bent ? s.motion.x[2 * stride + k] : s.motion.x[stride + k]) += bent ? 0.01 * v * v : 1e-4 * v;
    }
    RelaxationRules rules;
    rules.most_newton = 0, rules.tolerance = 1e-4;
    EXPECT_TRUE(relax(m, s, rules).converged);
    compute_forces(m, s, true, 1.0, 1);
    for (const Tip& tip : s.cracks.tips) {
      Start start;
      start.p = tip.p, start.direction = tip.direction, start.edge = tip.edge;
      drives.push_back(drive_at(m, s, make_crack_rules(m, 0.0), start));
      ReleaseRing ring;
      const auto release = tip_release(m, s, tip, ring);
      rings.push_back(release ? release->x() : -1.0);
    }
  }
  static ShellModel model() {
    Support hold;
    hold.edges = kVMin | kVMax;
    ShellMaterial g = glass();
    g.strength = 60e6, g.fracture_energy = 8.0;
    return make_shell("p", plate(0.2, 0.2, 40, 40, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, g, 2, 2, {hold});
  }
  std::vector<double> shares(const std::vector<Drive>& of) const {
    return shares_abreast(m, s, make_crack_rules(m, 0.0), of);
  }
  double by_mean(std::size_t k) const { return drives[k].ratio * drives[k].ratio * m.material.fracture_energy; }
};

}  // namespace

// The mean stress ahead of a tip tells its energy release to within a quarter in these grids, and so the sum. Without
// shares it is 1.4 to 1.9 times what there is.
TEST(TipsAbreast, SpendWhatOneWouldAlone) {
  for (const bool bent : {false, true}) {
    const double alone = CutPane(bent, {0.0}).rings[0];
    ASSERT_GT(alone, 0.0);
    for (const double apart : {1.0, 1.5, 2.0}) {
      const CutPane pane(bent, {-0.5 * apart, 0.5 * apart});
      ASSERT_LT(std::max(pane.rings[0], pane.rings[1]), 0.0);
      const std::vector<double> share = pane.shares(pane.drives);
      const double before = pane.by_mean(0) + pane.by_mean(1);
      EXPECT_GT(before / alone, 1.3) << bent << " " << apart;
      EXPECT_NEAR((share[0] * pane.by_mean(0) + share[1] * pane.by_mean(1)) / alone, 1.0, 0.25) << bent << " " << apart;
    }
    // with room for a ring each, rings tell; they share nothing, and have nearly as much together
    const CutPane apart(bent, {-1.5, 1.5});
    std::vector<Drive> by_ring = apart.drives;
    for (std::size_t k = 0; k < 2; ++k) by_ring[k].release = apart.rings[k];
    EXPECT_EQ(apart.shares(by_ring), (std::vector{1.0, 1.0}));
    EXPECT_NEAR((apart.rings[0] + apart.rings[1]) / alone, 1.0, 0.15) << bent;
  }
}

TEST(TipsAbreast, AreThoseThatGoTheSameWayNearbyAndSeeEachOther) {
  const ShellModel m = CutPane::model();
  const CrackRules rules = make_crack_rules(m, 0.0);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  std::vector<Tip>& tips = s.cracks.tips;
  tips.resize(3);
  for (Tip& tip : tips) tip.p = Vec2(0.1, 0.1), tip.direction = Vec2(1, 0);
  tips[1].p.y() += m.spacing;
  tips[2].p.y() -= 3.0 * m.spacing;  // beyond the least ring
  std::vector<Drive> drives(3);
  drives[0].ratio = 2.0, drives[1].ratio = 1.0, drives[2].ratio = 5.0;
  const auto shares = [&] { return shares_abreast(m, s, rules, drives); };
  const double overlap = std::exp(-0.25);  // a = 2, R two spacings, one apart
  EXPECT_NEAR(shares()[0], 4.0 / (4.0 + overlap), 1e-12);
  EXPECT_NEAR(shares()[1], 4.0 * overlap / (1.0 + 4.0 * overlap), 1e-12);
  EXPECT_EQ(shares()[2], 1.0);
  const std::vector alone{1.0, 1.0, 1.0};
  tips[1].direction = Vec2(-1, 0);  // one comes to meet it
  EXPECT_EQ(shares(), alone);
  tips[1].direction = Vec2(1, 0), tips[1].alive = false;
  EXPECT_EQ(shares(), alone);
  tips[1].alive = true, drives[1].ratio = 0.0;  // nothing opens it
  EXPECT_EQ(shares(), alone);
  drives[1].ratio = 1.0;
  insert_polyline(m, s, {{0.08, 0.1 + 0.5 * m.spacing}, {0.12, 0.1 + 0.5 * m.spacing}}, 0.0);  // an old crack between
  EXPECT_EQ(shares(), alone);
}
