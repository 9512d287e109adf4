// The list of criteria: which are at work, which stress they look at, and when they propose edges.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/criteria.h"
#include "shell/solver/cracking/insertion.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

FractureRules rules_of(FractureMode mode) {
  FractureRules rules;
  rules.mode = mode;
  return rules;
}

FractureRules with_cut(FractureRules rules, double time) {
  rules.cuts.push_back({.lines = {{{0.03, 0.05}, {0.12, 0.09}}}, .on_edges = {{kUMin, 0.25, 0.75}}, .time = time});
  return rules;
}

std::vector<std::string> at_work(const FractureRules& rules) {
  std::vector<std::string> names;
  each_criterion(rules, [&](const Criterion& c) { names.emplace_back(c.name); });
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST(Criteria, AreThoseThatTheRulesAskForInTheirOrder) {
  const FractureRules none = rules_of(FractureMode::kNone), tips = rules_of(FractureMode::kTips),
                      damage = rules_of(FractureMode::kDamage);
  EXPECT_EQ(at_work(none), Names{});
  EXPECT_EQ(at_work(with_cut(none, 0.0)), Names{"prescribed_cuts"});
  EXPECT_EQ(at_work(tips), (Names{"tips_by_energy", "nucleation_by_strength"}));
  EXPECT_EQ(at_work(with_cut(tips, 0.0)), (Names{"prescribed_cuts", "tips_by_energy", "nucleation_by_strength"}));
  EXPECT_EQ(at_work(damage), Names{"cracks_from_damage"});
  EXPECT_FALSE(can_crack(none));
  EXPECT_TRUE(can_crack(with_cut(none, 1.0)));
  EXPECT_TRUE(can_crack(tips));
  EXPECT_TRUE(can_crack(damage));
}

TEST(Criteria, LookAtTheLargestShareOfANewStressThatAnyAsksFor) {
  const ShellModel m = brittle_sheet(10);
  const double time = m.response_time();
  EXPECT_EQ(stress_share(rules_of(FractureMode::kNone), m, time), 0.0);
  EXPECT_EQ(stress_share(with_cut(rules_of(FractureMode::kNone), 0.0), m, time), 0.0);
  EXPECT_NEAR(stress_share(rules_of(FractureMode::kTips), m, 0.25 * time), 0.25, 1e-15);
  EXPECT_EQ(stress_share(rules_of(FractureMode::kTips), m, 3.0 * time), 1.0);
  EXPECT_EQ(stress_share(with_cut(rules_of(FractureMode::kDamage), 0.0), m, 0.25 * time), 1.0);
}

TEST(Criteria, ProposeAtTheirMomentOnly) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const FractureRules rules = with_cut(rules_of(FractureMode::kNone), 2e-3);
  s.cracks.cut_done.assign(1, 0);
  std::uint64_t random = 1;
  std::vector<EdgeCut> on_edges;
  const auto propose = [&](double time, CrackMoment moment) {
    return propose_edges({m, s, rules, time, 1e-3, random, &on_edges}, moment);
  };
  EXPECT_EQ(propose(0.5e-3, CrackMoment::kWindow), 0);  // it is not due yet
  EXPECT_EQ(propose(1.5e-3, CrackMoment::kLook), 0);    // cuts are made at the start of a window
  EXPECT_TRUE(s.cracks.graph.edges().empty());
  EXPECT_TRUE(on_edges.empty());
  const int made = propose(1.5e-3, CrackMoment::kWindow);
  EXPECT_GT(made, 0);
  EXPECT_EQ(static_cast<int>(s.cracks.graph.edges().size()), made);
  ASSERT_EQ(on_edges.size(), 1u);
  EXPECT_EQ(on_edges[0].to, 0.75);
  EXPECT_EQ(propose(2.5e-3, CrackMoment::kWindow), 0);  // once is enough
  EXPECT_EQ(random, 1u);
}

// Where no criterion has looks, cuts alone have faces, and a window's start is the moment.
TEST(Criteria, FacesThatAreApartAreReleasedAtALook) {
  for (const bool looks : {true, false}) {
    const ShellModel m = brittle_sheet(10);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const int from = s.cracks.graph.add_vertex({0.05, 0.15}), to = s.cracks.graph.add_vertex({0.0571, 0.1512});
    insert_edge(m, s, from, to, s.cracks.graph.new_crack(), 0.0, 1, true);
    ASSERT_EQ(s.cracks.interlocks.size(), 1u);
    Interlock& faces = s.cracks.interlocks[0];
    FractureRules rules = rules_of(looks ? FractureMode::kTips : FractureMode::kNone);
    rules.tips.faces.opening = 1e-3;
    std::uint64_t random = 1;
    const auto propose = [&](CrackMoment moment) { propose_edges({m, s, rules, 0.0, 1e-6, random}, moment); };
    const CrackMoment when = looks ? CrackMoment::kLook : CrackMoment::kWindow;
    faces.opening = 0.5e-3;
    propose(when);
    EXPECT_TRUE(faces.holds);
    faces.opening = 2e-3;
    if (looks) {
      propose(CrackMoment::kWindow);
      EXPECT_TRUE(faces.holds);
    }
    propose(when);
    EXPECT_FALSE(faces.holds);
  }
}
