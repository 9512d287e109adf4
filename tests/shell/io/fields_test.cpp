// Fields of shells: exact states, moments of plates, and equilibrium of a vault.
#include "shell/io/fields.h"

#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "shell/run/simulation.h"
#include "tests/coupler/small_scene.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

FieldSet all_fields() {
  FieldSet set;
  for (int f = FieldSet::kStress; f <= FieldSet::kContactPressure; ++f) set.add(f);
  return set;
}

/// Values at a place by their names, for example stress_outside_xx.
std::map<std::string, double> values_at(const ShellModel& m, const ShellState& s, const Vec2& at,
                                        const ContactOverTime& contact = {}) {
  std::vector<double> values;
  FieldSampler(m, s, all_fields(), contact).add_values(at, values);
  std::map<std::string, double> out;
  std::size_t k = 0;
  for (const FieldArray& a : field_arrays(all_fields()))
    for (std::size_t i = 0; i < a.size(); ++i)
      out[a.name + (a.components.empty() ? "" : "_" + a.components[i])] = values.at(k++);
  EXPECT_EQ(k, values.size());
  return out;
}

void stretch(const ShellModel& m, ShellState& s, const Vec3& by) {
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < m.tables.component_stride; ++i)
      s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + i] *= by[d];
}

/// The first equilibrium of a scene in which nothing moves, handed to `look` with its first shell.
template <class F>
void in_equilibrium(const std::string& text, F&& look) {
  const std::string path = small_scene::own_file("fields_test.textproto");
  std::ofstream(path) << text;
  RunSetup setup = build(scene::load(path, {}));
  std::remove(path.c_str());
  Simulation simulation(setup, 1);
  simulation.prepare();
  simulation.make_states();
  simulation.find_equilibria(0, [] {});
  look(simulation.state.shells[0].model(), *simulation.state.shells[0].state);
}

}  // namespace

// Poisson's ratio is 0, so the thickness stays and mu = E/2: sigma = mu (stretch - 1/stretch).
TEST(Fields, OfAStretchedStripAreExact) {
  const ShellModel m = strip({}, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const double by = 1.01, stress = 0.5 * 70e9 * (by - 1.0 / by);
  stretch(m, s, Vec3(by, 1, 1));
  for (const Vec2& at : {Vec2(0.5, 0.1), Vec2(0.013, 0.19), Vec2(0.0, 0.0)}) {
    auto v = values_at(m, s, at);
    for (const char* place : {"outside", "middle", "inside"}) {
      const std::string name = std::string("stress_") + place;
      EXPECT_NEAR(v.at(name + "_xx"), stress, 1e-9 * stress);
      EXPECT_NEAR(v.at(name + "_principal_larger"), stress, 1e-9 * stress);
      EXPECT_NEAR(v.at(name + "_von_mises"), stress, 1e-9 * stress);
      EXPECT_NEAR(std::abs(v.at(name + "_direction_x")), 1.0, 1e-9);
      EXPECT_NEAR(v.at(name + "_yy"), 0.0, 1e-9 * stress);
      EXPECT_NEAR(v.at(std::string("strain_") + place + "_xx"), 0.5 * (by * by - 1.0), 1e-12);
    }
    EXPECT_NEAR(v.at("membrane_force_xx"), 0.01 * stress, 1e-11 * stress);
    EXPECT_NEAR(v.at("bending_moment_xx"), 0.0, 1e-12 * stress);
    EXPECT_NEAR(v.at("thickness"), 0.01, 1e-14);
  }
}

// A rotation of a stretched strip rotates its stress.
TEST(Fields, TurnWithTheShell) {
  const ShellModel m = strip({}, {}, 0.3);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  stretch(m, s, Vec3(1.004, 0.999, 1));
  auto before = values_at(m, s, Vec2(0.4, 0.1));
  const Quat turn = Quat(0.4, 0.3, -0.8, 0.2).normalized();
  for (int i = 0; i < m.tables.component_stride; ++i) {
    const Vec3 x = turn * s.position(i);
    for (int d = 0; d < 3; ++d) s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + i] = x[d];
  }
  auto after = values_at(m, s, Vec2(0.4, 0.1));
  Mat3 flat;
  flat << before.at("stress_outside_xx"), before.at("stress_outside_xy"), 0, before.at("stress_outside_xy"),
      before.at("stress_outside_yy"), 0, 0, 0, 0;
  const Mat3 turned = turn.toRotationMatrix() * flat * turn.toRotationMatrix().transpose();
  const double scale = before.at("stress_outside_von_mises");
  const auto near = [&](const char* name, double value) { EXPECT_NEAR(after.at(name), value, 1e-9 * scale) << name; };
  near("stress_outside_xx", turned(0, 0)), near("stress_outside_yy", turned(1, 1));
  near("stress_outside_zz", turned(2, 2)), near("stress_outside_xy", turned(0, 1));
  near("stress_outside_yz", turned(1, 2)), near("stress_outside_xz", turned(0, 2));
  near("stress_outside_principal_larger", before.at("stress_outside_principal_larger"));
  near("stress_outside_principal_smaller", before.at("stress_outside_principal_smaller"));
  EXPECT_LT(after.at("thickness"), 0.01);  // it contracts across the stretch
}

// An end moment is the moment everywhere, whatever bending is computed by; it stretches the outside where the end turns
// towards the inside.
TEST(Fields, MomentOfACantileverIsThatOfItsEnd) {
  for (const char* how : {"layers: 2", "layers: 5", "bending: LINEAR"}) {
    SCOPED_TRACE(how);
    const std::string text =
        "gravity { z: 0 }\n"
        "materials { name: \"m\" density: 1 youngs_modulus: 1.2e6 poisson_ratio: 0 }\n"
        "shells { name: \"plate\" material: \"m\" thickness_m: 0.1 " +
        std::string(how) +
        " plate { size_x_m: 10 size_y_m: 1 elements_x: 16 elements_y: 1 degree: 3 }\n"
        "supports { edges: U_MIN kind: CLAMPED }\n"
        "loads { edge_moment { edge: U_MAX moment_per_length: -0.02 } } equilibrium {} }\n";
    in_equilibrium(text, [](const ShellModel& m, const ShellState& s) {
      for (const double u : {1.3, 5.0, 8.9}) {
        auto v = values_at(m, s, Vec2(u, 0.5));
        EXPECT_NEAR(v.at("bending_moment_xx"), 0.02, 2e-5);  // 1e-3: of elements
        EXPECT_NEAR(v.at("membrane_force_xx"), 0.0, 2e-5);
        EXPECT_NEAR(v.at("stress_outside_xx"), 6 * 0.02 / 0.01, 0.02);  // 6 m / t^2
        EXPECT_NEAR(v.at("stress_inside_xx"), -6 * 0.02 / 0.01, 0.02);
        EXPECT_NEAR(v.at("stress_middle_xx"), 0.0, 0.02);
      }
    });
  }
}

// Timoshenko and Woinowsky-Krieger, tables 8 and 35: square plates under pressure, Poisson's ratio 0.3. The tables have
// three digits. The load is small, so that no membrane forces arise.
TEST(Fields, MomentsOfSquarePlatesAreThePublishedOnes) {
  const auto plate = [](const char* support) {
    return "gravity { z: 0 }\nmaterials { name: \"m\" density: 1 youngs_modulus: 1e9 poisson_ratio: 0.3 }\n"
           "shells { name: \"plate\" material: \"m\" thickness_m: 0.01\n"
           "plate { size_x_m: 1 size_y_m: 1 elements_x: 16 elements_y: 16 degree: 3 }\n" +
           std::string(support) + "loads { pressure: -0.1 } equilibrium {} }\n";
  };
  const double load = 0.1;  // q a^2 [N]
  in_equilibrium(plate("supports { edges: ALL kind: SIMPLY_SUPPORTED }\n"),
                 [&](const ShellModel& m, const ShellState& s) {
                   auto v = values_at(m, s, Vec2(0.5, 0.5));
                   EXPECT_NEAR(-v.at("bending_moment_xx") / load, 0.0479, 1e-4);
                   EXPECT_NEAR(-v.at("bending_moment_yy") / load, 0.0479, 1e-4);
                   EXPECT_NEAR(v.at("bending_moment_xy") / load, 0.0, 1e-8);
                 });
  in_equilibrium(plate("supports { edges: ALL kind: CLAMPED }\n"), [&](const ShellModel& m, const ShellState& s) {
    auto middle = values_at(m, s, Vec2(0.5, 0.5)), edge = values_at(m, s, Vec2(0.0, 0.5));
    EXPECT_NEAR(-middle.at("bending_moment_xx") / load, 0.0231, 2e-4);
    EXPECT_NEAR(-edge.at("bending_moment_xx") / load, -0.0513, 1e-3);  // 2 %: beyond the last Gauss points
  });
}

// The Scordelis-Lo roof spans 50 between its ends as a beam under w a length: the forces in its section at midspan have
// the moment w L^2 / 8 about any horizontal line across, whatever the section does.
TEST(Fields, OfAVaultBalanceItsWeight) {
  const std::string text =
      "gravity { z: -1e-3 }\nmaterials { name: \"concrete\" density: 360 youngs_modulus: 4.32e8 poisson_ratio: 0 }\n"
      "shells { name: \"roof\" material: \"concrete\" thickness_m: 0.25 gauss_points: 4\n"
      "cylinder { radius_m: 25 length_m: 25 angle_deg: 40 elements_u: 16 elements_v: 16 degree: 3\n"
      "pose { orientation { w: 0.5792279653395692 x: -0.5792279653395692 y: -0.4055797876726388 z: "
      "-0.4055797876726388 } } }\n"
      "supports { edges: U_MIN kind: SYMMETRY_X }\nsupports { edges: V_MIN kind: SYMMETRY_Y }\n"
      "supports { edges: V_MAX kind: SIMPLY_SUPPORTED axes: X axes: Z } equilibrium {} }\n";
  in_equilibrium(text, [](const ShellModel& m, const ShellState& s) {
    const double arc = m.patch.knots_u.end(), pressure = 360 * 0.25 * 1e-3;
    const int steps = 400;
    double moment = 0.0, force = 0.0;
    for (int i = 0; i < steps; ++i) {
      const Vec2 at((i + 0.5) * arc / steps, 0.0);
      const SurfacePoint x = m.patch.evaluate(at);
      const Vec3 normal = x.u.cross(x.v).normalized();
      auto v = values_at(m, s, at);
      const double length = arc / steps * x.u.norm();
      force += length * v.at("membrane_force_yy");
      moment += length * (v.at("membrane_force_yy") * x.x.z() + v.at("bending_moment_yy") * normal.z());
    }
    const double half = pressure * arc * 50.0 * 50.0 / 8.0;  // of half the section
    EXPECT_NEAR(-moment, half, 1e-3 * half);
    EXPECT_NEAR(force, 0.0, 1e-3 * half / 25.0);
  });
}

// Equal stretch along both axes: the von Mises stress is the stress, and flow keeps the volume.
TEST(Fields, OfAYieldedSheet) {
  ShellMaterial steel = glass();
  steel.poisson_ratio = 0.3, steel.yield_stress = 2e8, steel.hardening_modulus = 1e9;
  const ShellModel m = make_shell("p", plate(0.2, 0.2, 4, 4, Vec3::Zero(), Quat::Identity()), 0.004, steel, 5, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  stretch(m, s, Vec3(1.02, 1.02, 1));
  compute_forces(m, s, false, 1.0, 1);
  auto v = values_at(m, s, Vec2(0.1, 0.1));
  EXPECT_NEAR(v.at("plastic_strain_outside"), 2 * std::log(1.02), 0.15 * 2 * std::log(1.02));  // less what is elastic
  for (const char* place : {"outside", "middle", "inside"}) {
    const double limit = 2e8 + 1e9 * v.at(std::string("plastic_strain_") + place);
    // the stress is that of the strain energy, some per cent beside Hooke's law of the return
    EXPECT_NEAR(v.at(std::string("stress_") + place + "_von_mises"), limit, 0.03 * limit) << place;
  }
  const double elastic = 2 * (1 - 2 * 0.3) * v.at("stress_middle_von_mises") / 70e9;  // growth of the volume
  EXPECT_NEAR(v.at("thickness"), 0.004 / (1.02 * 1.02) * (1 + elastic), 2e-4 * 0.004);
}

// A piece that has moved away as a whole has no stress, on either side of the crack.
TEST(Fields, BesideACrackAreThoseOfTheirSide) {
  const ShellModel m = brittle_sheet();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {Vec2(0.1, -0.01), Vec2(0.1, 0.21)}, 0.0);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.parameter[i].x() > 0.1) s.motion.x[m.tables.slot(i)] += 1.0;
  for (const double u : {0.0999, 0.1001, 0.05, 0.15}) {
    auto v = values_at(m, s, Vec2(u, 0.101));
    EXPECT_NEAR(v.at("stress_outside_von_mises"), 0.0, 70e9 * 1e-8) << u;
    EXPECT_NEAR(v.at("thickness"), 0.004, 1e-8) << u;
  }
}

TEST(Fields, ContactPressureIntegratesToTheForce) {
  const ShellModel m = strip({}, {});
  const ShellState s = make_state(m, Vec3::Zero(), 0);
  ContactOverTime contact{std::vector<double>(s.motion.x.size(), 0.0), 0.5};
  double given = 0.0;
  for (int i = 0; i < m.control_points(); ++i) {
    const double j = 0.01 * (1 + i % 7);
    contact.impulse[2 * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] =
        -j;  // pressed on the outside
    given += j;
  }
  double sum = 0.0;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const GaussPoint g = gauss_point(m.patch, m.tables, q, e);
      sum += g.weight * values_at(m, s, g.parameter, contact).at("contact_pressure");
    }
  EXPECT_NEAR(sum, given / 0.5, 1e-9 * given);
}
