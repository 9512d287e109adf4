// Shells whose thickness varies, against exact beams and a disc of two thicknesses.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/io/probes.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/wedge.h"
#include "tests/validation/cases.h"
#include "tests/validation/tied.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

constexpr double kTaperYoung = 2e11, kTaperDensity = 7800.0;
constexpr double kTaperLength = 1.0, kTaperWidth = 0.1, kTaperRoot = 0.02;

// A strip clamped at its thick end, of which `tip` is left at the other one. It bends as a beam.
ShellModel beam(double tip, int elements, int degree, const std::vector<Load>& loads) {
  ShellMaterial m;
  m.density = kTaperDensity, m.youngs_modulus = kTaperYoung, m.poisson_ratio = 0.0;
  Support clamp;
  clamp.edges = kUMin;
  return make_shell("beam",
                    plate(kTaperLength, kTaperWidth, elements, 3, Vec3(0.5 * kTaperLength, 0.5 * kTaperWidth, 0.0),
                          Quat::Identity(), degree),
                    kTaperRoot, m, 2, degree + 1, {clamp}, loads, {},
                    [tip](const Patch&, const Vec2& p) { return 1.0 + (tip - 1.0) * p.x() / kTaperLength; });
}

void tapered(Report& r, int threads) {
  for (const int degree : {2, 3})
    for (const double tip : {0.5, 0.1}) {
      const double start = seconds_now();
      Load end;
      end.kind = Load::Kind::kEdgeForce, end.edges = kUMax, end.force = Vec3(0, 0, 10.0);  // 1 N
      const ShellModel m = beam(tip, 48, degree, {end});
      double mass = 0.0;
      for (const double part : m.mass) mass += part;
      const std::string name = fmt::format("tapered_{}_{}", degree, tip);
      r.add(name + "_mass", mass, kTaperDensity * kTaperLength * kTaperWidth * kTaperRoot * 0.5 * (1.0 + tip), 1e-12,
            seconds_now() - start);
      ShellState s = make_state(m, Vec3::Zero(), 0);
      RelaxationRules rules;
      rules.threads = threads, rules.tolerance = 1e-9;
      relax(m, s, rules);
      const double w = displacement(m, s, {m.patch.knots_u.end(), 0.5 * m.patch.knots_v.end()}).z();
      r.add(name + "_deflection", w,
            wedge_compliance(kTaperRoot, tip * kTaperRoot, kTaperLength) / (kTaperYoung * kTaperWidth), 0.005,
            seconds_now() - start);
    }
}

void wedge(Report& r, int) {
  const double unit = std::sqrt(kTaperYoung * kTaperRoot * kTaperRoot / (12.0 * kTaperDensity)) /
                      (2.0 * std::numbers::pi * kTaperLength * kTaperLength);
  // Digits of a sharp wedge: Kirchhoff 1879, as in tables of beams.
  r.add("wedge_sharp_lambda2", wedge_numbers(1e-6, 1)[0], 5.315, 2e-4, 0.0);
  for (const double tip : {0.3, 0.02}) {
    const double start = seconds_now();
    const ShellModel m = beam(tip, 48, 3, {});
    ShellState s = make_state(m, Vec3::Zero(), 0);
    const ModeSet found = vibration_modes(m, s, 8, [&] { compute_forces(m, s, false, 0.0, 1); });
    const std::vector<double> exact = wedge_numbers(tip, 2);
    for (int k = 0; k < 2; ++k) {  // others bend in the plane or twist
      double nearest = 0.0;
      for (const Mode& mode : found.modes)
        if (std::abs(mode.frequency / unit - exact[k]) < std::abs(nearest - exact[k])) nearest = mode.frequency / unit;
      r.add(fmt::format("wedge_{}_lambda2_{}", tip, k + 1), nearest, exact[k], 0.01, seconds_now() - start);
    }
  }
}

}  // namespace

std::vector<Case> taper_cases() {
  return {{"tapered", "cantilevers whose thickness is linear: mass, deflection", tapered},
          {"wedge", "frequencies of truncated wedges", wedge}};
}

}  // namespace sunder::validation
