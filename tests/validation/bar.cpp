// A bar that softens and breaks. The damage law localises in one band, which must reach the strength and dissipate the
// fracture energy.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

// Softening under a driven end is stable where 2 E G_f / strength^2 is longer than the bar; here it is 2.5 times as
// long. Strains are so small (complete damage at 0.4 % on the finest mesh) that true and nominal stress agree.
constexpr double kBarLength = 0.1, kBarWidth = 0.025, kBarThickness = 0.002;
constexpr double kBarYoung = 3e9, kStrength = 1.5e5, kToughness = 1.25 * kStrength * kStrength * kBarLength / kBarYoung;
// A column of elements in the middle is a little weaker. Two columns at either end are stronger. Otherwise a band could
// form between a support and one column of Gauss points. It would be narrower, and a crack would not lie in its middle.
constexpr float kWeak = 0.99f, kGrip = 1.5f;
constexpr double kTransits = 300.0;  // passages of a wave over the bar while it is pulled apart
constexpr double kBarPull = 1.3;     // multiple of 2 G_f / strength, at which softening over one width is complete

// The strain of quadratic functions is piecewise linear. It localises in one hat over two elements, whose Gauss points
// are at 0.211, 0.789, 0.789, 0.211 of its height. When damage is complete at the inner two, the outer two have 0.268
// of that strain. They have then used 1 - (1 - 0.268)^2 = 0.464 of the area under the curve, and the crack cuts the
// element. Each point stands for half an element, so the dissipation is that of a band of 1.464 elements.
constexpr double kDerivedBand = 1.464;  // [spacings]
// The outer points return a little of it to the bar when they are cut: by work the band is 1.41 to 1.44 elements.
constexpr double kBand = 1.43;  // [spacings]

struct Pulled {
  double peak = 0.0;      // nominal stress [Pa]
  double energy = 0.0;    // work of the driven end minus damping and the energy left in the pieces, per area [J/m^2]
  double booked = 0.0;    // the booked part of it [J/m^2]
  double band = 0.0;      // width of the band at the first crack, from the used share of the area under the curve [m]
  double residual = 0.0;  // nominal stress at that time [Pa]
  int pieces = 0;
  std::vector<double> opening, stress;  // [um], [-] of the strength
};

// Returns the used share of the area under the softening curve at damage `c`.
double passed(double c, double h) {
  if (c <= 0.0) return 0.0;
  const double complete = (1.0 + h) / h, strain = 1.0 / (1.0 - c / (1.0 + h));  // relative to the strain at the peak
  const double left = (complete - strain) / (complete - 1.0);
  return 1.0 - left * left * (complete - 1.0) / complete;
}

ShellModel make_bar(int elements, double duration) {
  ShellMaterial material;
  material.density = 1000, material.youngs_modulus = kBarYoung, material.poisson_ratio = 0.0;
  material.strength = kStrength, material.fracture_energy = kToughness;
  material.mass_damping = 2.0 * std::sqrt(kBarYoung / material.density) / kBarLength;
  Support fixed, driven;
  fixed.edges = kUMin, driven.edges = kUMax;
  fixed.clamped = driven.clamped = false;
  fixed.axes = driven.axes = {true, false, false};
  driven.motion = {{0.0, Vec3::Zero()}, {duration, Vec3(kBarPull * 2.0 * kToughness / kStrength, 0.0, 0.0)}};
  ShellModel m = make_shell("bar", plate(kBarLength, kBarWidth, elements, elements / 4, Vec3::Zero(), Quat::Identity()),
                            kBarThickness, material, 1, 2, {fixed, driven});
  const RowTables& t = m.tables;
  m.strength_factor.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, 1.0f);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      float& factor = m.strength_factor[static_cast<std::size_t>(q) * t.lanes + e];
      factor = e == elements / 2 ? kWeak : e < 2 || e >= elements - 2 ? kGrip : 1.0f;
    }
  return m;
}

Pulled pull(int elements, double width, bool heals, int threads) {
  const double duration = kTransits * kBarLength / std::sqrt(kBarYoung / 1000.0);
  RunSetup setup = setup_of({{make_bar(elements, duration)}});
  setup.seed = 1;
  FractureRules& rules = setup.shells[0].fracture;
  rules.mode = FractureMode::kDamage;
  rules.damage.brittleness = brittleness(kStrength, kBarYoung, kToughness, width), rules.damage.heals = heals;
  Rig rig(std::move(setup), threads);
  const ShellModel& m = rig.model();
  const RowTables& t = m.tables;
  ShellState& s = rig.state();
  const double section = kBarWidth * kBarThickness;
  const int steps = static_cast<int>(std::ceil(duration / (0.5 * stable_step(m, s, 200, threads, true))));
  const int often = std::max(1, steps / 400);
  const double dt = duration / steps;
  Pulled out;
  for (int k = 0; k < steps; ++k) {
    const double time = s.motion.time;
    rig.step(dt);         // leaves the force that it began with
    double stress = 0.0;  // mean of both ends, in which waves between them cancel
    for (int j = 0; j < t.rows; ++j)
      stress += 0.5 * (s.motion.force[t.slot(j * t.columns)] - s.motion.force[t.slot(j * t.columns + t.columns - 1)]) /
                section;
    out.peak = std::max(out.peak, stress);
    if (k % often == 0)
      out.opening.push_back(1e6 * m.constraints.driven[0].displacement(time).x()),
          out.stress.push_back(stress / kStrength);
    watch_stress(m, s);
    if (k % 8 || !s.cracks.graph.edges().empty()) continue;
    std::vector<float> worst;
    for (const PointDamage& d : s.cracked.damage) worst.push_back(d.worst());
    if (extract_cracks(m, s, s.motion.time) == 0) continue;
    out.residual = stress;
    for (std::size_t i = 0; i < worst.size(); ++i)
      out.band += s.cracked.gathered[i].area / kBarWidth * passed(worst[i], s.layers.brittleness);
  }
  const double left = compute_forces(m, s, true, 0.0, threads) + kinetic_energy(m, s, dt);
  out.energy = (s.book.external - s.book.damping - left) / section;
  out.booked = (s.book.fracture - s.book.injected + s.book.healing) / section;
  std::vector<Piece> pieces;
  out.pieces = partition(m, s, pieces).pieces;
  return out;
}

void bar(Report& r, int threads) {
  for (const int n : {16, 32, 48}) {
    const double h = kBarLength / n;
    for (const bool heals : {true, false}) {
      const double start = seconds_now();
      const std::string name = fmt::format("{}_{}", heals ? "bar" : "bar_maximum", n);
      const Pulled p = pull(n, kBand * h, heals, threads);
      r.add(name + "_peak", p.peak, kStrength, 0.01, seconds_now() - start);
      r.add(name + "_energy", p.energy, kToughness, 0.03, 0.0);
      r.add(name + "_band", p.band / h, kDerivedBand, 0.03, 0.0);
      r.add(name + "_pieces", p.pieces, 2.0, 0.0, 0.0);
      r.lines.push_back(fmt::format(
          "{}: damage over {} spacings takes {:.3f} G_f by work, {:.3f} by the book: a band of {:.3f} spacings; cut at "
          "{:.2f} of the strength",
          name, kBand, p.energy / kToughness, p.booked / kToughness, kBand * p.energy / kToughness,
          p.residual / kStrength));
      if (heals) r.curves.push_back({name, "opening [um]", "stress / strength", p.opening, p.stress, false});
    }
    const Pulled p = pull(n, std::sqrt(3.0) * h, true, threads);
    r.lines.push_back(fmt::format("bar_{}: over the paper's sqrt(3) spacings {:.3f} G_f, peak {:.3f} of the strength",
                                  n, p.energy / kToughness, p.peak / kStrength));
  }
}

}  // namespace

std::vector<Case> bar_cases() {
  return {{"bar", "a bar softens in one band and parts: strength, fracture energy, width of the band", bar}};
}

}  // namespace sunder::validation
