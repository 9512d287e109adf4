// Impulses of supports: they close the balance of momentum, and each edge has its own.
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "shell/io/probes.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kStep = 2e-7;
constexpr int kSteps = 1500;
const Vec3 kTilted(30.0, -20.0, -9.81);
const Vec3 kPull(2e3, -1e3, 500.0);  // [N/m] along an edge of 0.2 m

RigidBody ball(const Vec3& at) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.1, b.principal_inertia = Vec3::Constant(1e-5), b.shape = SphereShape{0.02};
  b.motion.position = at, b.motion.velocity = Vec3(1, 0.5, -6);
  return b;
}

/// A pane that is clamped, held along one axis, on a plane of symmetry, and driven at a corner.
ShellModel held_in_all_ways() {
  Support clamp, roller, mirror, corner;
  clamp.edges = kUMin;
  roller.edges = kUMax, roller.clamped = false, roller.axes = {false, false, true};
  mirror.edges = kVMin, mirror.symmetry = 1;
  corner.corners = kUMaxVMax, corner.clamped = false, corner.axes = {true, false, false};
  corner.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(2.0, 0, 0)}};
  Load pull;
  pull.kind = Load::Kind::kEdgeForce, pull.edges = kVMax, pull.force = kPull;
  ShellMaterial m = glass();
  m.stiffness_damping = 2e-8;
  return make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, m, 2, 2,
                    {clamp, roller, mirror, corner}, {pull});
}

double weighed(const ShellModel& m) {
  double sum = 0.0;
  for (const double mass : m.mass) sum += mass;
  return sum;
}

}  // namespace

TEST(SupportImpulse, ClosesTheBalanceOfMomentumInEveryTransfer) {
  for (const Transfer transfer : {Transfer::kDirect, Transfer::kFlip, Transfer::kApic, Transfer::kPic}) {
    SCOPED_TRACE(static_cast<int>(transfer));
    RunSetup setup = setup_of({{held_in_all_ways()}});
    setup.gravity = kTilted;
    setup.shells[0].transfer.kind = transfer, setup.shells[0].transfer.spacing = 0.025;
    setup.bodies = {ball(Vec3(-0.09, 0.02, 0.0225))};  // touches clamped control points too
    setup.laws = {{0, 0, 0.4, 0.0}};
    Rig rig(std::move(setup));
    ShellState& s = rig.state();
    s.motion.support_impulse.assign(s.motion.v.size(), 0.0);
    const Vec3 before = totals(rig.model(), s).momentum;
    const Proxy start = rig.body();
    for (int k = 0; k < kSteps; ++k) rig.step(kStep);
    const Proxy& b = rig.body();
    ASSERT_GT(b.impulse_sum, 0.1);
    Vec3 borne = Vec3::Zero();
    double scale = b.impulse_sum;
    for (const Constraints::Part& part : rig.model().constraints.parts)
      borne += support_impulse(s, part), scale += support_impulse(s, part).norm();
    const double time = kSteps * kStep;
    const Vec3 given = time * (0.2 * kPull + weighed(rig.model()) * kTilted) + borne;
    const Vec3 to_ball = b.body.mass * (b.body.motion.velocity - start.body.motion.velocity - time * kTilted);
    // round-off of some 1e5 forces of up to 1e5 N
    EXPECT_LT((totals(rig.model(), s).momentum - before + to_ball - given).norm(), 1e-10 * scale);
    EXPECT_GT(borne.norm(), 1e-2);
  }
}

// Both panes are clamped at the edges that meet their seam, so that the seam has held and free control points.
TEST(SupportImpulse, ClosesTheBalanceOfMomentumOverASeam) {
  Support clamp;
  clamp.edges = kVMin;
  Stitched s({make_shell("a", flat(-0.1, 0.0, 0.0, 0.1, 5, 5), 0.004, glass(), 2, 2, {clamp}),
              make_shell("b", flat(0.0, 0.1, 0.0, 0.1, 4, 4), 0.004, glass(), 2, 2, {clamp})});
  s.now().bodies.emplace_back(ball(Vec3(0.003, 0.03, 0.0225)));
  for (std::size_t k : {0u, 1u}) {
    s.now().shells[k].coefficients.assign(1, {0.3, 0.0, 0.0});
    s.state(k).motion.support_impulse.assign(s.state(k).motion.v.size(), 0.0);
  }
  const Vec3 before = s.sums().momentum;
  const Vec3 thrown = s.body().body.motion.velocity;
  for (int k = 0; k < kSteps; ++k) s.step(kStep);
  ASSERT_GT(s.body().impulse_sum, 0.1);
  Vec3 borne = Vec3::Zero();
  for (std::size_t k : {0u, 1u})
    for (const Constraints::Part& part : s.model(k).constraints.parts) borne += support_impulse(s.state(k), part);
  const Vec3 to_ball = s.body().body.mass * (s.body().body.motion.velocity - thrown);
  EXPECT_LT((s.sums().momentum - before + to_ball - borne).norm(), 1e-10 * s.body().impulse_sum);
  EXPECT_GT(borne.norm(), 1e-2);
}

// Lever rule: a force at a quarter of the span rests on the near support by three quarters. In equilibrium the impulse
// is the force times the time.
TEST(SupportImpulse, OfEachEdgeIsItsReactionTimesTheTime) {
  Support left, right;
  left.edges = kUMin, left.clamped = false;
  right.edges = kUMax, right.clamped = false, right.axes = {false, true, true};
  Load load;
  load.kind = Load::Kind::kPoint, load.point = Vec2(0.25, 0.1), load.force = Vec3(0, 0, -8.0);
  Rig rig(setup_of({{strip({left, right}, {load})}}));
  ShellState& s = rig.state();
  const ShellModel& m = rig.model();
  RelaxationRules rules;
  rules.tolerance = 1e-10;
  ASSERT_TRUE(relax(m, s, rules).converged);
  ASSERT_EQ(m.constraints.parts.size(), 2u);
  EXPECT_EQ(m.constraints.parts[0].name, "support_0_u_min");
  EXPECT_EQ(m.constraints.parts[1].name, "support_1_u_max");
  s.motion.support_impulse.assign(s.motion.v.size(), 0.0);
  for (int k = 0; k < 100; ++k) rig.step(kStep);
  for (const int k : {0, 1}) {
    const Constraints::Part& part = m.constraints.parts[k];
    const double share = k == 0 ? 6.0 : 2.0;
    // the strip bends by 1e-4 of its length, and its lever with it
    EXPECT_NEAR(reaction(m, s, Vec3::Zero(), part).z(), share, 1e-6 * 8.0);
    EXPECT_NEAR(support_impulse(s, part).z(), share * 100 * kStep, 1e-6 * 8.0 * 100 * kStep);
  }
}
