// Scenes in which nothing moves, and load steps.
#include <cmath>

#include "shell/run/simulation.h"
#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace sunder::shell;
using small_scene::expect_refusal;
using small_scene::replaced;

namespace {

// A cantilever of 10 m x 1 m x 0.1 m under end shear of up to 4 N (Sze, Liu, Lo 2004, 3.1).
const std::string kCantilever = R"(name: "cantilever"
gravity { z: 0 }
materials { name: "m" density: 1 youngs_modulus: 1.2e6 poisson_ratio: 0 }
shells {
  name: "plate" material: "m" thickness_m: 0.1
  plate { size_x_m: 10 size_y_m: 1 elements_x: 24 elements_y: 1 degree: 3 }
  supports { edges: U_MIN kind: CLAMPED }
  loads { edge_force { edge: U_MAX force_per_length { z: 4 } } }
  equilibrium { load_factors: [0.1, 0.2, 0.5, 1, 0.5] }
}
output { probes { name: "tip" shell: "plate" at { u: 10 v: 0.5 } } }
)";

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

RunSetup setup_of(const std::string& text) {
  const std::string path = small_scene::own_file("statics_test.textproto");
  std::ofstream(path) << text;
  RunSetup setup = build(scene::load(path, {}));
  std::remove(path.c_str());
  return setup;
}

/// Calls `look` with the shell after each step.
template <class F>
void step_through(RunSetup& setup, F&& look) {
  Simulation simulation(setup, 1);
  simulation.prepare();
  simulation.make_states();
  for (int k = 0; k < setup.steps; ++k) {
    simulation.find_equilibria(k, [] {});
    look(k, simulation, simulation.state.shells[0]);
  }
}

}  // namespace

TEST(LoadSteps, OfACantileverUnderEndShearAreThePublishedDeflections) {
  RunSetup setup = setup_of(kCantilever);
  ASSERT_EQ(setup.steps, 5);
  const double in[] = {0.103, 0.381, 1.604, 3.286, 1.604}, up[] = {1.309, 2.493, 4.933, 6.698, 4.933};
  step_through(setup, [&](int k, Simulation&, ShellPart& part) {
    const Vec3 u = displacement(part.model(), *part.state, setup.probes[0].at);
    EXPECT_NEAR(u.x(), -in[k], 4e-3) << k;  // the published grid of 16 elements leaves a thousandth
    EXPECT_NEAR(u.z(), up[k], 4e-3) << k;
    EXPECT_EQ(part.steps.size(), static_cast<std::size_t>(k + 1));
    EXPECT_TRUE(part.steps.back().converged);
  });
}

TEST(LoadSteps, ScaleWeightAndMotionOfSupportsToo) {
  std::string text = changed(kCantilever, "gravity { z: 0 }", "gravity { z: -2 }");
  text = changed(text, "loads { edge_force { edge: U_MAX force_per_length { z: 4 } } }",
                 "supports { edges: U_MAX kind: SIMPLY_SUPPORTED axes: Z motion { displacement { z: 0.01 } } }");
  RunSetup setup = setup_of(text);
  const double factors[] = {0.1, 0.2, 0.5, 1, 0.5};
  step_through(setup, [&](int k, Simulation& simulation, ShellPart& part) {
    EXPECT_NEAR(displacement(part.model(), *part.state, setup.probes[0].at).z(), 0.01 * factors[k], 1e-12);
    const Vec3 gravity = simulation.gravity_on(part);
    EXPECT_EQ(gravity.z(), -2.0 * factors[k]);
    // the weight of 1 kg/m^3 over 10 m x 1 m x 0.1 m rests on both ends
    EXPECT_NEAR(reaction(part.model(), *part.state, gravity).z(), 2.0 * factors[k], 1e-5 * factors[k]);
  });
}

TEST(Statics, ASceneWithoutTimeHasOneEquilibrium) {
  const std::string text = changed(kCantilever, "load_factors: [0.1, 0.2, 0.5, 1, 0.5]", "");
  RunSetup setup = setup_of(text);
  EXPECT_EQ(setup.steps, 1);
  step_through(setup, [&](int, Simulation&, ShellPart& part) {
    EXPECT_NEAR(displacement(part.model(), *part.state, setup.probes[0].at).z(), 6.698, 2e-3);
  });
}

TEST(Statics, WhatMovesIsRefused) {
  expect_refusal("end_time_s: 1\n" + kCantilever, "end_time_s", {"load_factors", "leave it out"});
  expect_refusal("window_s: 1\n" + kCantilever, "window_s", {"load_factors", "leave it out"});
  expect_refusal("local_time_steps: true\n" + kCantilever, "local_time_steps", {"nothing moves", "leave it out"});
  expect_refusal(
      kCantilever + "bodies { name: \"b\" material: \"m\" sphere { radius_m: 1 } pose { position { z: 9 } } }",
      "bodies[0]", {"load_factors"});
  expect_refusal(changed(kCantilever, "output {", "output { frame_interval_s: 1 "), "output.frame_interval_s",
                 {"nothing moves"});
  expect_refusal(changed(kCantilever, "z: 4 } }", "z: 4 } } factor { value: 1 }"), "shells[0].loads[0].factor",
                 {"load_factors"});
  expect_refusal(changed(kCantilever, "kind: CLAMPED",
                         "kind: CLAMPED motion { displacement { z: 1 } } motion { time_s: 1 displacement { z: 2 } }"),
                 "shells[0].supports[0].motion", {"2 points", "give one point"});
  expect_refusal(changed(kCantilever, "0.2, 0.5", "0.2, nan"), "shells[0].equilibrium.load_factors[2]", {"nan"});
  const std::string other =
      "shells { name: \"q\" material: \"m\" thickness_m: 0.1 plate { size_x_m: 1 size_y_m: 1 "
      "elements_x: 4 elements_y: 4 pose { position { z: 9 } } } equilibrium { load_factors: 1 } }";
  expect_refusal(kCantilever + other, "shells[1].equilibrium.load_factors", {"has 1 factors", "'plate' has 5"});
}
