// A substep allocates nothing: this program counts.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "shell/solver/contact/hertz.h"
#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/grid_transfer.h"
#include "shell/solver/stepping/kick_drift.h"
#include "tests/shell/fixtures.h"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t align) {
  ++allocations;
  const auto a = static_cast<std::size_t>(align);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

using namespace sunder;
using namespace sunder::shell;

namespace {

// Substeps with a ball that presses on the shell; returns allocations of the second half.
long allocated(const ShellModel& m, ShellState& s, double hertz, Transfer kind) {
  RigidBody ball;
  ball.id = 1, ball.name = "ball", ball.mass = 0.1, ball.principal_inertia = Vec3::Constant(1e-5);
  ball.shape = SphereShape{0.02}, ball.motion.position = Vec3(0.003, 0.001, 0.0216);
  ball.motion.velocity = Vec3(0, 0, -0.5);
  std::vector<Proxy> bodies{Proxy(ball)};
  const std::vector<ContactCoefficients> coefficients{{0.5, 0.0, hertz}};
  ContactCandidates candidates;
  const TransferRules rules{kind, m.spacing, false};
  if (kind != Transfer::kDirect) s.motion.before = s.motion.v;
  const double dt = 2e-7;
  long before = 0;
  int touched = 0;
  constexpr int kSteps = 20 * kContactRefresh;
  for (int k = 0; k < kSteps; ++k) {
    if (k == kSteps / 2) before = allocations;
    compute_forces(m, s, false, 1.0, 2);
    kick(m, s, Vec3(0, 0, -9.81), dt);
    if (k % kContactRefresh == 0) refresh_candidates(m, s, bodies, coefficients, dt, candidates), candidates.age = 0;
    ++candidates.age;
    touched += contact(m, s, bodies, coefficients, candidates, dt, dt);
    through_grid(m, s, rules, dt, 2);
    constrain(m, s, dt);
    drift(m, s, dt), bodies[0].body.drift(dt);
  }
  EXPECT_GT(touched, 0);
  return allocations - before;
}

}  // namespace

TEST(Substep, AllocatesNothing) {
  ShellMaterial tough = glass(), ductile = glass(), viscous = glass();
  tough.strength = 1e6, tough.fracture_energy = 1e6, ductile.yield_stress = 1e7;
  viscous.mass_damping = 1.0, viscous.stiffness_damping = 1e-8;
  Support edges;
  edges.edges = kUMin | kVMax, edges.clamped = false, edges.axes = {true, false, true};
  Load pressure;
  pressure.kind = Load::Kind::kPressure, pressure.size = 10.0;
  for (const ShellMaterial& g : {glass(), tough, ductile, viscous})
    for (const double hertz : {0.0, 1e9})
      for (const Transfer kind : {Transfer::kDirect, Transfer::kFlip, Transfer::kApic}) {
        const ShellModel m = make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, g, 3, 2,
                                        {edges}, {pressure});
        ShellState s = make_state(m, Vec3::Zero(), 1);
        if (g.yield_stress == 0.0) insert_polyline(m, s, {{0.0, 0.071}, {0.083, 0.093}}, 0.0);
        if (g.strength > 0.0) {
          s.layers.brittleness = 0.4, s.layers.heals = hertz == 0.0;
          s.cracked.damage.resize(s.cracked.gathered.size());
          for (int lane = 0; lane < 20; ++lane) watch_point(m, s, 40, lane);
        }
        EXPECT_EQ(allocated(m, s, hertz, kind), 0)
            << g.strength << " " << g.yield_stress << " " << hertz << " " << static_cast<int>(kind);
      }
}
