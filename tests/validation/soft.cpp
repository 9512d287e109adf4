// Soft bodies of particles against exact results, over the spacing of particles.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tests/shell/soft_blocks.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::soft_blocks;

// Adds the orders of convergence from each spacing to half of it.
void orders(Report& report, const std::string& name, const std::vector<double>& spacings,
            const std::vector<double>& errors) {
  std::string line = name + ": order";
  for (std::size_t i = 1; i < errors.size(); ++i)
    line += fmt::format(" {:.2f}", std::log(errors[i - 1] / errors[i]) / std::log(spacings[i - 1] / spacings[i]));
  report.lines.push_back(line + " from spacing to spacing");
  report.curves.push_back({name, "spacing of the particles [m]", "error", spacings, errors});
}

// First mode of a bar that cannot widen.
void wave(Report& report) {
  std::vector<double> spacings{0.02, 0.01, 0.005}, errors;
  for (const double spacing : spacings) {
    const double start = seconds_now();
    double left = 0.0;
    const double speed = wave_speed(spacing, &left);
    errors.push_back(std::abs(speed - 1.0));
    report.add(fmt::format("wave_{:g}_mm", 1e3 * spacing), speed, 1.0, 0.05 * spacing / 0.02, seconds_now() - start);
    report.lines.push_back(
        fmt::format("spacing {} m: {:.3f} of the amplitude left after half a period", spacing, left));
  }
  orders(report, "wave", spacings, errors);
}

// A bar without lateral contraction leaves a wall at its speed of approach, without vibration.
void bounce(Report& report) {
  const double length = 0.2, speed = 0.5;
  std::vector<double> spacings{0.02, 0.01, 0.005}, errors;
  for (const double spacing : spacings) {
    const double start = seconds_now();
    SoftBodies soft({block({0.02, 0.02, 0.5 * length}, at({0, 0, 0.5 * length + 0.001}), spacing, {0, 0, -speed},
                           Vec3::Zero(), rubber(1e6, 0.0))},
                    0, laws(0.0));
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
    report.add("bounce_energy" + name, books(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, 0.0);
    report.lines.push_back(fmt::format("spacing {} m: of its energy contact took {:.3f}, transfers {:.3f}", spacing,
                                       soft.book().contact / before.kinetic, soft.book().transfer / before.kinetic));
  }
  orders(report, "bounce", spacings, errors);
}

// A rubber ball falls on the floor; the result is its rebound height over the height of the fall.
void drop(Report& report) {
  const Vec3 gravity(0, 0, -9.81);
  const double radius = 0.04, fall = 0.1;
  std::vector<double> heights;
  for (const double spacing : {0.01, 0.0067, 0.005}) {
    const double start = seconds_now();
    SoftBodies soft(
        {{make_soft("ball", rubber(1e6, 0.45), SphereShape{radius}, at({0, 0, radius + fall}), spacing, 2.0 * spacing),
          Vec3::Zero(), Vec3::Zero()}},
        0, laws(0.5));
    std::vector<Proxy> bodies = ground();
    const double dt = 0.8 * soft.stable_step(), scale = soft.sums(gravity).mass * 9.81 * fall;
    const double first = books(soft, gravity);
    double highest = 0.0, worst = 0.0;
    for (double t = 0.0; t < 0.32; t += dt) {
      soft.step(gravity, dt, 0.8, bodies);
      worst = std::max(worst, std::abs(books(soft, gravity) - first));
      if (t > 0.18) highest = std::max(highest, soft.sums(gravity).centre.z() - radius);
    }
    const std::string name = fmt::format("_{:g}_mm", 1e3 * spacing);
    report.add("drop_energy" + name, worst / scale, 0.0, 5e-3, seconds_now() - start);
    // The rebound energy is the one that contact and the grid have not taken, except for vibration.
    const double left = 1.0 - (soft.book().contact + soft.book().transfer) / scale;
    report.add("drop_height" + name, highest / fall, left, 0.01, 0.0);
    heights.push_back(highest / fall);
    report.lines.push_back(fmt::format("spacing {} m: contact took {:.3f} of the drop's energy, transfers {:.3f}",
                                       spacing, soft.book().contact / scale, soft.book().transfer / scale));
  }
  const bool higher = heights[0] < heights[1] && heights[1] < heights[2];
  report.add("drop_height_rises", higher ? 1.0 : 0.0, 1.0, 0.0, 0.0);
}

// A block stands on the floor without friction; the sinking of its middle is compared with rho g h^2 / 3E.
void stand(Report& report) {
  for (const double spacing : {0.02, 0.01}) {
    const double start = seconds_now();
    report.add(fmt::format("sag_{:g}_mm", 1e3 * spacing), sag(spacing), 1.0, 0.03, seconds_now() - start);
  }
}

// Two blocks collide off their centres; momentum and angular momentum must be conserved.
void soft_collision(Report& report) {
  const double start = seconds_now();
  SoftSetup low = block({0.04, 0.04, 0.02}, at({0, 0, 0}), 0.01, {0.3, 0, 1}, {0, 3, 0});
  SoftSetup high = block({0.03, 0.03, 0.03}, at({0.02, 0.01, 0.052}), 0.0075, {0, 0, -2}, {5, 0, 0});
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
  report.add("collision_energy", books(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, 0.0);
}

// A free block spins.
void spin(Report& report) {
  const double start = seconds_now();
  SoftBodies soft({block({0.05, 0.03, 0.02}, at({0.2, 0.1, 0}), 0.01, {1, 0, 0.5}, {30, 10, 60})}, 0, laws(0.0));
  std::vector<Proxy> nobody;
  const double dt = 0.8 * soft.stable_step();
  const SoftSums before = soft.sums(Vec3::Zero());
  int steps = 0;
  for (double t = 0.0; t < 0.2; t += dt) soft.step(Vec3::Zero(), dt, 0.8, nobody), ++steps;
  const SoftSums after = soft.sums(Vec3::Zero());
  report.add("spin_angular", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12, 0.0);
  report.add("spin_energy", books(soft, Vec3::Zero()) / before.kinetic, 1.0, 5e-3, seconds_now() - start);
  report.lines.push_back(
      fmt::format("{:.4f} of its energy left after {} steps, 2 turns", after.kinetic / before.kinetic, steps));
}

}  // namespace

std::vector<Case> soft_cases() {
  const auto plain = [](void (*f)(Report&)) { return [f](Report& r, int) { f(r); }; };
  return {
      {"wave", "first mode along a bar that cannot widen: speed over sqrt((lambda + 2 mu) / rho)", plain(wave)},
      {"bounce", "a bar against a wall: speed after over speed before, momentum, energy with its book", plain(bounce)},
      {"drop", "a ball falls on the floor: energy with its book, height of what is left of it", plain(drop)},
      {"sag", "a block under its weight: its middle over rho g h^2 / 3E", plain(stand)},
      {"collision", "two blocks: momentum, angular momentum, energy with its book", plain(soft_collision)},
      {"spin", "a spinning block: angular momentum, energy with its book", plain(spin)}};
}

}  // namespace sunder::validation
