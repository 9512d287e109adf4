// Reports what the soft bodies of a scene will cost.
#include <chrono>
#include <cmath>

#include "shell/io/check.h"

namespace sunder::shell {

std::string soft_report(const scene::LoadedScene& scene, const RunSetup& setup) {
  std::string out;
  for (std::size_t k = 0; k < setup.soft.size(); ++k) {
    const SoftModel& m = setup.soft[k].model;
    SoftState s = make_soft_state(m, setup.soft[k].velocity, setup.soft[k].angular);
    const double step = soft_stable_step(m, s), taken = setup.safety * step;
    const double a_window = std::ceil(setup.window / taken * (1.0 - 1e-9));
    scene.check(a_window <= kMostSubsteps, "window_s",
                "leads to {:.3g} steps of soft body '{}' a window; at most {:.0g}", a_window, m.name, kMostSubsteps);
    const auto start = std::chrono::steady_clock::now();
    constexpr int kTrials = 5;
    for (int i = 0; i < kTrials; ++i) to_grid(m, s, Vec3::Zero(), 0.0, 1), from_grid(m, s, 0.0, 1);
    const double cost = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / kTrials;
    const double steps = a_window * setup.end_time / setup.window;
    double mass = 0.0;
    for (const double p : m.mass) mass += p;
    out += fmt::format(
        "soft body      {}\nparticles      {}, {} at the surface, {:.4g} m apart, {:.4g} kg in all\n"
        "grid spacing   {:.4g} m\nstable step    {:.4g} s undeformed\n",
        m.name, m.particles(), m.surface.size(), m.spacing, mass, m.grid, step);
    out += fmt::format(
        "steps          {:.0f}, {:.0f} a window of {:g} s, until {:g} s; more where it is squeezed\n"
        "time           {:.2g} min on one thread without contact (measured now: {:.3g} ms a step)\n",
        steps, a_window, setup.window, setup.end_time, steps * cost / 60.0, 1e3 * cost);
  }
  return out;
}

}  // namespace sunder::shell
