// What a shell opposes to a body that is pushed into it.
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/contact/contact_stiffness.h"
#include "shell/solver/forces.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RigidBody ball(const Vec3& at) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.2, b.principal_inertia = Vec3::Constant(3e-5), b.shape = SphereShape{0.02};
  b.motion.position = at;
  return b;
}

}  // namespace

// The second difference of the stored energy, all control points under the body moved together along its normal.
TEST(ContactStiffness, IsTheSecondDerivativeOfTheEnergy) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const std::vector<Proxy> bodies{Proxy(ball(Vec3(0.003, 0.002, 0.0218))), Proxy(ball(Vec3(0, 0, 1)))};
  ContactCandidates c;
  refresh_candidates(m, s, bodies, {{}, {}}, 1e-7, c);
  const std::vector<double> x = s.motion.x;
  const std::vector<double> k = contact_stiffness(m, s, bodies, c, {1, 1}, 1);
  EXPECT_EQ(s.motion.x, x);  // as it was
  EXPECT_EQ(k[1], 0.0);      // far away
  std::vector<char> moved(m.tables.component_stride, 0);
  Vec3 out = Vec3::Zero();
  std::vector<GatheredFunction> functions;
  for (const auto& sample : c.of_body[0]) {
    sample_functions(m, s, sample.block, sample.lane, functions);
    Vec3 at = Vec3::Zero();
    for (const auto& f : functions) at += f.n[0] * s.position(f.slot), moved[f.slot] = moved[f.slot] || f.n[0] >= 0.1;
    out += bodies[0].distance(at).normal;
  }
  out.normalize();
  const double step = 1e-4 * m.thickness;
  const auto energy = [&](double by) {
    for (int slot = 0; slot < m.tables.component_stride; ++slot)
      for (int d = 0; d < 3; ++d) {
        const std::size_t at = static_cast<std::size_t>(d) * m.tables.component_stride + slot;
        s.motion.x[at] = x[at] + (moved[slot] ? by * out[d] : 0.0);
      }
    return compute_forces(m, s, true, 0.0, 1);
  };
  const double second = (energy(step) - 2.0 * energy(0.0) + energy(-step)) / (step * step);
  EXPECT_GT(k[0], 0.0);
  EXPECT_NEAR(k[0], second, 1e-3 * second);  // differences of first order in a step of 1e-5 of the thickness
}

TEST(ContactStiffness, IsNoneOfBodiesThatAreNotAskedOrHaveNoCandidates) {
  const ShellModel m = brittle_sheet(10);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const std::vector<Proxy> bodies{Proxy(ball(Vec3(0, 0, 0.0218)))};
  ContactCandidates c;
  EXPECT_EQ(contact_stiffness(m, s, bodies, c, {1}, 1), std::vector<double>{0.0});
  refresh_candidates(m, s, bodies, {{}}, 1e-7, c);
  EXPECT_EQ(contact_stiffness(m, s, bodies, c, {0}, 1), std::vector<double>{0.0});
}
