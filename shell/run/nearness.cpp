#include "shell/run/nearness.h"

#include <fmt/format.h>

namespace sunder::shell {
namespace {

bool looks_at(const Proxy& p) { return !p.body.is_static; }

// Calls f with each place at which contact is felt.
template <class F>
void each_sample(const ShellModel& m, const ShellState& s, F&& f) {
  const RowTables& t = m.tables;
  std::vector<GatheredFunction> functions;
  for (int block = 0; block < t.blocks(); ++block)
    for (int lane = 0; lane < t.spans_u; ++lane) {
      if (t.metric[t.at(block, kMetricFields, kArea, lane)] == 0.0) continue;
      sample_functions(m, s, block, lane, functions);
      if (functions.empty() || s.motion.detached[functions[0].slot]) continue;
      Vec3 x = Vec3::Zero();
      for (const GatheredFunction& g : functions) x += g.n[0] * s.position(g.slot);
      f(x);
    }
}

}  // namespace

void note_touches(const RunSetup& setup, const State& state, Nearness& near) {
  for (std::size_t i = 0; i < setup.bodies.size(); ++i)
    if (looks_at(state.bodies[i]) && state.bodies[i].impulse_sum > 0.0) near.touched = 1;
}

void look_how_near(const RunSetup& setup, const State& state, double time, Nearness& near) {
  for (std::size_t k = 0; k < state.shells.size(); ++k) {
    if (near.touched || !state.shells[k].state) continue;
    const ShellModel& m = state.shells[k].model();
    each_sample(m, *state.shells[k].state, [&](const Vec3& x) {
      for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
        const Proxy& p = state.bodies[i];
        const double face = 0.5 * m.largest_thickness();
        if (!looks_at(p) || (x - p.body.motion.position).norm() - p.radius() - face >= near.gap) continue;
        const double gap = p.distance(x).value - face;
        if (gap >= near.gap) continue;
        near.gap = gap, near.time = time;
        near.body = static_cast<int>(i), near.shell = static_cast<int>(k);
      }
    });
    if (near.gap <= 0.0) near.touched = 1;
  }
}

std::string apart_warning(const RunSetup& setup, const Nearness& near, double time, const std::string& frozen) {
  if (near.touched || near.body < 0) return "";
  return fmt::format(
      "no moving body has touched a shell in {:.4g} s{}: '{}' was nearest, {:.2g} m from shell '{}' at {:.4g} s, as "
      "far as looks from time to time tell; look at its place and velocity, or {}",
      time, frozen.empty() ? "" : ", when the shells were frozen", setup.bodies[near.body].name, near.gap,
      setup.shells[near.shell].model.name, near.time,
      frozen.empty() ? "give a later end_time_s"
                     : fmt::format("let the shells be frozen later (fracture {{ {} }})",
                                   frozen == "latest_freeze_s" ? "latest_freeze_s" : "quiet_time_s"));
}

}  // namespace sunder::shell
