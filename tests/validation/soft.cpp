// Soft bodies of particles against exact answers, over the spacing of their particles.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/soft/soft_bodies.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

SoftMaterial rubber(double young, double poisson) { return {1000.0, young, poisson}; }

SoftSetup body(const Shape& shape, double volume, const Vec3& at, double spacing, const SoftMaterial& material,
               const Vec3& velocity = Vec3::Zero(), const Vec3& angular = Vec3::Zero()) {
  BodyMotion pose;
  pose.position = at;
  return {make_soft("body", material, shape, pose, spacing, 2.0 * spacing, volume), velocity, angular};
}
SoftSetup block(const Vec3& half, const Vec3& at, double spacing, const SoftMaterial& material,
                const Vec3& velocity = Vec3::Zero(), const Vec3& angular = Vec3::Zero()) {
  return body(BoxShape{half}, 8.0 * half.prod(), at, spacing, material, velocity, angular);
}

std::vector<ContactLaw> laws(double friction) {
  return {{0, 0, friction, 0.0}, {0, 1, friction, 0.0}, {1, 1, friction, 0.0}};
}
std::vector<Proxy> ground() {
  RigidBody b;
  b.id = 1, b.name = "floor", b.is_static = true, b.shape = HalfSpaceShape{}, b.contact_group = 1;
  return {Proxy(b)};
}
double whole(const SoftBodies& s, const Vec3& gravity) {
  const SoftSums sums = s.sums(gravity);
  return sums.kinetic + sums.elastic + sums.potential + s.book().lost();
}

// Order by which errors fall from one spacing to the next, half of it.
void orders(Report& report, const std::string& name, const std::vector<double>& spacings,
            const std::vector<double>& errors) {
  std::string line = name + ": order";
  for (std::size_t i = 1; i < errors.size(); ++i)
    line += fmt::format(" {:.2f}", std::log(errors[i - 1] / errors[i]) / std::log(spacings[i - 1] / spacings[i]));
  report.lines.push_back(line + " from spacing to spacing");
  report.curves.push_back({name, "spacing of the particles [m]", "error", spacings, errors});
}

// The first mode along a bar that cannot widen.
void wave(Report& report) {
  const double length = 0.4;
  std::vector<double> spacings{0.02, 0.01, 0.005}, errors;
  for (const double spacing : spacings) {
    const double start = seconds_now();
    const SoftSetup b = block({0.5 * length, 0.02, 0.02}, {0.201, 0.003, 0.004}, spacing, rubber(1e6, 0.3));
    const SoftModel& m = b.model;
    SoftState s = make_soft_state(m, Vec3::Zero(), Vec3::Zero());
    const double c = m.material.wave_speed(), k = std::numbers::pi / length, dt = 0.8 * soft_stable_step(m, s);
    const auto phase = [&](std::size_t p) { return k * (m.rest[p].x() - 0.001); };
    for (std::size_t p = 0; p < s.x.size(); ++p) {
      s.v[p].x() = 1e-3 * c * std::cos(phase(p));
      s.affine[p](0, 0) = -1e-3 * c * k * std::sin(phase(p));
    }
    double time = 0.0, last = 0.0, crossed = 0.0, first = 0.0, least = 0.0;
    for (int crossings = 0; crossings < 3;) {
      to_grid(m, s, Vec3::Zero(), dt, 1);
      for (Vec3& v : s.grid.v) v.y() = v.z() = 0.0;
      from_grid(m, s, dt, 1);
      double now = 0.0;
      for (std::size_t p = 0; p < s.x.size(); ++p) now += m.mass[p] * s.v[p].x() * std::cos(phase(p));
      if (now * last < 0.0) crossed = time - 0.5 * dt + dt * last / (last - now), ++crossings;
      if (first == 0.0) first = now;
      least = std::min(least, now / first);
      last = now, time += dt;
    }
    const double speed = 2.5 * length / crossed / c;
    errors.push_back(std::abs(speed - 1.0));
    report.add(fmt::format("wave_{:g}_mm", 1e3 * spacing), speed, 1.0, 0.05 * spacing / 0.02, seconds_now() - start);
    report.lines.push_back(
        fmt::format("spacing {} m: {:.3f} of the amplitude left after half a period", spacing, -least));
  }
  orders(report, "wave", spacings, errors);
}

// A bar without lateral contraction leaves a wall as fast as it came, and without vibration.
void bounce(Report& report) {
  const double length = 0.2, speed = 0.5;
  std::vector<double> spacings{0.02, 0.01, 0.005}, errors;
  for (const double spacing : spacings) {
    const double start = seconds_now();
    SoftBodies soft(
        {block({0.02, 0.02, 0.5 * length}, {0, 0, 0.5 * length + 0.001}, spacing, rubber(1e6, 0.0), {0, 0, -speed})}, 0,
        laws(0.0));
    std::vector<Proxy> bodies = ground();
    const double c = soft.models()[0].material.wave_speed(), dt = 0.8 * soft.stable_step();
    const SoftSums before = soft.sums(Vec3::Zero());
    for (double t = 0.0; t < 0.001 / speed + 3.0 * length / c; t += dt) soft.step(Vec3::Zero(), dt, 0.8, bodies);
    const SoftSums after = soft.sums(Vec3::Zero());
    const double rebound = after.momentum.z() / -before.momentum.z();
    errors.push_back(1.0 - rebound);
    const std::string name = fmt::format("_{:g}_mm", 1e3 * spacing);
    report.add("bounce_rebound" + name, rebound, 1.0, 0.25 * spacing / 0.02 + 0.02, seconds_now() - start);
    report.add("bounce_momentum" + name,
               (after.momentum - before.momentum + bodies[0].linear_impulse).norm() / before.momentum_scale, 0.0, 1e-12,
               0.0);
    report.add("bounce_energy" + name, whole(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, 0.0);
    report.lines.push_back(fmt::format("spacing {} m: of its energy contact took {:.3f}, transfers {:.3f}", spacing,
                                       soft.book().contact / before.kinetic, soft.book().transfer / before.kinetic));
  }
  orders(report, "bounce", spacings, errors);
}

// A ball of rubber falls on the floor: how high it comes back, of the drop.
void drop(Report& report) {
  const Vec3 gravity(0, 0, -9.81);
  const double radius = 0.04, fall = 0.1;
  for (const double spacing : {0.01, 0.0067, 0.005}) {
    const double start = seconds_now();
    SoftBodies soft({body(SphereShape{radius}, 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3),
                          {0, 0, radius + fall}, spacing, rubber(1e6, 0.45))},
                    0, laws(0.5));
    std::vector<Proxy> bodies = ground();
    const double dt = 0.8 * soft.stable_step(), scale = soft.sums(gravity).mass * 9.81 * fall;
    const double first = whole(soft, gravity);
    double highest = 0.0, worst = 0.0;
    for (double t = 0.0; t < 0.32; t += dt) {
      soft.step(gravity, dt, 0.8, bodies);
      worst = std::max(worst, std::abs(whole(soft, gravity) - first));
      if (t > 0.18) highest = std::max(highest, soft.sums(gravity).centre.z() - radius);
    }
    const std::string name = fmt::format("_{:g}_mm", 1e3 * spacing);
    report.add("drop_energy" + name, worst / scale, 0.0, 5e-3, seconds_now() - start);
    report.lines.push_back(
        fmt::format("spacing {} m: back to {:.3f} of the drop; contact took {:.3f}, transfers {:.3f}", spacing,
                    highest / fall, soft.book().contact / scale, soft.book().transfer / scale));
  }
}

// A block stands on the floor without friction: how far its middle sinks, of rho g h^2 / 3E.
void sag(Report& report) {
  const double height = 0.1, young = 2e5;
  const Vec3 gravity(0, 0, -9.81);
  for (const double spacing : {0.02, 0.01}) {
    const double start = seconds_now();
    SoftBodies soft({block({0.02, 0.02, 0.5 * height}, {0, 0, 0.5 * height}, spacing, rubber(young, 0.3))}, {},
                    laws(0.0));
    std::vector<Proxy> bodies = ground();
    double last = 0.0;
    const double dt = 0.8 * soft.stable_step();
    for (double t = 0.0; t < 0.6; t += dt) {
      soft.step(gravity, dt, 0.8, bodies);
      const double now = soft.sums(gravity).kinetic;
      if (now < last) {  // let go of the motion where it is fastest
        for (Vec3& v : soft.states()[0].v) v.setZero();
        for (Mat3& a : soft.states()[0].affine) a.setZero();
        last = 0.0;
      } else {
        last = now;
      }
    }
    report.add(fmt::format("sag_{:g}_mm", 1e3 * spacing),
               (0.5 * height - soft.sums(gravity).centre.z()) / (1000 * 9.81 * height * height / (3 * young)), 1.0,
               0.03, seconds_now() - start);
  }
}

// Two blocks that meet off their middles: what both keep.
void collision(Report& report) {
  const double start = seconds_now();
  SoftSetup low = block({0.04, 0.04, 0.02}, {0, 0, 0}, 0.01, rubber(1e6, 0.3), {0.3, 0, 1}, {0, 3, 0});
  SoftSetup high = block({0.03, 0.03, 0.03}, {0.02, 0.01, 0.052}, 0.0075, rubber(1e6, 0.3), {0, 0, -2}, {5, 0, 0});
  high.model.contact_group = 1;
  SoftBodies soft({low, high}, 0, laws(0.4));
  std::vector<Proxy> nobody;
  const double dt = 0.8 * soft.stable_step();
  const SoftSums before = soft.sums(Vec3::Zero());
  for (int k = 0; k < 200; ++k) soft.step(Vec3::Zero(), dt, 0.8, nobody);
  const SoftSums after = soft.sums(Vec3::Zero());
  report.add("collision_momentum", (after.momentum - before.momentum).norm() / before.momentum_scale, 0.0, 1e-12,
             seconds_now() - start);
  report.add("collision_angular", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12, 0.0);
  report.add("collision_energy", whole(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, 0.0);
}

// A free block that spins.
void spin(Report& report) {
  const double start = seconds_now();
  SoftBodies soft({block({0.05, 0.03, 0.02}, {0.2, 0.1, 0}, 0.01, rubber(1e6, 0.3), {1, 0, 0.5}, {30, 10, 60})}, {},
                  laws(0.0));
  std::vector<Proxy> nobody;
  const double dt = 0.8 * soft.stable_step();
  const SoftSums before = soft.sums(Vec3::Zero());
  int steps = 0;
  for (double t = 0.0; t < 0.2; t += dt) soft.step(Vec3::Zero(), dt, 0.8, nobody), ++steps;
  const SoftSums after = soft.sums(Vec3::Zero());
  report.add("spin_angular", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12, 0.0);
  report.add("spin_energy", whole(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, seconds_now() - start);
  report.lines.push_back(
      fmt::format("{:.4f} of its energy left after {} steps, 2 turns", after.kinetic / before.kinetic, steps));
}

}  // namespace

std::vector<Case> soft_cases() {
  const auto plain = [](void (*f)(Report&)) { return [f](Report& r, int) { f(r); }; };
  return {
      {"wave", "first mode along a bar that cannot widen: speed over sqrt((lambda + 2 mu) / rho)", plain(wave)},
      {"bounce", "a bar against a wall: speed after over speed before, momentum, energy with its book", plain(bounce)},
      {"drop", "a ball falls on the floor: energy with its book", plain(drop)},
      {"sag", "a block under its weight: its middle over rho g h^2 / 3E", plain(sag)},
      {"collision", "two blocks: momentum, angular momentum, energy with its book", plain(collision)},
      {"spin", "a spinning block: angular momentum, energy with its book", plain(spin)}};
}

}  // namespace sunder::validation
