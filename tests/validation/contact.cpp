// Contact between shells: exact results, and the error of the grid.
#include <cmath>

#include <fmt/format.h>

#include "shell/solver/contact/shell_contact.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

struct Pair : Rig {
  const ShellModel &low, &high;
  ShellState &a, &b;

  Pair(ShellModel l, ShellModel h, const SurfaceLaw& law, const Vec3& velocity)
      : Rig(setup_of({{std::move(l)}, {std::move(h), velocity}})),
        low(model(0)),
        high(model(1)),
        a(state(0)),
        b(state(1)) {
    meet(law);
  }

  double length() { return 0.6 * std::min(stable_step(low, a, 80, 1, false), stable_step(high, b, 80, 1, false)); }
  void go(double time, double dt, const Vec3& gravity) {
    setup().gravity = gravity;
    run(static_cast<int>(std::lround(time / dt)), dt);
  }
};

ShellMaterial struck_material(double young, double damping = 0.0) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = young, m.poisson_ratio = 0.3, m.mass_damping = damping;
  return m;
}

struct Mean {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
};
Mean mean_motion(const ShellModel& m, const ShellState& s) {
  Mean out;
  double mass = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    mass += m.mass[slot], out.x += m.mass[slot] * s.position(slot), out.v += m.mass[slot] * s.velocity(slot);
  }
  out.x /= mass, out.v /= mass;
  return out;
}

// A plate lies on a clamped one, with their grids turned against each other. Gravity is inclined by `angle`.
void incline(Report& report) {
  constexpr double kFriction = 0.4, kGravity = 9.81, kTime = 0.3;
  Support clamp;
  clamp.edges = kUMin | kUMax | kVMin | kVMax;
  const double slides_at = std::atan(kFriction);
  for (const double share : {0.8, 0.95, 1.05, 1.3, 1.8}) {
    const double start = seconds_now(), angle = share * slides_at;
    const Quat turn(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
    Pair p(
        make_shell("slope", plate(1.6, 0.8, 32, 16, Vec3::Zero(), Quat::Identity()), 0.05, struck_material(1e9, 200.0),
                   2, 2, {clamp}),
        make_shell("block", plate(0.3, 0.3, 8, 8, Vec3(-0.3, 0.0, 0.0500), turn), 0.05, struck_material(1e9), 2, 2, {}),
        {kFriction, 0.0}, Vec3::Zero());
    const double dt = p.length();
    const Vec3 gravity = kGravity * Vec3(std::sin(angle), 0.0, -std::cos(angle));
    p.go(0.1, dt, gravity);  // until what it has set in motion has passed
    const Vec3 before = mean_motion(p.high, p.b).v;
    p.go(kTime, dt, gravity);
    const double found = (mean_motion(p.high, p.b).v.x() - before.x()) / kTime;
    const double exact = share < 1.0 ? 0.0 : kGravity * (std::sin(angle) - kFriction * std::cos(angle));
    // Holding force, as a share of gravity along the slope.
    report.add(fmt::format("incline_{:.2f}", share), found / (kGravity * std::sin(angle)),
               exact / (kGravity * std::sin(angle)), share < 1.0 ? 0.002 : 0.005, seconds_now() - start);
  }
}

void pressed(Report& report) {
  const double start = seconds_now();
  Support hinge;
  hinge.edges = kUMin | kUMax | kVMin | kVMax, hinge.clamped = false;
  constexpr double kThickness = 0.004;
  for (const double pressure : {1e2, 1e3, 1e4}) {
    Load load;
    load.kind = Load::Kind::kPressure, load.size = -pressure;
    Pair p(make_shell("low", plate(0.5, 0.5, 20, 20, Vec3::Zero(), Quat::Identity()), kThickness,
                      struck_material(1e10, 400.0), 2, 2, {hinge}),
           make_shell("high", plate(0.4, 0.4, 16, 16, Vec3(0.013, 0.007, 0.0045), Quat::Identity()), kThickness,
                      struck_material(1e10, 400.0), 2, 2, {}, {load}),
           {}, Vec3::Zero());
    p.go(0.05, p.length(), Vec3::Zero());
    // distance of both middles, over the thickness
    const auto middle = [](const ShellModel& m, const ShellState& s, const Vec2& at) {
      Vec3 x = Vec3::Zero();
      for (const GatheredFunction& f : patch_functions(m.patch, at, m.tables.stride)) x += f.n[0] * s.position(f.slot);
      return x;
    };
    const Vec3 high = middle(p.high, p.b, {0.2, 0.2});
    const Vec3 low = middle(p.low, p.a, {0.25 + high.x(), 0.25 + high.y()});
    report.add(fmt::format("pressed_gap_{:.0e}_pa", pressure), (high.z() - low.z()) / kThickness, 1.0, 0.05,
               seconds_now() - start);
  }
}

void ball_collision(Report& report) {
  const double start = seconds_now();
  for (const double restitution : {0.0, 1.0}) {
    Pair p(
        make_shell("low", plate(0.5, 0.5, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, struck_material(1e8), 2, 2,
                   {}),
        make_shell("high", plate(0.4, 0.4, 14, 14, Vec3(0.1, 0.05, 0.008), Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()))),
                   0.004, struck_material(1e8), 2, 2, {}),
        {0.3, restitution}, Vec3(1, 0, -5));
    const auto totals_now = [&] {
      Totals t = totals(p.low, p.a);
      t += totals(p.high, p.b);
      return t;
    };
    const double dt = p.length();
    const auto energy = [&] {
      double sum = 0.0;
      for (const ShellRef& r : p.refs())
        sum += compute_forces(*r.model, *r.state, true, 0.0, 1) + kinetic_energy(*r.model, *r.state, dt) +
               r.state->book.contact;
      return sum;
    };
    const Totals before = totals_now();
    const double stored = energy();
    p.go(0.02, dt, Vec3::Zero());
    const Totals after = totals_now();
    const std::string name = restitution == 0.0 ? "inelastic" : "elastic";
    report.add("momentum_" + name, (after.momentum - before.momentum).norm() / before.momentum_scale, 0.0, 1e-12,
               seconds_now() - start);
    report.add("angular_momentum_" + name, (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12,
               0.0);
    report.add("energy_" + name, energy() / stored, 1.0, 2e-3, 0.0);
  }
}

}  // namespace

std::vector<Case> contact_cases() {
  return {{"incline", "a plate on a slope: share of gravity's pull that friction leaves (Coulomb)",
           [](Report& r, int) { incline(r); }},
          {"pressed", "two plates pressed together: distance of their middles over the thickness",
           [](Report& r, int) { pressed(r); }},
          {"collision", "free plates that collide: momentum, angular momentum, energy with its book",
           [](Report& r, int) { ball_collision(r); }}};
}

}  // namespace sunder::validation
