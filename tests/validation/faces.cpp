// Faces of a crack in contact: the thrust of two strips that close like a hinge, and friction.
#include <cmath>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/interlock.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

constexpr double kHingeLength = 0.2, kHingeWidth = 0.02, kHingeThickness = 0.004;

ShellMaterial brittle() {
  ShellMaterial m = glass();
  m.strength = 60e6, m.fracture_energy = 8.0, m.crushing_strength = 1e12;
  return m;
}

// Cuts across the middle; the faces of the cut touch.
void cut(const ShellModel& m, ShellState& s) {
  const int crack = s.cracks.graph.new_crack(), pieces = static_cast<int>(std::round(kHingeWidth / m.spacing));
  const double x = 0.5 * kHingeLength + 1e-4 * m.spacing, past = 0.1 * m.spacing;
  int last = s.cracks.graph.add_vertex({x, -past});
  for (int k = 1; k <= pieces; ++k) {
    const int next = s.cracks.graph.add_vertex({x, k == pieces ? kHingeWidth + past : kHingeWidth * k / pieces});
    insert_edge(m, s, last, next, crack, 0.0, 1, true);
    last = next;
  }
}

// Two strips between fixed edges, free to turn there, touch in the middle and bear their weight as an arch with three
// hinges. About the hinge in the middle, which is at the upper face: H rise = q L^2 / 2, with half the length L.
void hinge(Report& r, int threads) {
  for (const int elements : {40, 80}) {
    const double start = seconds_now(), weight = 224.0;  // [m/s^2]
    ShellMaterial material = brittle();
    material.mass_damping = 3000.0;  // [1/s]: about critical
    const ShellModel m = make_shell("p",
                                    plate(kHingeLength, kHingeWidth, elements, elements / 10,
                                          Vec3(0.5 * kHingeLength, 0.5 * kHingeWidth, 0), Quat::Identity()),
                                    kHingeThickness, material, 2, 2, {});
    RunSetup setup = setup_of({{m}});
    setup.shells[0].fracture.mode = FractureMode::kTips;  // so that faces know where a substep begins
    setup.gravity = {0, 0, -weight};
    Rig rig(std::move(setup), threads);
    ShellState& s = rig.state();
    cut(m, s);
    const std::size_t stride = m.tables.component_stride;
    std::vector<int> left;  // slots of the left edge; both edges are held
    for (int i = 0; i < m.control_points(); ++i) {
      const double x = m.parameter[i].x();
      if (x > 1e-9 && x < kHingeLength - 1e-9) continue;
      s.motion.inverse_mass[m.tables.slot(i)] = 0.0;
      if (x < 1e-9) left.push_back(m.tables.slot(i));
    }
    const double dt = 0.5 * stable_step(m, s, 100, threads, true);
    const int steps = static_cast<int>(0.03 / dt);
    for (int n = 0; n < steps; ++n) rig.step(dt);
    double drop = 0.0, thrust = 0.0;
    for (const Interlock& lock : s.cracks.interlocks) {
      double z = 0.0;
      for (const GatheredFunction& f : lock.plus) z += f.n[0] * s.position(f.slot).z();
      drop -= z * lock.area;
    }
    double area = 0.0;
    for (const Interlock& lock : s.cracks.interlocks) area += lock.area;
    drop /= area;
    for (const int slot : left) thrust -= s.motion.force[slot];
    const double half = 0.5 * kHingeLength, rise = 0.5 * kHingeThickness - drop;
    const double exact = material.density * kHingeThickness * kHingeWidth * weight * half * half / (2.0 * rise);
    r.add(fmt::format("hinge_thrust_{}", elements), thrust, exact, 0.02, seconds_now() - start);
    double fastest = 0.0;
    for (std::size_t i = 0; i < 3 * stride; ++i) fastest = std::max(fastest, std::abs(s.motion.v[i]));
    r.lines.push_back(fmt::format("hinge {}: the middle sinks {:.3g} mm of the {:.3g} mm of its rise; still {:.1g} m/s",
                                  elements, 1e3 * drop, 0.5e3 * kHingeThickness, fastest));
  }
}

// The right half of a strip is pressed against the left and drawn along: its friction over the pressure.
void block(Report& r, int) {
  for (const double friction : {0.1, 0.4, 0.8})
    for (const bool across : {false, true}) {
      const double start = seconds_now();
      ShellMaterial material = brittle();
      material.crack_friction = friction;
      const ShellModel m = make_shell(
          "p",
          plate(kHingeLength, kHingeWidth, 40, 4, Vec3(0.5 * kHingeLength, 0.5 * kHingeWidth, 0), Quat::Identity()),
          kHingeThickness, material, 2, 2, {});
      ShellState s = make_state(m, Vec3::Zero(), 0);
      cut(m, s);
      const std::size_t stride = m.tables.component_stride;
      const int way = across ? 2 : 1;
      const auto move = [&](int axis, double by) {
        for (int i = 0; i < m.control_points(); ++i)
          if (m.parameter[i].x() > 0.5 * kHingeLength) s.motion.x[axis * stride + m.tables.slot(i)] += by;
      };
      move(0, -2e-6);
      const double step = 2e-8;
      double pressure = 0.0, shear = 0.0, last = 0.0, work = 0.0;
      for (int n = 0; n < 400; ++n) {
        move(way, step);
        s.motion.force.assign(s.motion.force.size(), 0.0);
        PointScratch scratch;
        add_point_forces(m.tables, {}, {s.motion.x}, {}, scratch, s.motion.force,
                         [&](int chunk, int chunks, const double* x, double* force) {
                           interlock_forces(m, s, true, chunk, chunks, x, force);
                         });
        pressure = shear = 0.0;
        for (int i = 0; i < m.control_points(); ++i) {
          if (m.parameter[i].x() <= 0.5 * kHingeLength) continue;
          const int slot = m.tables.slot(i);
          pressure += s.motion.force[slot], shear -= s.motion.force[way * stride + slot];
        }
        work += 0.5 * (last + shear) * step, last = shear;
      }
      book_faces(s);
      const std::string name = fmt::format("block_{:.1f}_{}", friction, across ? "across" : "along");
      r.add(name, shear / pressure, friction, 0.01, seconds_now() - start);
      double stored = 0.0;  // in springs that slide no further
      for (const Interlock& lock : s.cracks.interlocks) stored += 0.5 * shear * shear / (lock.stiffness * lock.area);
      const double springs = static_cast<double>(s.cracks.interlocks.size());
      r.add(name + "_work", s.book.face_friction, work - stored / (springs * springs), 0.01, 0.0);
    }
}

}  // namespace

std::vector<Case> face_cases() {
  return {{"hinge", "thrust of two strips whose crack closes: an arch with three hinges", hinge},
          {"block", "friction of a pressed crack, along and across (Coulomb), and its work", block}};
}

}  // namespace sunder::validation
