// The effect of the background grid on the vibration of a plate.
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "tests/shell/rig.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr int kStripElements = 32;
constexpr double kPeriods = 3.0;

struct Swing {
  std::string name;
  Transfer kind;
  double spacing;  // spacing of the grid, in elements
  double step;     // in passages of a wave over an element; the plate's stable step is 1.63
  bool leaky = false;
  // relative to the exact period; to the first peak; per control point
  double period = 0.0, amplitude = 0.0, nanoseconds = 0.0;
};

// First mode of a simply supported square, three periods. Peaks lie between zero crossings of the middle's deflection.
void swing_over(Swing& out) {
  constexpr double kYoung = 1e7, kPoisson = 0.3, kDensity = 1000.0, kThickness = 0.01;
  ShellMaterial material;
  material.density = kDensity, material.youngs_modulus = kYoung, material.poisson_ratio = kPoisson;
  Support hinge;
  hinge.edges = kUMin | kUMax | kVMin | kVMax, hinge.clamped = false;
  RunSetup setup =
      setup_of({{make_shell("plate", plate(1.0, 1.0, kStripElements, kStripElements, Vec3::Zero(), Quat::Identity()),
                            kThickness, material, 2, 2, {hinge})}});
  setup.shells[0].transfer = {out.kind, out.spacing * setup.shells[0].model.spacing, out.leaky};
  Rig rig(std::move(setup));
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const std::size_t stride = m.tables.component_stride;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    s.motion.v[2 * stride + slot] = 0.002 * std::sin(pi * m.parameter[i].x()) * std::sin(pi * m.parameter[i].y());
    s.motion.x[2 * stride + slot] += 0.3 / kStripElements;  // no plane of grid nodes lies in the plate
    if (s.motion.inverse_mass[slot] == 0.0) s.motion.v[2 * stride + slot] = 0.0;
  }
  if (out.kind != Transfer::kDirect) s.motion.before = s.motion.v;
  const double rigidity = kYoung * std::pow(kThickness, 3) / 12.0 / (1.0 - kPoisson * kPoisson);
  const double period = 2.0 * pi / (2.0 * pi * pi * std::sqrt(rigidity / (kDensity * kThickness)));
  const double dt = out.step * m.spacing / m.wave_speed();
  const int middle = m.tables.slot(m.control_points() / 2 + m.tables.columns / 2);
  const double rest = s.motion.x[2 * stride + middle];
  double before = 1e-12, peak = 0.0, first_peak = 0.0, last_peak = 0.0, first = 0.0, last = 0.0;
  int crossings = 0;
  const std::int64_t steps = std::llround(kPeriods * period / dt);
  for (std::int64_t k = 1; k <= steps; ++k) {
    rig.step(dt);
    const double now = s.motion.x[2 * stride + middle] - rest;
    peak = std::max(peak, std::abs(now));
    if ((now > 0.0) != (before > 0.0)) {
      last = (static_cast<double>(k) - now / (now - before)) * dt;
      if (crossings++ == 0) first = last, first_peak = peak;
      last_peak = peak, peak = 0.0;
    }
    before = now;
  }
  out.nanoseconds = 1e9 * rig.times()[Stage::kTransfer] / static_cast<double>(steps) / m.control_points();
  if (crossings < 2) return;  // nothing swings any more
  out.period = 2.0 * (last - first) / (crossings - 1) / period;
  out.amplitude = last_peak / first_peak;
}

void transfers_case(Report& r, int threads) {
  constexpr std::array<double, 3> kSteps{1.2, 0.6, 0.3};
  std::vector<Swing> all;
  for (const double step : kSteps) {
    all.push_back({"direct", Transfer::kDirect, 1.0, step});
    all.push_back({"flip", Transfer::kFlip, 1.0, step});
    all.push_back({"flip_2", Transfer::kFlip, 2.0, step});
    all.push_back({"apic", Transfer::kApic, 1.0, step});
    all.push_back({"pic", Transfer::kPic, 1.0, step});
  }
  all.push_back({"flip_leaky", Transfer::kFlip, 1.0, 0.3, true});
  all.push_back({"flip_2_leaky", Transfer::kFlip, 2.0, 0.3, true});
  all.push_back({"apic_leaky", Transfer::kApic, 1.0, 0.3, true});
  const double start = seconds_now();
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (std::size_t i = 0; i < all.size(); ++i) swing_over(all[i]);
  const double seconds = seconds_now() - start;
  r.lines.push_back(
      "transfers: grid of one element, flip_2 of two; leaky: forces on held points reach the grid; step in elements "
      "over the "
      "wave speed");
  r.lines.push_back(fmt::format("{:<14} {:>6} {:>16} {:>22} {:>18}", "transfer", "step", "period error",
                                "amplitude kept", "ns/control point"));
  for (const Swing& s : all)
    r.lines.push_back(fmt::format("{:<14} {:>6.2f} {:>16} {:>22.3f} {:>18.0f}", s.name, s.step,
                                  s.period > 0.0 ? fmt::format("{:+.2f} %", 100.0 * (s.period - 1.0)) : "no swing",
                                  s.amplitude, s.nanoseconds));
  const auto at = [&](const std::string& name, double step) {
    for (const Swing& s : all)
      if (s.name == name && s.step == step) return s;
    return Swing{};
  };
  // The discrete plate's own period is 0.2 % off. The effect of the grid is compared with figures of an independent
  // code, in which forces on held points reach the grid.
  for (const double step : kSteps) {
    const Swing s = at("direct", step);
    r.add(fmt::format("transfer_direct_period_{:.1f}", step), s.period, 1.0, 0.005, step == kSteps[0] ? seconds : 0.0);
    r.add(fmt::format("transfer_direct_amplitude_{:.1f}", step), s.amplitude, 1.0, 1e-3, 0.0);
  }
  r.add("transfer_flip_leaky_period", at("flip_leaky", 0.3).period, 1.086, 0.002, 0.0);
  r.add("transfer_flip_leaky_amplitude", at("flip_leaky", 0.3).amplitude, 0.999, 0.002, 0.0);
  r.add("transfer_flip_2_leaky_period", at("flip_2_leaky", 0.3).period, 1.30, 0.005, 0.0);
  r.add("transfer_flip_2_leaky_amplitude", at("flip_2_leaky", 0.3).amplitude, 1.18, 0.01, 0.0);
  r.add("transfer_apic_leaky_period", at("apic_leaky", 0.3).period, 1.03, 0.005, 0.0);
  r.add("transfer_apic_leaky_amplitude", at("apic_leaky", 0.3).amplitude, 0.15, 0.03, 0.0);
  r.add("transfer_pic_amplitude", at("pic", 0.3).amplitude, 0.0, 1e-3, 0.0);
  // The paper's transfer loses more of the motion at smaller steps.
  for (const auto& [large, small] : {std::pair{1.2, 0.6}, std::pair{0.6, 0.3}})
    r.add(fmt::format("transfer_apic_falls_{:.1f}", small),
          at("apic", small).amplitude < 0.85 * at("apic", large).amplitude, 1.0, 0.0, 0.0);
}

}  // namespace

std::vector<Case> transfer_cases() {
  return {{"transfers", "a plate's first mode through the background grid, four ways, three steps", transfers_case}};
}

}  // namespace sunder::validation
