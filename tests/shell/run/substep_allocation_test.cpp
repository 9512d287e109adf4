// A substep allocates nothing: this program counts.
#include <atomic>
#include <cstdlib>
#include <new>
#include <utility>

#include <gtest/gtest.h>

#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

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
long allocated(Rig& rig) {
  constexpr int kSteps = 20 * kContactRefresh;
  long before = 0;
  for (int k = 0; k < kSteps; ++k) {
    if (k == kSteps / 2) before = allocations;
    rig.step(2e-7);
  }
  const long after = allocations;
  EXPECT_GT(rig.body().impulse_sum, 0.0);
  return after - before;
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
  RigidBody ball;
  ball.id = 1, ball.name = "ball", ball.mass = 0.1, ball.principal_inertia = Vec3::Constant(1e-5);
  ball.shape = SphereShape{0.02}, ball.motion.position = Vec3(0.003, 0.001, 0.0216);
  ball.motion.velocity = Vec3(0, 0, -0.5);
  for (const ShellMaterial& g : {glass(), tough, ductile, viscous})
    for (const double hertz : {0.0, 1e9})
      for (const Transfer kind : {Transfer::kDirect, Transfer::kFlip, Transfer::kApic}) {
        RunSetup setup = setup_of({{make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, g,
                                               3, 2, {edges}, {pressure})}});
        ShellSetup& shell = setup.shells[0];
        shell.hertz = {hertz}, shell.transfer = {kind, shell.model.spacing, false};
        if (g.strength > 0.0) {
          shell.fracture.mode = FractureMode::kDamage;
          shell.fracture.damage.brittleness = 0.4, shell.fracture.damage.heals = hertz == 0.0;
        }
        setup.gravity = Vec3(0, 0, -9.81);
        setup.bodies = {ball};
        Rig rig(std::move(setup));
        const ShellModel& m = rig.model();
        ShellState& s = rig.state();
        if (g.yield_stress == 0.0) insert_polyline(m, s, {{0.0, 0.071}, {0.083, 0.093}}, 0.0);
        if (g.strength > 0.0) {
          s.cracked.damage.resize(s.cracked.gathered.size());
          for (int lane = 0; lane < 20; ++lane) watch_point(m, s, 40, lane);
        }
        EXPECT_EQ(allocated(rig), 0) << g.strength << " " << g.yield_stress << " " << hertz << " "
                                     << static_cast<int>(kind);
      }
}
