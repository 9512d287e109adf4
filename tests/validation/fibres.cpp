// Shear and compression through the thickness of shells in contact: exact results, and the error of the grid.
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "tests/shell/pile.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

constexpr double kSheetThickness = 0.004, kSheetDensity = 1000.0;
constexpr double kSheetSize = 0.24;  // side of the upper sheet [m]
constexpr int kSheetElements = 8;    // elements per side
constexpr double kModulus = 1e5;     // of compression and shear [Pa]

ShellMaterial sheet_material(double damping) {
  ShellMaterial m;
  m.density = kSheetDensity, m.youngs_modulus = 5e8, m.poisson_ratio = 0.3, m.mass_damping = damping;
  return m;
}

Support everywhere() {
  Support s;
  s.clamped = false;
  s.regions = {{Vec2(-1e3, -1e3), Vec2(1e3, 1e3)}};
  return s;
}

/// A sheet held flat and other sheets on it; the uppermost is pressed. Sizes are in elements.
struct Stack : Pile {
  double dt = 0.0;
  Stack(int sheets, double pressure, double friction, double elements, int below, const Quat& turn)
      : Pile(layers(sheets, pressure, friction, below, turn), elements * kSheetSize / kSheetElements) {
    double least = 1e300;
    for (std::size_t k = 1; k < size(); ++k) least = std::min(least, stable_step(model(k), state(k), 80, 1, false));
    dt = 0.8 * stable_step_with_fibres(least, setup().models());
  }
  static std::vector<Layer> layers(int sheets, double pressure, double friction, int below, const Quat& turn) {
    const FibreLaw law{kModulus, kModulus, friction};
    const double h = kSheetSize / kSheetElements;
    std::vector<Layer> out{{make_shell("low", plate(below * h, below * h, below, below, Vec3::Zero(), Quat::Identity()),
                                       kSheetThickness, sheet_material(0.0), 2, 2, {everywhere()}),
                            law}};
    Load load;
    load.kind = Load::Kind::kPressure, load.size = -pressure;
    for (int k = 1; k <= sheets; ++k)
      out.push_back({make_shell("high",
                                plate(kSheetSize, kSheetSize, kSheetElements, kSheetElements,
                                      Vec3(0, 0, k * (kSheetThickness + 1e-6)), turn),
                                kSheetThickness, sheet_material(1000.0), 2, 2, {},
                                k == sheets ? std::vector<Load>{load} : std::vector<Load>{}),
                     law});
    return out;
  }
  void go(double time) { run(static_cast<int>(std::lround(time / dt)), dt); }
  void remove_damping() {
    for (ShellSetup& s : setup().shells) s.model.material.mass_damping = 0.0;
  }
  Vec3 mean(std::size_t k, bool speed) const {
    Vec3 sum = Vec3::Zero();
    double mass = 0.0;
    for (int i = 0; i < model(k).control_points(); ++i) {
      const int slot = model(k).tables.slot(i);
      const double m = model(k).mass[slot];
      mass += m, sum += m * (speed ? state(k).velocity(slot) : state(k).position(slot));
    }
    return sum / mass;
  }
};

// Random directors: the return map against its definition.
void return_map(Report& report) {
  const double start = seconds_now();
  const FibreLaw law{3e5, 2e5, 0.4};
  std::mt19937_64 random(1);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
  };
  double worst = 0.0, made = 0.0, again = 0.0, slope = 0.0;
  for (int i = 0; i < 1000000; ++i) {
    const double angle = uniform(0, 6.283185307179586), shear = uniform(0, 0.5), r33 = uniform(0.1, 1.1);
    const Vec3 a(shear * std::cos(angle), shear * std::sin(angle), r33), b = fibre_return(law, a);
    const double kept = std::min(shear, law.friction * law.compression * (1 - r33) * (1 - r33) / law.shear);
    const Vec3 exact = r33 > 1.0 ? Vec3::UnitZ() : Vec3(kept * std::cos(angle), kept * std::sin(angle), r33);
    worst = std::max(worst, (b - exact).norm());
    made = std::max(made, fibre_energy(law, b) / std::max(1e-9, fibre_energy(law, a)) - 1.0);
    again = std::max(again, (fibre_return(law, b) - b).norm());
    for (int d = 0; d < 3 && i % 100 == 0; ++d) {
      constexpr double kEps = 1e-5;
      const double difference =
          fibre_energy(law, a + kEps * Vec3::Unit(d)) - fibre_energy(law, a - kEps * Vec3::Unit(d));
      slope = std::max(slope, std::abs(difference / (2.0 * kEps) - fibre_stress(law, a)[d]) / law.compression);
    }
  }
  report.add("return_map", worst, 0.0, 1e-15, seconds_now() - start);  // round-off of sine, cosine and division
  report.add("return_map_twice", again, 0.0, 1e-15, 0.0);
  report.add("return_map_adds_energy", above_zero(made), 0.0, 1e-15, 0.0);
  report.add("stress_is_gradient", slope, 0.0, 1e-9, 0.0);  // eps^2 / 3, and round-off over eps
}

// Under the pressure p, layers approach until k (1 - d/t)^2 = p.
void compression(Report& report) {
  for (const double elements : {1.0, 1.5, 2.0}) {
    for (const double share : {1e-3, 1e-2, 1e-1}) {
      const double start = seconds_now();
      Stack s(1, share * kModulus, 0.5, elements, kSheetElements, Quat::Identity());
      s.go(0.03);
      const double approach = 1.0 - s.mean(1, false).z() / kSheetThickness;
      report.add(fmt::format("compressed_{:g}_{:g}p/k", elements, share), approach, std::sqrt(share), 0.01,
                 seconds_now() - start);
    }
    const double start = seconds_now();
    Stack s(1, 1e-2 * kModulus, 0.5, elements, 2 * kSheetElements, Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())));
    s.go(0.03);
    // The lower sheet extends further, so nodes beyond the edge of the upper one carry part of the load.
    report.add(fmt::format("compressed_edge_{:g}", elements), 1.0 - s.mean(1, false).z() / kSheetThickness, 0.1, 0.02,
               seconds_now() - start);
  }
  const double start = seconds_now();
  Stack s(3, 1e-2 * kModulus, 0.5, 1.0, kSheetElements, Quat::Identity());
  s.go(0.06);
  for (std::size_t k = 1; k <= 3; ++k)
    report.add(fmt::format("compressed_pile_{}", k),
               1.0 - (s.mean(k, false).z() - s.mean(k - 1, false).z()) / kSheetThickness, 0.1, 0.01,
               k == 1 ? seconds_now() - start : 0.0);
}

// A traction drags a pressed sheet. Friction holds up to c_f p; the excess accelerates the sheet.
void friction(Report& report) {
  constexpr double kFriction = 0.4, kPressure = 1e3, kTime = 0.01;
  const double mass = kSheetDensity * kSheetThickness, holds = kFriction * kPressure / mass;  // [kg/m^2], [m/s^2]
  for (const double elements : {1.0, 1.5, 2.0})
    for (const double share : {0.8, 0.95, 1.05, 1.3, 2.0}) {
      const double start = seconds_now();
      Stack s(1, kPressure, kFriction, elements, 2 * kSheetElements, Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())));
      s.go(0.03);
      s.setup().gravity.x() = share * holds;
      s.go(0.015);  // until what the jump has set in motion has passed
      s.remove_damping();
      const Vec3 before = s.mean(1, true);
      s.go(kTime);
      const double found = (s.mean(1, true).x() - before.x()) / std::round(kTime / s.dt) / s.dt;
      const double exact = above_zero(share - 1.0) * holds;
      // As a share of the traction.
      report.add(fmt::format("dragged_{:g}_{:.2f}", elements, share), found / (share * holds), exact / (share * holds),
                 share < 1.0 ? 0.001 : 0.005, seconds_now() - start);
    }
}

// Pressed sheets that are drawn apart separate without adhesion, from a distance of one thickness on.
void parting(Report& report) {
  for (const double elements : {1.0, 2.0}) {
    const double start = seconds_now();
    Stack s(1, 1e3, 0.5, elements, 2 * kSheetElements, Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())));
    s.go(0.03);
    s.remove_damping();
    s.setup().shells[1].model.loads = {}, s.state(1).motion.external.clear();
    s.setup().gravity = Vec3(0, 0, 50.0);
    double most = 0.0, free = 0.0;  // what pulls it down, of what draws it up, and where nothing acts any more
    s.run(static_cast<int>(0.02 / s.dt), s.dt, [&] {
      Motion& t = s.state(1).motion;
      const double gap = s.mean(1, false).z();
      t.force.assign(t.force.size(), 0.0);
      s.fibres().add_forces(s.refs());
      double sum = 0.0;
      for (std::size_t i = 0; i < t.mass.size(); ++i) sum += t.force[2 * t.mass.size() + i];
      most = std::max(most, -sum / (50.0 * kSheetDensity * kSheetThickness * kSheetSize * kSheetSize));
      if (sum != 0.0) free = gap;
    });
    report.add(fmt::format("parting_holds_{:g}", elements), most, 0.0, 1e-3, seconds_now() - start);
    report.add(fmt::format("parting_free_at_{:g}", elements), free / kSheetThickness, 1.0, 0.02, 0.0);
  }
}

// Free sheets collide obliquely.
void sheets_collide(Report& report) {
  const FibreLaw law{3e5, 2e5, 0.3};
  for (const double share : {0.5, 0.25}) {
    const double start = seconds_now();
    const ShellMaterial m = sheet_material(0.0);
    const Quat askew(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
    Pile p({{make_shell("low", plate(0.5, 0.5, 12, 12, Vec3::Zero(), Quat::Identity()), 0.01, m, 2, 2, {}), law},
            {make_shell("high", plate(0.4, 0.4, 9, 9, Vec3(0.1, 0.05, 0.012), askew), 0.01, m, 2, 2, {}), law,
             Vec3(1, 0, -3)}},
           0.05);
    const double dt = share * p.stable();
    const Totals before = p.sums();
    const double stored = p.energy(dt);
    double pressed = 0.0;
    p.run(static_cast<int>(0.02 / dt), dt, [&] { pressed = std::max(pressed, p.fibres().energy()); });
    const Totals after = p.sums();
    const auto name = [&](const char* what) { return fmt::format("fibres_{}_{:g}", what, share); };
    report.add(name("momentum"), (after.momentum - before.momentum).norm() / before.momentum_scale, 0.0, 1e-12,
               seconds_now() - start);
    report.add(name("angular_momentum"), (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12,
               0.0);
    report.add(name("energy"), p.energy(dt) / stored, 1.0, 1e-3 * share, 0.0);  // of first order in the step
    report.lines.push_back(fmt::format("fibres held up to {:.3g} of the energy, slipping took {:.3g}", pressed / stored,
                                       p.contact() / stored));
  }
}

// Just below the reported stable step the motion stays bounded; well above the true one it grows.
void bounded(Report& report) {
  for (const double share : {0.98, 3.0}) {
    const double start = seconds_now();
    const FibreLaw law{3e6, 3e6, 0.5};
    std::vector<Layer> layers;
    for (int k = 0; k < 3; ++k)
      layers.push_back({make_shell("sheet", plate(0.4, 0.4, 10, 10, Vec3(0.003 * k, 0, 0.0101 * k), Quat::Identity()),
                                   0.01, sheet_material(0.0), 2, 2, {}),
                        law, Vec3(0, 0, -1.0 * k)});
    Pile p(layers, 0.04);
    const double dt = share * p.stable(), stored = p.energy(dt);
    double most = 0.0;
    try {
      p.run(2000, dt, [&] { most = std::max(most, p.fibres().energy() / stored); });
    } catch (const std::exception&) {
      most = 1e9;
    }
    if (share < 1.0)
      report.add("stable_step_0.98", p.energy(dt) / stored, 1.0, 2e-3, seconds_now() - start);
    else  // the bound is not too generous
      report.add("stable_step_3_grows", most > 10.0 ? 1.0 : 0.0, 1.0, 0.0, seconds_now() - start);
  }
}

}  // namespace

std::vector<Case> fibre_cases() {
  return {{"return_map", "fibres' return map and stress against their formulas, a million directors",
           [](Report& r, int) { return_map(r); }},
          {"compression", "a sheet pressed on another by p, grids of 1, 1.5, 2 elements: approach, k (1 - r33)^2 = p",
           [](Report& r, int) { compression(r); }},
          {"friction", "the same dragged along: share of the traction that is left (Coulomb)",
           [](Report& r, int) { friction(r); }},
          {"parting", "drawn apart again: pull that holds it, and gap in thicknesses at which it is free",
           [](Report& r, int) { parting(r); }},
          {"fibre_collision", "free sheets with fibres that collide: momentum, angular momentum, energy with its book",
           [](Report& r, int) { sheets_collide(r); }},
          {"fibre_step", "three sheets that collide at 0.98 of the stable step, and at 3 times it",
           [](Report& r, int) { bounded(r); }}};
}

}  // namespace sunder::validation
