// Supports by boxes and cuts by lines in space, on shells of several charts.
#include "shell/io/space_places.h"

#include "shell/io/probes.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/io/mesh_scene.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kRadius = 0.5;

class SpacePlaces : public MeshScene {
 protected:
  RunSetup globe(const std::string& in_shell, const std::string& after = "",
                 const std::string& in_material = "") const {
    write("a.obj", ball(kRadius, 8));
    return setup("path: 'a.obj' element_m: 0.08", in_shell, after, in_material);
  }
  std::string told(const std::string& in_shell, const std::string& after = "") const {
    write("a.obj", ball(kRadius, 8));
    return refusal("path: 'a.obj' element_m: 0.08", in_shell, after);
  }
};

Vec3 place_of(const ShellModel& m, int point) {
  return m.patch.evaluate(m.trim.empty() ? m.parameter[point] : m.trim.home[point]).x;
}

struct Sums {
  Vec3 momentum = Vec3::Zero(), borne = Vec3::Zero();
  double mass = 0.0, scale = 0.0;
};

Sums sums_of(const Rig& rig) {
  Sums out;
  for (std::size_t k = 0; k < rig.size(); ++k) {
    const Totals t = totals(rig.model(k), rig.state(k));
    out.momentum += t.momentum, out.mass += t.mass, out.scale += t.momentum_scale;
    for (const Constraints::Part& part : rig.model(k).constraints.parts)
      out.borne += support_impulse(rig.state(k), part), out.scale += support_impulse(rig.state(k), part).norm();
  }
  return out;
}

void measure_supports(Rig& rig) {
  for (std::size_t k = 0; k < rig.size(); ++k)
    rig.state(k).motion.support_impulse.assign(rig.state(k).motion.v.size(), 0.0);
}

double step_of(const Rig& rig) {
  const ShellModel& m = rig.model();
  return 0.1 * m.spacing / m.wave_speed();
}

TEST_F(SpacePlaces, ABoxHoldsWhatLiesInItOfAllCharts) {
  const RunSetup r = globe("supports { boxes { z { high: -0.4 } x { low: -9 } } kind: CLAMPED }");
  ASSERT_EQ(r.shells.size(), 2u);
  for (const ShellSetup& s : r.shells) {
    const ShellModel& m = s.model;
    int held = 0;
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      if (m.trim.drops(slot)) continue;
      EXPECT_EQ(m.held[slot] != 0, place_of(m, i).z() <= -0.4 + 1e-5);
      held += m.held[slot];
    }
    EXPECT_GT(held, 5);
    ASSERT_EQ(m.constraints.parts.size(), 1u);
    EXPECT_EQ(m.constraints.parts[0].name, "support_0_box_0");
    EXPECT_EQ(m.constraints.parts[0].slots[0].size(), static_cast<std::size_t>(held));
  }
  // a part for each box that takes something of a chart, and none for others
  const RunSetup two = globe(
      "supports { boxes { x { high: -0.45 } } kind: CLAMPED } supports { boxes { x { low: 0.45 } } boxes { y { low: "
      "0.45 } } kind: SIMPLY_SUPPORTED axes: Z }");
  int parts = 0;
  for (const ShellSetup& s : two.shells)
    for (const Constraints::Part& part : s.model.constraints.parts) {
      ++parts;
      EXPECT_TRUE(std::any_of(part.slots.begin(), part.slots.end(), [](const auto& own) { return !own.empty(); }));
    }
  EXPECT_GE(parts, 3);
}

TEST_F(SpacePlaces, BoxesThatAreWrongAreRefused) {
  const auto box = [&](const std::string& text, const std::string& kind = "CLAMPED") {
    return told("supports { boxes { " + text + " } kind: " + kind + " }");
  };
  expect_part(box("z { low: 0.6 }"),
              "shells[0].supports[0].boxes[0]: holds no control point of shell 'pane', which reaches from (-0.4");
  expect_part(box(""), "shells[0].supports[0].boxes[0]: has no limit, so it would hold all of the shell");
  expect_part(box("z { low: 0.4 high: 0.3 }"), "boxes[0].z: runs from 0.4 m up to 0.3 m, which is lower");
  expect_part(box("z { low: nan }"), "boxes[0].z.low: is nan; must be finite, or left out");
  expect_part(box("y { high: inf }"), "boxes[0].y.high: is inf; must be finite, or left out");
  expect_part(box("z { low: -9 }"), "shells[0].supports: hold every control point of shell 'pane'");
  expect_part(box("z { low: 0 }", "SYMMETRY_X"), "no corners, regions, boxes or motion");
  expect_part(
      told("supports { boxes { z { low: 0.4 } } kind: CLAMPED motion { } motion { time_s: 1 displacement { z: 1 } } }"),
      "lies at a seam along a trim; hold another part");
}

// What supports bear of the weight, of a ball that hits the globe, and over ties between control points that they hold
// and others.
TEST_F(SpacePlaces, ImpulsesOfBoxesCloseTheBalanceOfMomentum) {
  for (const char* kind : {"kind: CLAMPED", "kind: SIMPLY_SUPPORTED axes: Z"}) {
    SCOPED_TRACE(kind);
    RunSetup setup =
        globe(fmt::format("supports {{ boxes {{ z {{ high: -0.35 }} }} {} }}", kind),
              "bodies { name: 'ball' material: 'glass' sphere { radius_m: 0.1 } pose { position { z: 0.606 } } "
              "twist { linear { x: 2 z: -5 } } }\ngravity { x: 3 z: -9.81 }");
    const Vec3 gravity(3.0, 0.0, -9.81);
    Rig rig(std::move(setup));
    measure_supports(rig);
    const double dt = step_of(rig);
    constexpr int kSteps = 1200;
    const Sums before = sums_of(rig);
    const Proxy thrown = rig.body();
    rig.run(kSteps, dt);
    const Sums after = sums_of(rig);
    ASSERT_GT(rig.body().impulse_sum, 0.1);
    EXPECT_GT(after.borne.norm(), 1e-3);
    const double time = kSteps * dt;
    const Vec3 to_ball =
        rig.body().body.mass * (rig.body().body.motion.velocity - thrown.body.motion.velocity - time * gravity);
    const Vec3 given = after.mass * time * gravity + after.borne;
    EXPECT_LT((after.momentum - before.momentum + to_ball - given).norm(),
              1e-9 * (after.scale + rig.body().impulse_sum));
  }
}

// Whole edges at sharp creases: a box of six shells. Its floor is held as a whole, and so are strips of its sides.
TEST_F(SpacePlaces, ABoxMayHoldAWholeShellOfSeveral) {
  write("a.off",
        "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n"
        "4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
  RunSetup setup = this->setup("path: 'a.off' element_m: 0.2", "supports { boxes { z { high: 0.25 } } kind: CLAMPED }",
                               "bodies { name: 'ball' material: 'glass' sphere { radius_m: 0.15 } pose { position { x: "
                               "0.4 y: 0.5 z: 1.156 } } twist { linear { x: 2 z: -5 } } }\ngravity {}");
  int whole = 0;
  for (std::size_t k = 0; k < setup.shells.size(); ++k) {
    whole += setup.shells[k].model.wholly_held();
    EXPECT_EQ(steps_as_if_free(setup, k), setup.shells[k].model.wholly_held());
  }
  EXPECT_EQ(whole, 1);
  Rig rig(std::move(setup));
  measure_supports(rig);
  const double dt = step_of(rig);
  const Sums before = sums_of(rig);
  const Proxy thrown = rig.body();
  rig.run(1500, dt);
  const Sums after = sums_of(rig);
  ASSERT_GT(rig.body().impulse_sum, 0.1);
  const Vec3 to_ball = rig.body().body.mass * (rig.body().body.motion.velocity - thrown.body.motion.velocity);
  EXPECT_LT((after.momentum - before.momentum + to_ball - after.borne).norm(),
            1e-9 * (after.scale + rig.body().impulse_sum));
}

// The globe is released where its charts are tied. Its velocity stays continuous, and it then falls as a whole.
TEST_F(SpacePlaces, ABoxIsReleasedOverATie) {
  RunSetup setup = globe("supports { boxes { z { high: -0.35 } } kind: CLAMPED until_s: 1e-3 }\nvelocity { y: 2 }",
                         "gravity { x: 3 z: -9.81 }");
  for (const ShellSetup& s : setup.shells) ASSERT_EQ(s.model.releases.size(), 1u);
  const Vec3 gravity(3.0, 0.0, -9.81);
  Rig rig(std::move(setup));
  const double dt = step_of(rig);
  rig.run(200, dt);
  const auto energy = [&] {
    double sum = rig.simulation().total_energy(dt);
    for (std::size_t k = 0; k < rig.size(); ++k) sum -= rig.state(k).book.external;
    return sum;
  };
  const double stored = energy();
  const Sums before = sums_of(rig);
  ASSERT_TRUE(rig.simulation().release_supports(1e-3, 0.0, dt));
  // the forces of ties change at once, and half a kick with them, of which this is the energy
  EXPECT_NEAR(energy(), stored, 1e-6 * std::abs(stored));
  EXPECT_LT((sums_of(rig).momentum - before.momentum).norm(), 1e-12 * before.scale);
  rig.run(400, dt);
  const Sums after = sums_of(rig);
  EXPECT_LT((after.momentum - before.momentum - 400 * dt * after.mass * gravity).norm(), 1e-10 * after.scale);
  EXPECT_NEAR(energy(), stored, 1e-3 * std::abs(stored));
  for (std::size_t k = 0; k < rig.size(); ++k)
    for (int i = 0; i < rig.model(k).control_points(); ++i) {
      const int slot = rig.model(k).tables.slot(i);
      EXPECT_TRUE(rig.model(k).trim.drops(slot) || rig.state(k).motion.inverse_mass[slot] > 0.0);
    }
}

// Kinetic energy of both halves that fly apart at once, over what it was. Cuts are made before.
double kept_apart(RunSetup setup, double height) {
  Rig rig(std::move(setup));
  for (ShellPart& part : rig.now().shells) {
    part.state->cracks.cut_done.assign(part.setup->fracture.cuts.size(), 0);
    part.cut(0.0, 1.0, rig.now().random);
  }
  const double dt = step_of(rig);
  rig.run(4, dt);
  const auto kinetic = [&] {
    double sum = 0.0;
    for (std::size_t k = 0; k < rig.size(); ++k)
      for (int i = 0; i < rig.model(k).control_points(); ++i) {
        const int slot = rig.model(k).tables.slot(i);
        sum += 0.5 * rig.state(k).motion.mass[slot] * rig.state(k).velocity(slot).squaredNorm();
      }
    return sum;
  };
  for (std::size_t k = 0; k < rig.size(); ++k)
    for (int i = 0; i < rig.model(k).control_points(); ++i)
      rig.state(k).add_velocity(rig.model(k).tables.slot(i),
                                Vec3(0.0, 0.0, place_of(rig.model(k), i).z() > height ? 1.0 : -1.0));
  const double before = kinetic();
  rig.run(400, dt);
  return kinetic() / before;
}

std::string line(const std::string& points, const std::string& more = "") {
  return "cuts { line { " + points + " } " + more + " }";
}

std::string circle_of_points(int count, double z) {
  std::string out;
  for (int k = 0; k <= count; ++k) {
    const double a = 2.0 * M_PI * (k % count) / count, r = std::sqrt(kRadius * kRadius - z * z);
    out += fmt::format("points {{ x: {:.12g} y: {:.12g} z: {:.12g} }} ", r * std::cos(a), r * std::sin(a), z);
  }
  return out;
}

TEST_F(SpacePlaces, ALineIsCutOnAllChartsThatItPasses) {
  const RunSetup r = globe(line(circle_of_points(40, 0.1)), "fracture { mode: CUTS }");
  double length = 0.0;
  for (const ShellSetup& s : r.shells)
    for (const PrescribedCut& cut : s.fracture.cuts)
      for (const std::vector<Vec2>& points : cut.lines)
        for (std::size_t k = 1; k < points.size(); ++k)
          length += (s.model.patch.evaluate(points[k]).x - s.model.patch.evaluate(points[k - 1]).x).norm();
  EXPECT_NEAR(length / (2.0 * M_PI * std::sqrt(kRadius * kRadius - 0.01)), 1.0, 0.02);
}

TEST_F(SpacePlaces, ALinePartsTheShellOverTies) {
  const std::string apart = "fracture { mode: CUTS interlock: false }";
  EXPECT_GT(kept_apart(globe(line(circle_of_points(40, 0.1)), apart), 0.1), 0.99);
  EXPECT_LT(kept_apart(globe("", apart), 0.1), 0.9);
}

// A line that grows is cut from its begin to its end, over charts too.
TEST_F(SpacePlaces, ALineGrowsOverCharts) {
  const RunSetup r = globe(line(circle_of_points(40, 0.1), "time_s: 0.1 until_s: 0.5"), "fracture { mode: CUTS }");
  std::vector<std::pair<double, Vec3>> ends;
  int open = 0;
  for (const ShellSetup& s : r.shells)
    for (const PrescribedCut& cut : s.fracture.cuts) {
      ends.emplace_back(cut.time, s.model.patch.evaluate(cut.lines.back().back()).x);
      open += !cut.goes_on;
      EXPECT_EQ(cut.number, 0);
    }
  EXPECT_EQ(open, 1);
  for (const auto& [time, x] : ends) {
    const double angle = std::atan2(x.y(), x.x()), turn = angle <= 1e-6 ? angle + 2.0 * M_PI : angle;
    EXPECT_NEAR(time, 0.1 + 0.4 * turn / (2.0 * M_PI), 0.4 * 0.03);
  }
}

TEST_F(SpacePlaces, LinesThatAreWrongAreRefused) {
  const auto cut = [&](const std::string& points, const std::string& more = "") {
    return told(line(points, more), "fracture { mode: CUTS }");
  };
  expect_part(cut("points { z: 0.5 }"), "shells[0].cuts[0].line.points: has 1 of them; a line has two or more");
  expect_part(cut("points { z: 0.5 } points { z: 0.5 }"), "line.points[1]: is where the point before it is");
  expect_part(cut("points { z: inf } points { z: 0.5 }"), "line.points[0]: is (0, 0, inf); must be finite");
  expect_part(cut("points { z: 0.5 } points { z: 0.9 }"),
              "line.points[1]: is 0.4 m from the surface, more than an element");
  expect_part(cut("points { z: 0.5 } points { z: -0.5 }"), "line: passes from");
  expect_part(cut("points { z: 0.5 } points { z: 1e9 }"), "line: is 1e+09 m long");
  expect_part(told("cuts { line { points { z: 0.5 } points { x: 0.5 } } points { u: 1 } points { u: 2 } }"),
              "cuts[0].points: are given, and so is a curve; give one of them");
  expect_part(
      cut("points { x: 0.2 z: 0.458 } points { x: -0.2 z: 0.458 } points { y: 0.2 z: 0.458 } points { y: -0.2 z: "
          "0.458 }"),
      "line: meets itself at");
}

}  // namespace
