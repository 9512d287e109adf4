// One shell of a run: its cuts, its stable step, and its pieces.
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/run/part.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/parting/pieces.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/damaging_panel.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// A sheet of 20 cm about the origin, with a Hertz stiffness against one body.
struct Sheet {
  ShellSetup setup;
  ShellPart part{setup};

  explicit Sheet(double hertz = 0.0) : setup{brittle_sheet(10)} {
    setup.hertz = {hertz};
    part.state = std::make_unique<ShellState>(make_state(setup.model, Vec3::Zero(), 1));
  }
  Sheet(const Sheet&) = delete;
  void cut(const std::vector<Vec2>& line) { insert_polyline(setup.model, *part.state, line, 0.0); }
};

const std::vector<Vec2> kTriangle = {{0.05, 0.1}, {0.15, 0.1}, {0.1, 0.17}, {0.05, 0.1}};

std::vector<Proxy> falling_balls(double height, double speed) {
  RigidBody b;
  b.id = 1, b.name = "ball", b.mass = 0.03, b.principal_inertia = Vec3::Constant(1e-6), b.shape = SphereShape{0.01};
  b.motion.position = {0.0, 0.0, height}, b.motion.velocity = {0.0, 0.0, -speed};
  return {Proxy(b)};
}

}  // namespace

TEST(ShellPart, ItsBoxIsThatOfWhatHasNotLeft) {
  Sheet sheet;
  const ShellModel& m = sheet.part.model();
  EXPECT_NEAR(sheet.part.box().min().x(), -0.1, 1e-12);
  EXPECT_NEAR(sheet.part.box().max().x(), 0.1, 1e-12);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.rest[m.tables.slot(i)] > 0.0) sheet.part.state->motion.detached[m.tables.slot(i)] = 1;
  EXPECT_NEAR(sheet.part.box().min().x(), -0.1, 1e-12);
  EXPECT_LE(sheet.part.box().max().x(), 0.0);
}

TEST(ShellPart, CutsWhatIsDueAndTellsWhichSeamsOpen) {
  Sheet sheet;
  sheet.setup.fracture.cuts = {
      {.lines = {{{0.03, 0.05}, {0.12, 0.09}}}, .on_edges = {{kVMax, 0.0, 0.5}}, .time = 1e-3}};
  sheet.part.state->cracks.cut_done.assign(1, 0);
  std::uint64_t random = 1;
  EXPECT_TRUE(sheet.part.cut(0.0, 0.5e-3, random).empty());
  EXPECT_TRUE(sheet.part.state->cracks.graph.edges().empty());
  const std::vector<EdgeCut> open = sheet.part.cut(0.75e-3, 0.5e-3, random);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].edge, kVMax);
  EXPECT_FALSE(sheet.part.state->cracks.graph.edges().empty());
}

TEST(ShellPart, ThatCanCrackStepsAsIfItHadCracks) {
  Sheet sheet;
  sheet.part.initial_step = 2.0, sheet.part.smallest_step = 1.9;
  EXPECT_EQ(sheet.part.step(), 1.9);
  sheet.setup.fracture.mode = FractureMode::kTips, sheet.setup.cracked_step = 0.75;
  EXPECT_EQ(sheet.part.step(), 1.5);
  sheet.part.smallest_step = 1.2;
  EXPECT_EQ(sheet.part.step(), 1.2);
}

TEST(ShellPart, MeasuresItsStepWhereCracksAreNewAndNotInEachWindow) {
  Sheet sheet;
  ShellPart& part = sheet.part;
  part.initial_step = part.smallest_step = 1.0;  // of no shell
  part.measure_step(0, 1, {});
  EXPECT_EQ(part.smallest_step, 1.0);  // there is no crack
  sheet.cut({{0.05, 0.05}, {0.1, 0.06}});
  part.measure_step(0, 1, {});
  EXPECT_LT(part.smallest_step, 1e-4);
  EXPECT_GT(part.smallest_step, 0.0);
  EXPECT_TRUE(part.changed.empty());
  const double first = part.smallest_step;
  sheet.cut({{0.05, 0.15}, {0.1, 0.16}});
  for (std::int64_t window = 1; window < kStepWindows; ++window) part.measure_step(window, 1, {});
  EXPECT_FALSE(part.changed.empty());  // it waits
  part.measure_step(kStepWindows, 1, {});
  EXPECT_TRUE(part.changed.empty());
  EXPECT_LE(part.smallest_step, first);
}

// What is squeezed is stiffer and shorter. Turning, moving and stretching the sheet do nothing.
TEST(ShellPart, MeasuresItsStepAgainWhereItIsSqueezed) {
  Sheet sheet;
  ShellPart& part = sheet.part;
  const ShellModel& m = part.model();
  ShellState& s = *part.state;
  const std::vector<double> rest = s.motion.x;
  const std::size_t stride = m.tables.component_stride;
  const auto squeeze = [&](double along, double from) {  // beyond x = from
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = m.tables.slot(i);
      const double x = rest[slot], shift = x > from ? (along - 1.0) * (x - from) : 0.0;
      s.motion.x[slot] = rest[stride + slot], s.motion.x[stride + slot] = 3.0 + x + shift;
    }
  };
  const double intact = stable_step(m, s, kStepIterations, 1, false);
  part.initial_step = part.smallest_step = intact;
  for (const double none : {1.0, 1.5, 0.96}) {
    squeeze(none, -1.0);
    part.measure_step(0, 1, {});
    EXPECT_EQ(part.smallest_step, intact) << none;
  }
  for (const double along : {0.7, 0.5}) {
    squeeze(along, 0.02);
    part.measure_step(0, 1, {});
    const double whole = stable_step(m, s, kStepIterations, 1, false);
    EXPECT_LT(whole, 0.8 * intact);
    EXPECT_NEAR(part.smallest_step, whole, 0.05 * whole) << along;
    EXPECT_TRUE(part.changed.empty());
  }
  part.smallest_step = 1.0;
  part.measure_step(100, 1, {});  // not squeezed further
  EXPECT_EQ(part.smallest_step, 1.0);
  squeeze(0.47, 0.02);
  part.measure_step(101, 1, {});
  EXPECT_LT(part.smallest_step, intact);
}

// Control points that move past one another across a crack are no squeezed shell, nor are those of pieces that have
// left, nor those of rubble.
TEST(ShellPart, IsNotSqueezedWhereACrackPassesOrAPieceHasLeftOrThereIsRubble) {
  enum { kCracked, kLeft, kRubble };
  for (const int how : {kCracked, kLeft, kRubble}) {
    Sheet sheet;
    ShellPart& part = sheet.part;
    ShellState& s = *part.state;
    const ShellModel& m = part.model();
    const RowTables& t = m.tables;
    const Eigen::AlignedBox2d all = domain_of(m);
    const double middle = all.center().x();
    if (how == kCracked) sheet.cut({{middle, all.min().y()}, {middle, all.max().y()}});
    part.edges_seen = s.cracks.graph.edges().size();
    for (int block = 0; block < t.blocks() && how == kRubble; ++block)
      for (int lane = 0; lane < m.patch.knots_u.spans(); ++lane) {
        if (gauss_point(m.patch, t, block, lane).parameter.x() < middle) continue;
        GatheredPoint& g = s.cracked.gathered[gather_point(m, s, block, lane)];
        g.kind = PointKind::kDead, g.functions.clear();
      }
    for (int i = 0; i < m.control_points(); ++i) {
      const int slot = t.slot(i);
      if (m.parameter[i].x() < middle) continue;
      s.motion.x[slot] -= 0.9 * m.spacing;
      if (how == kLeft) s.motion.detached[slot] = 1;
    }
    part.initial_step = part.smallest_step = 1.0;
    part.measure_step(0, 1, {});
    EXPECT_EQ(part.smallest_step, 1.0) << how;
  }
}

// A sharp fold that was spent keeps the step of the whole shell, which never grows again.
TEST(ShellPart, ItsStepIsNotThatOfASpentFold) {
  for (const bool released : {false, true}) {
    ShellSetup setup{panel(60, 0.2)};
    setup.fracture.mode = FractureMode::kDamage;
    ShellPart part{setup};
    part.state = std::make_unique<ShellState>(damaging(setup.model));
    const double intact = stable_step(setup.model, *part.state, kStepIterations, 1, true);
    *part.state = spent_fold(setup.model);
    if (released) release_folds(setup.model, *part.state);
    part.initial_step = part.smallest_step = intact;
    part.measure_step(0, 1, {});
    if (released)
      EXPECT_GE(part.smallest_step, 0.8 * intact);
    else
      EXPECT_LT(part.smallest_step, 0.5 * intact);
  }
}

// A shell with fibres may lie on another one that is as heavy and has far stiffer fibres.
TEST(ShellPart, MeasuresItsStepWithTheFibresOfAllShells) {
  Sheet sheet;
  ShellModel stiff = sheet.part.model();
  stiff.fibres = {1e12, 1e12, 0.5};
  sheet.setup.model.fibres = {1e5, 1e5, 0.5};
  ShellPart& part = sheet.part;
  part.initial_step = part.smallest_step = 1.0;
  sheet.cut({{0.05, 0.05}, {0.1, 0.06}});
  part.measure_step(0, 1, {&part.model(), &stiff});
  EXPECT_GT(part.smallest_step, 0.0);
  EXPECT_LT(part.smallest_step, stable_step_with_fibres(1.0, {&part.model(), &stiff}));
  EXPECT_LT(part.smallest_step, 0.1 * stable_step_with_fibres(1.0, {&part.model()}));
}

TEST(ShellPart, AStepForHertzContactIsKeptForSomeTimeAndLongerAfterEachContact) {
  constexpr double kStiffness = 1e9, kLong = 1e-4, kWindow = 1e-3;
  const std::vector<Proxy> near = falling_balls(0.012, 0.6), far = falling_balls(1.0, 0.6);
  Sheet none;
  EXPECT_EQ(none.part.step_with_hertz(kLong, near, 1, Vec3::Zero(), kWindow, 0), kLong);
  Sheet sheet(kStiffness);
  const auto step = [&](const std::vector<Proxy>& bodies, std::int64_t window) {
    return sheet.part.step_with_hertz(kLong, bodies, 1, Vec3::Zero(), kWindow, window);
  };
  EXPECT_EQ(step(far, 0), kLong);
  const double contact = step(near, 10);
  EXPECT_EQ(contact, hertz_step(sheet.part.model(), near[0].body, kStiffness, 1.0, kLong));  // the next power of two
  EXPECT_LT(contact, kLong);
  EXPECT_EQ(step(far, 10 + kHertzKept), contact);
  EXPECT_EQ(step(far, 11 + kHertzKept), kLong);
  EXPECT_EQ(step(near, 200), contact);
  EXPECT_EQ(step(far, 200 + 2 * kHertzKept), contact);
  EXPECT_EQ(step(far, 201 + 2 * kHertzKept), kLong);
}

// Contact begins half a thickness over the middle: where four times 4 mm lie, 18 mm under the centre of the ball.
TEST(ShellPart, ShortensTheStepForHertzWhereItIsThickest) {
  constexpr double kStiffness = 1e9, kLong = 1e-4, kWindow = 1e-6;
  const std::vector<Proxy> bodies = falling_balls(0.0179, 0.6);
  for (const double factor : {1.0, 4.0}) {
    Sheet sheet(kStiffness);
    sheet.setup.model = make_shell("p", sheet.setup.model.patch, 0.004, sheet.setup.model.material, 2, 2, {}, {}, {},
                                   [factor](const Patch&, const Vec2& p) { return p.x() < 0.1 ? 1.0 : factor; });
    sheet.part.state = std::make_unique<ShellState>(make_state(sheet.setup.model, Vec3::Zero(), 1));
    const double step = sheet.part.step_with_hertz(kLong, bodies, 1, Vec3::Zero(), kWindow, 0);
    EXPECT_EQ(step<kLong, factor> 1.0) << step;
  }
}

TEST(ShellPart, CountsPiecesAnewOnceALoopHasClosed) {
  Sheet sheet;
  EXPECT_EQ(sheet.part.counted()->pieces, 1);
  sheet.cut({{0.03, 0.03}, {0.15, 0.05}});
  EXPECT_EQ(sheet.part.counted()->pieces, 1);
  const auto before = sheet.part.counted();
  EXPECT_EQ(sheet.part.counted(), before);  // nothing is new
  sheet.cut(kTriangle);
  EXPECT_NE(sheet.part.counted(), before);
  EXPECT_EQ(sheet.part.counted()->pieces, 2);
}

TEST(ShellPart, DrawsKnotsOnlyWherePiecesLeave) {
  Sheet sheet;
  sheet.cut(kTriangle);
  const auto bare = sheet.part.drawn({}), full = sheet.part.drawn(std::array{domain_of(sheet.setup.model)});
  EXPECT_EQ(bare->pieces, 2);
  EXPECT_EQ(full->pieces, 2);
  EXPECT_GT(full->vertices.size(), bare->vertices.size() + 20);
}

TEST(ShellPart, RemembersWhichPiecesWithoutControlPointsWereHandedOff) {
  Sheet sheet;
  sheet.cut(kTriangle);
  PartPieces now;
  now.whole = false;
  now.triangulation = std::make_shared<Triangulation>(partition(sheet.setup.model, *sheet.part.state, now.pieces));
  ASSERT_EQ(now.pieces.size(), 2u);
  const int inner = now.pieces[0].area < now.pieces[1].area ? 0 : 1;
  EXPECT_FALSE(now.pieces[inner].control_points.empty());
  sheet.part.add_rubble(*now.triangulation, inner);
  sheet.part.mark_rubble(now);
  EXPECT_FALSE(now.pieces[inner].handed_off);  // its control points tell
  for (Piece& p : now.pieces) p.control_points.clear();
  sheet.part.mark_rubble(now);
  EXPECT_TRUE(now.pieces[inner].handed_off);
  EXPECT_FALSE(now.pieces[1 - inner].handed_off);
}
