#include "shell/io/check.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "shell/contact/proxy.h"
#include "shell/solver/hertz.h"

namespace sunder::shell {

std::string check_report(const scene::LoadedScene& scene, const RunSetup& setup) {
  std::string out = fmt::format("scene          {}\nbodies         {}\n", setup.name, setup.bodies.size());
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t shell = 0; shell < setup.shells.size(); ++shell) {
    const ShellSetup& shell_setup = setup.shells[shell];
    const ShellModel& m = shell_setup.model;
    ShellState s = make_state(m, Vec3::Zero(), 0);
    const bool can_crack = shell_setup.can_crack();
    const double step = stable_step(m, s, 120, 1, can_crack);
    scene.check(std::isfinite(step), fmt::format("shells[{}].supports", shell),
                "hold every control point of shell '{}'; take more elements, or SIMPLY_SUPPORTED edges", m.name);
    for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
      const double travel = setup.safety * step * setup.bodies[i].motion.velocity.norm();
      scene.check(travel <= Proxy(setup.bodies[i]).radius() + m.thickness, fmt::format("bodies[{}].twist", i),
                  "moves '{}' {:.3g} m in a substep, further than it is wide: it would pass through shell '{}' unseen; "
                  "slow it down, or lower time_step_safety",
                  setup.bodies[i].name, travel, m.name);
    }
    smallest = std::min(smallest, step);
    const int layers = m.tables.gauss_points() * static_cast<int>(m.tables.layers.zeta.size());
    const double shell_time = std::min(setup.latest_freeze, setup.end_time);
    const double allowed = step * (can_crack ? kCrackedStep : 1.0);
    const double most = kMostOfStable * allowed;
    scene.check(setup.time_step <= most, "time_step_s",
                "is {} s; the stable step of shell '{}'{} is {:.4g} s, with a margin at most {:.3g} s would do",
                setup.time_step, m.name, can_crack ? " with cracks" : "", allowed, 0.99 * most);
    for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
      if (shell_setup.hertz[i] == 0.0) continue;
      const double speed = std::max(1e-3, (setup.bodies[i].motion.velocity - shell_setup.velocity).norm());
      const double own = hertz_step(m, setup.bodies[i], shell_setup.hertz[i], speed, step);
      scene.check(
          setup.window / own <= kMostSubsteps, "contacts",
          "make Hertz contact of '{}' with a stiffness of {:.3g} N/m^1.5, which needs substeps of {:.3g} s, {:.3g} a "
          "window; take a softer one",
          setup.bodies[i].name, shell_setup.hertz[i], own, setup.window / own);
    }
    const double taken = setup.time_step > 0.0 ? setup.time_step : setup.safety * allowed;
    const double a_window = std::ceil(setup.window / taken * (1.0 - 1e-12));
    scene.check(a_window <= kMostSubsteps, setup.time_step > 0.0 ? "time_step_s" : "window_s",
                "leads to {:.3g} substeps a window; at most {:.0g}", a_window, kMostSubsteps);
    const double substeps = a_window * shell_time / setup.window;
    const auto start = std::chrono::steady_clock::now();
    constexpr int kTrials = 20;
    for (int i = 0; i < kTrials; ++i) compute_forces(m, s, false, 1.0, 1);
    const double cost = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / kTrials;
    out += fmt::format(
        "shell          {}\ncontrol points {}\ngauss points   {}\nlayer points   {}\nspacing        {:.4g} m\nstable "
        "step    {:.4g} s\n",
        m.name, m.control_points(), m.tables.gauss_points(), layers, m.spacing, step);
    out += fmt::format("substeps       at most {:.0f}, {:.0f} a window of {:g} s, until {:g} s\n", substeps, a_window,
                       setup.window, shell_time);
    out += fmt::format(
        "time           at most {:.2g} min on one thread for the uncracked shell (measured now: {:.3g} ms a substep)\n"
        "               cracks can make a substep some three times as long; bodies alone come on top\n",
        substeps * cost / 60.0, 1e3 * cost);
    out +=
        fmt::format("memory         about {:.0f} MB\n",
                    1e-6 * (2.0 * 8.0 * s.tables.metric.size() + 8.0 * (s.surface_stress.size() + 12.0 * s.x.size())));
    if (!m.strength_factor.empty()) {
      double low = 1e300, high = 0.0;
      for (int q = 0; q < m.tables.blocks(); ++q)
        for (int e = 0; e < m.tables.spans_u; ++e)
          low = std::min(low, m.strength_factor_at(q, e)), high = std::max(high, m.strength_factor_at(q, e));
      out += fmt::format("strength       {:.3g} to {:.3g} times the material's\n", low, high);
    }
    if (shell_setup.brittleness > 0.0) {
      const double width = 2.0 * m.material.youngs_modulus * m.material.fracture_energy /
                           (m.material.strength * m.material.strength) * shell_setup.brittleness /
                           (1.0 + shell_setup.brittleness);
      out += fmt::format(
          "fracture       damage over {:.3g} m: complete at {:.2f} times the strain of the strength, and takes {:.3g} "
          "J/m^2\n",
          width, (1.0 + shell_setup.brittleness) / shell_setup.brittleness, m.material.fracture_energy);
    } else if (m.material.strength > 0.0) {
      const double resolved = 2.0 * m.material.youngs_modulus * m.material.fracture_energy /
                              (std::sqrt(3.0) * m.material.strength * m.material.strength);
      out += m.spacing < resolved
                 ? fmt::format("fracture       the spacing resolves the fracture energy (needs below {:.3g} m)\n",
                               resolved)
                 : fmt::format(
                       "fracture       the spacing does not resolve the softening (that needs below {:.3g} m, or more "
                       "than {:.3g} J/m^2): cracks start by the strength at once, and run by the fracture energy\n",
                       resolved,
                       m.spacing * std::sqrt(3.0) * m.material.strength * m.material.strength /
                           (2.0 * m.material.youngs_modulus));
    }
  }
  const double least = setup.time_step > 0.0 ? setup.time_step * (1.0 - 1e-9) : smallest;
  scene.check(setup.shells.empty() || setup.tick >= least,
              setup.coupling.ticks > 1 ? "coupling.adaptive_window.shortest_window_s" : "window_s",
              "is {} s, shorter than {}, {:.3g} s; make it a multiple of that", setup.tick,
              setup.time_step > 0.0 ? "time_step_s" : "the stable step of the shell", least);
  return out + soft_report(scene, setup);
}

}  // namespace sunder::shell
