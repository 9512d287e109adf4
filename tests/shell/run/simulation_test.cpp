// How a simulation starts: what it measures, and what it refuses.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/run/simulation.h"
#include "shell/solver/finite.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"
#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

RunSetup pane() {
  RunSetup s = setup_of({{brittle_sheet(8)}});
  s.window = s.tick = 1e-3;
  return s;
}

/// What start_shells() says, or an empty text.
std::string refusal(RunSetup setup) {
  for (ShellSetup& s : setup.shells) s.hertz.resize(setup.bodies.size(), 0.0);
  Simulation simulation(setup, 1);
  simulation.prepare();
  try {
    simulation.start_shells([] {});
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

}  // namespace

TEST(Simulation, MeasuresTheStableStepOfAShellThatMayCrackAsIfItWereFree) {
  for (const bool cracks : {false, true}) {
    RunSetup setup = pane();
    Support clamp;
    clamp.edges = kUMin | kUMax | kVMin | kVMax;
    setup.shells[0].model =
        make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {clamp});
    setup.shells[0].fracture.mode = cracks ? FractureMode::kTips : FractureMode::kNone;
    Simulation simulation(setup, 1);
    simulation.prepare();
    simulation.start_shells([] {});
    const ShellPart& part = simulation.state.shells[0];
    ShellState s = make_state(part.model(), Vec3::Zero(), 0);
    EXPECT_EQ(part.initial_step, stable_step(part.model(), s, kStepIterations, 1, cracks));
    const double step = simulation.substep_length(0);
    EXPECT_NEAR(step, setup.safety * (cracks ? kCrackedStep : 1.0) * part.initial_step, 1e-15);
    const double substeps = simulation.substeps_of_tick(step, 0);
    EXPECT_EQ(substeps, std::ceil(1e-3 / step));
  }
}

TEST(Simulation, RefusesStepsAndWindowsThatDoNotFit) {
  EXPECT_EQ(refusal(pane()), "");
  RunSetup fine = pane();
  fine.time_step = 1e-8;
  EXPECT_EQ(refusal(fine), "");
  RunSetup coarse = pane();
  coarse.time_step = 1e-3;
  const std::string said = refusal(coarse);
  EXPECT_TRUE(says(said, "time_step_s is 0.001 s") && says(said, "with a margin at most")) << said;
  RunSetup brief = pane();
  brief.window = brief.tick = 1e-9;
  EXPECT_TRUE(says(refusal(brief), "window_s is 1e-09 s, shorter than the stable step of the shell"));
  Simulation simulation(fine, 1);
  try {
    simulation.substeps_of_tick(1e-12, 4);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "substeps");
    EXPECT_EQ(e.window, 4);
  }
}

TEST(Simulation, RefusesAShellThatCannotMoveAndABodyThatWouldPassThrough) {
  RunSetup held = pane();
  Support everywhere;
  everywhere.regions = {{Vec2(-1, -1), Vec2(1, 1)}};
  held.shells[0].model =
      make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {everywhere});
  EXPECT_TRUE(says(refusal(held), "shell 'p': every control point is held"));
  RunSetup shot = pane();
  RigidBody b;
  b.id = 1, b.name = "bullet", b.mass = 0.01, b.principal_inertia = Vec3::Constant(1e-7), b.shape = SphereShape{0.002};
  b.motion.position = Vec3(0, 0, 0.1), b.motion.velocity = Vec3(0, 0, -300);
  shot.bodies = {b};
  EXPECT_EQ(refusal(shot), "");
  shot.bodies[0].motion.velocity.z() = -1e5;
  EXPECT_TRUE(says(refusal(shot), "body 'bullet' moves"));
}

// A sheet sags in equilibrium, by 4 mm at the middle, towards another one with fibres.
TEST(Simulation, RefusesAnEquilibriumInWhichLayersWithFibresOverlap) {
  const auto sagging = [](double gap, bool fibres, double gravity) {
    Support held;
    held.edges = kUMin | kUMax | kVMin | kVMax;
    ShellMaterial m;
    m.density = 1000, m.youngs_modulus = 1e7, m.poisson_ratio = 0.3;
    RunSetup out;
    for (const double z : {0.0, -gap}) {
      ShellSetup s{make_shell(z == 0.0 ? "upper" : "lower", plate(0.2, 0.2, 8, 8, Vec3(0, 0, z), Quat::Identity()),
                              0.004, m, 2, 2, {held})};
      if (fibres) s.model.fibres = {1e5, 1e5, 0.5};
      s.equilibrium = z == 0.0 ? 1e-8 : 0.0;
      out.shells.push_back(std::move(s));
    }
    out.gravity = Vec3(0, 0, -gravity);
    out.fibre_spacing = fibres ? 0.03 : 0.0;
    out.window = out.tick = 1e-2;
    return out;
  };
  RunSetup alone = sagging(1.0, true, 9.81);
  Simulation still(alone, 1);
  still.prepare();
  still.start_shells([] {});
  const ShellState& upper = *still.state.shells[0].state;
  double sag = 0.0;
  for (int i = 0; i < alone.shells[0].model.control_points(); ++i)
    sag = std::max(sag, -upper.position(alone.shells[0].model.tables.slot(i)).z());
  EXPECT_GT(sag, 1e-3);
  const std::string said = refusal(sagging(0.004 + 0.5 * sag, true, 9.81));
  EXPECT_TRUE(says(said, "overlaps a layer with fibres at (") && says(said, "lower the load")) << said;
  EXPECT_TRUE(says(said, "shell 'upper'") || says(said, "shell 'lower'")) << said;
  EXPECT_EQ(refusal(sagging(0.004 + 0.5 * sag, false, 9.81)), "");  // without fibres nothing is left out
  EXPECT_EQ(refusal(sagging(0.004 + 0.5 * sag, true, 0.981)), "");  // the first remedy: a lower load
  EXPECT_EQ(refusal(sagging(0.004 + 1.5 * sag, true, 9.81)), "");   // and the other: farther apart
}

// The fibres of layers that are apart bear nothing, so the equilibrium is that without them, to the last bit.
TEST(Simulation, FindsTheSameEquilibriumWithFibres) {
  const auto positions = [](bool fibres) {
    Support held;
    held.edges = kUMin | kVMax;
    RunSetup setup = pane();
    setup.shells[0].model =
        make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {held});
    setup.shells[0].equilibrium = 1e-8, setup.gravity = Vec3(0, 0, -9.81);
    if (fibres) setup.shells[0].model.fibres = {1e5, 1e5, 0.5}, setup.fibre_spacing = 0.03;
    Simulation simulation(setup, 1);
    simulation.prepare();
    simulation.start_shells([] {});
    EXPECT_EQ(simulation.state.fibres != nullptr, fibres);
    return std::vector<double>(simulation.state.shells[0].state->motion.x.begin(),
                               simulation.state.shells[0].state->motion.x.end());
  };
  EXPECT_EQ(positions(true), positions(false));
}

// Within kFiniteInterval substeps of a window of a hundred: where it is, in which shell, and when.
TEST(Simulation, FindsABadNumberWithinAFewSubsteps) {
  RunSetup two = setup_of({{brittle_sheet(8)}, {brittle_sheet(8)}});
  two.shells[1].model.name = "q";
  Rig rig(std::move(two));
  constexpr double kStep = 1e-7;  // [s]
  constexpr int kSubsteps = 100, kBad = 2, kPoint = 37;
  const ShellModel& m = rig.model(1);
  const Vec2 place = m.parameter[kPoint];
  int done = 0;
  try {
    rig.run(kSubsteps, kStep, [&] {
      if (++done == kBad) rig.state(1).motion.x[m.tables.slot(kPoint)] = std::numeric_limits<double>::quiet_NaN();
    });
    FAIL() << "nothing was found";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "unstable");
    EXPECT_EQ(e.window, 0);
    // Forces have carried it on to its neighbours by then: the place is the first of them, within the reach of one
    // element a substep.
    double u = 0.0, v = 0.0, time = 0.0;
    ASSERT_EQ(std::sscanf(e.what(), "shell 'q' is unstable: at (u, v) = (%lf, %lf) and %lf s", &u, &v, &time), 3)
        << e.what();
    EXPECT_NEAR(time, (done + 1) * kStep, 1e-15);
    EXPECT_LE((Vec2(u, v) - place).lpNorm<Eigen::Infinity>(), kFiniteInterval * 2.0 * 0.2 / 8) << e.what();
  }
  EXPECT_LE(done, kBad + kFiniteInterval);
}

// In the soft bodies' next step, which spans several substeps: which body, and where the particle was made.
TEST(Simulation, FindsABadParticleOfASoftBodyInItsNextStep) {
  RunSetup sheet = setup_of({{brittle_sheet(8)}});
  for (const bool place : {false, true}) {
    Rig rig(sheet);
    const SoftSetup block = soft_blocks::block(Vec3::Constant(0.02), soft_blocks::at({0.0, 0.0, 1.0}), 0.01);
    rig.now().soft = SoftBodies({block}, 1, soft_blocks::laws(0.0));
    constexpr double kStep = 1e-7;  // [s]
    constexpr int kSubsteps = 10'000, kBad = 2, kParticle = 17;
    const int spanned = static_cast<int>(rig.now().soft.stable_step() / kStep);
    ASSERT_LT(kBad + spanned, kSubsteps);
    int done = 0;
    try {
      rig.run(kSubsteps, kStep, [&] {
        SoftState& soft = rig.now().soft.states()[0];
        if (++done == kBad)
          (place ? soft.x[kParticle].y() : soft.f[kParticle](1, 1)) = std::numeric_limits<double>::quiet_NaN();
      });
      FAIL() << "nothing was found";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind, "unstable");
      EXPECT_EQ(e.window, 0);
      EXPECT_EQ(std::string(e.what()).rfind("soft body 'block' is unstable: at ", 0), 0u) << e.what();
      EXPECT_TRUE(says(e.what(), "lower time_step_safety")) << e.what();
    }
    EXPECT_LE(done, kBad + spanned);
  }
}

TEST(Simulation, FindsTheLawOfTwoGroupsInEitherOrder) {
  RunSetup setup = pane();
  setup.shells[0].model.contact_group = 3;
  RigidBody b;
  b.contact_group = 5;
  Simulation simulation(setup, 1);
  EXPECT_EQ(simulation.contact_law(setup.shells[0].model, b).friction, 0.5);  // without a law
  for (const auto& [first, second] : {std::pair(3u, 5u), {5u, 3u}}) {
    setup.laws = {{1, 5, 0.9, 0.9}, {first, second, 0.25, 0.75}};
    EXPECT_EQ(simulation.contact_law(setup.shells[0].model, b).friction, 0.25);
    EXPECT_EQ(simulation.contact_law(setup.shells[0].model, b).restitution, 0.75);
  }
}

// By its radius and the least thickness: 2 mm and 1 mm, where the shell is 4 mm thick elsewhere.
TEST(Simulation, LetsABodyMoveInASubstepByWhatTheThinnestPlaceAllows) {
  RunSetup shot = pane();
  shot.shells[0].model = make_shell("p", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2,
                                    {}, {}, {}, [](const Patch&, const Vec2& p) { return p.x() < 0.1 ? 1.0 : 0.25; });
  ShellState s = make_state(shot.shells[0].model, Vec3::Zero(), 0);
  const double step =
      stable_step(shot.shells[0].model, s, kStepIterations, 1, shot.shells[0].fracture.mode != FractureMode::kNone);
  RigidBody b;
  b.id = 1, b.name = "bullet", b.mass = 0.01, b.principal_inertia = Vec3::Constant(1e-7), b.shape = SphereShape{0.002};
  b.motion.position = Vec3(0, 0, 0.1);
  for (const double share : {0.99, 1.01}) {
    b.motion.velocity = Vec3(0, 0, -share * 0.003 / (shot.safety * step));
    shot.bodies = {b};
    EXPECT_EQ(says(refusal(shot), "body 'bullet' moves"), share > 1.0) << share;
  }
}
