// Bodies against a shell: Hertz contact.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Proxy solid_ball(double radius, double density, const Vec3& at, const Vec3& velocity) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = density * 4.0 / 3.0 * 3.14159265358979 * std::pow(radius, 3);
  b.principal_inertia = Vec3::Constant(0.4 * b.mass * radius * radius);
  b.shape = SphereShape{radius};
  b.motion.position = at, b.motion.velocity = velocity;
  return Proxy(b);
}

struct Bounce {
  double restitution, residual, push, stored;  // residual of all energy over the ball's; N s
};

Bounce bounce(const ShellModel& m, const Vec3& at, double stiffness, double safety, double radius = 0.01) {
  constexpr double kSpeed = 0.5;
  RunSetup setup = setup_of({{m}});
  setup.bodies = {solid_ball(radius, 7800, at, Vec3(0, 0, -kSpeed)).body};
  setup.shells[0].hertz = {stiffness};
  Rig rig(std::move(setup));
  ShellState& s = rig.state();
  std::vector<Proxy>& bodies = rig.now().bodies;
  const ShellPart& part = rig.now().shells[0];
  const double own = stable_step(m, s, 150, 1, false);
  const double dt = hertz_step(m, bodies[0].body, stiffness, kSpeed, safety * own);
  const double start = 0.5 * bodies[0].body.mass * kSpeed * kSpeed;
  Bounce out{};
  bool met = false;
  for (int k = 0; k < 200000; ++k) {
    rig.step(dt);
    const double stored = hertz_energy(m, s, bodies, part.coefficients, part.candidates, 0.0);
    const bool touching = stored > 0.0;
    out.stored = std::max(out.stored, stored);
    met = met || touching;
    if (met && !touching) break;
  }
  const double elastic = compute_forces(m, s, true, 0.0, 1);
  out.restitution = bodies[0].body.motion.velocity.z() / kSpeed;
  out.residual = (elastic + kinetic_energy(m, s, dt) + bodies[0].body.kinetic_energy() +
                  hertz_energy(m, s, bodies, part.coefficients, part.candidates, dt) - start) /
                 start;
  EXPECT_EQ(s.book.contact, 0.0);  // nothing is lost
  out.push = (bodies[0].linear_impulse + bodies[0].shell_linear).norm() / bodies[0].impulse_sum;
  return out;
}

}  // namespace

// A clamped block of a plate gives way so little that the ball comes back as it went.
TEST(HertzContact, OnWhatDoesNotGiveWayReturnsTheSpeed) {
  Support all;
  all.edges = kUMin | kUMax | kVMin | kVMax;
  ShellMaterial heavy = glass();
  heavy.density = 2.5e6, heavy.youngs_modulus = 7e13;
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 10, 10, Vec3::Zero(), Quat::Identity()), 0.02, heavy, 2, 2, {all});
  const Bounce b = bounce(m, Vec3(0.003, 0.001, 0.0201), 1e9, 0.5);
  EXPECT_NEAR(b.restitution, 1.0, 1e-3);
  EXPECT_NEAR(b.residual, 0.0, 1e-4);
  EXPECT_LT(b.push, 1e-13);
  // at the deepest all of the ball's energy is stored
  EXPECT_NEAR(b.stored, 0.5 * 7800 * 4.0 / 3.0 * 3.14159265 * 1e-6 * 0.25, 1e-3 * b.stored);
}

TEST(HertzContact, KeepsTheEnergyOfBallAndPlateWhereverItStrikes) {
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  double middle = 0.0;
  for (const double x : {0.0, 0.0021, 0.005, 0.0077}) {  // over a Gauss point, a knot line, between
    const Bounce b = bounce(m, Vec3(x, 0.003, 0.0121), 1e9, 0.5);
    EXPECT_NEAR(b.residual, 0.0, 2e-3) << x;
    EXPECT_LT(b.push, 1e-13);
    if (middle == 0.0) middle = b.restitution;
    // the grid must not be felt; as it is, mass lies at control points a spacing apart
    EXPECT_NEAR(b.restitution, middle, 0.05) << x;
  }
}

// Spheres down to the least that a scene may have: half a spacing in radius, between the samples, on thin shells.
TEST(HertzContact, FindsSmallSpheresBetweenTheSamples) {
  for (const double thickness : {0.001, 0.002, 0.004})
    for (const double x : {0.0, 0.0025, 0.005}) {
      const ShellModel m =
          make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), thickness, glass(), 2, 2, {});
      const Bounce b = bounce(m, Vec3(x, x, 0.0051 + 0.5 * thickness), 1e9, 0.5, 0.005);
      EXPECT_NEAR(b.residual, 0.0, 2e-3) << thickness << " " << x;
      EXPECT_LT(b.restitution, 1.0);
      EXPECT_GT(b.stored, 0.0);
    }
}

TEST(HertzContact, StopsWhereTheSphereSinksIn) {
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  EXPECT_THROW(bounce(m, Vec3(0, 0, 0.0121), 1e4, 0.5), Error);
}

TEST(HertzContact, DoesNotReachAcrossACrack) {
  const ShellModel m =
      make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 1);
  insert_polyline(m, s, {{0.1, 0.0}, {0.1, 0.2}}, 0.0);
  for (int i = 0; i < m.control_points(); ++i)  // the half at x > 0 is drawn away
    if (m.parameter[i].x() > 0.1) s.motion.x[m.tables.slot(i)] += 0.05;
  std::vector<Proxy> bodies{solid_ball(0.01, 7800, Vec3(0.0045, 0.003, 0.0119), Vec3::Zero())};
  const std::vector<ContactCoefficients> coefficients{{0.5, 0.0, 1e9}};
  ContactCandidates candidates;
  refresh_candidates(m, s, bodies, coefficients, 1e-7, candidates);
  // over the gap, 4.5 mm off the edge: 1 mm deeper than the edge's own distance allows
  EXPECT_EQ(hertz_energy(m, s, bodies, coefficients, candidates, 0.0), 0.0);
  bodies[0].body.motion.position.x() = -0.0045;  // over the half that stays
  refresh_candidates(m, s, bodies, coefficients, 1e-7, candidates);
  EXPECT_GT(hertz_energy(m, s, bodies, coefficients, candidates, 0.0), 0.0);
}

TEST(HertzContact, ApproachIsThatOfTheEnergy) {
  const double d = hertz_approach(0.3, 1e9, 2.0);
  EXPECT_NEAR(0.4 * 1e9 * std::pow(d, 2.5), 0.5 * 0.3 * 4.0, 1e-12);
}
