// Equilibrium and modes of shells that seams join, against the same surface in one piece and exact results.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "shell/solver/statics/modes.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kHalfTurn = std::numbers::pi;

ShellMaterial elastic(double young, double poisson) {
  ShellMaterial m;
  m.density = 1000.0, m.youngs_modulus = young, m.poisson_ratio = poisson;
  return m;
}

Support hold(int edges, bool clamped, std::array<bool, 3> axes = {true, true, true}) {
  Support s;
  s.edges = edges, s.clamped = clamped, s.axes = axes;
  return s;
}
Support mirror(int edges, int axis) {
  Support s;
  s.edges = edges, s.symmetry = axis;
  return s;
}

Load pressure(double size) {
  Load l;
  l.kind = Load::Kind::kPressure, l.size = size;
  return l;
}

/// All shells of a rig, to be brought into equilibrium.
struct Joined {
  explicit Joined(std::vector<ShellModel> models, double tolerance = 1e-6, const Vec3& gravity = Vec3::Zero())
      : rig(std::move(models), Join::kClamped, tolerance) {
    for (std::size_t k = 0; k < rig.size(); ++k)
      all.shells.push_back({&rig.model(k), &rig.state(k)}), all.numbers.push_back(static_cast<int>(k)),
          all.gravity.push_back(gravity);
    if (rig.size() > 1) all.stitching = &rig.stitching();
  }
  RelaxationResult find(double tolerance = 1e-9) {
    RelaxationRules rules;
    rules.tolerance = tolerance;
    return relax(all, rules, rig.size() > 1 ? &seams : nullptr);
  }
  /// Where a place of a shell has moved [m].
  Vec3 moved(int shell, const Vec2& at) const {
    const ShellModel& m = rig.model(shell);
    return rig.at(shell, at) - m.patch.evaluate(at).x;
  }
  /// Forces that nothing balances, and those of all supports, with the seams' and weights [N].
  std::pair<double, Vec3> left_and_borne() const {
    double left = 0.0;
    Vec3 borne = Vec3::Zero();
    for (std::size_t k = 0; k < rig.size(); ++k) {
      const ShellModel& m = rig.model(k);
      const ShellState& s = rig.state(k);
      const std::size_t stride = m.tables.component_stride;
      std::array<std::vector<char>, 3> held;
      for (int d = 0; d < 3; ++d) {
        held[d].assign(stride, 0);
        for (const int slot : m.constraints.held[d]) held[d][slot] = 1;
      }
      for (int i = 0; i < m.control_points(); ++i)
        for (int d = 0; d < 3; ++d) {
          const std::size_t at = d * stride + m.tables.slot(i);
          const double f = s.motion.force[at] + (seams.empty() ? 0.0 : seams[k][at]) +
                           s.motion.mass[m.tables.slot(i)] * all.gravity[k][d];
          if (held[d][m.tables.slot(i)])
            borne[d] -= f;
          else
            left = std::max(left, std::abs(f));
        }
    }
    return {left, borne};
  }

  Stitched rig;
  JoinedShells all;
  SeamForces seams;
};

constexpr double kPressure = 1000.0;  // [Pa]: it bends the plate by a fiftieth of its thickness
constexpr double kNavier = 0.00406235;

std::vector<ShellModel> plate_in(int columns, int rows, int elements = 18) {
  std::vector<ShellModel> out;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double x0 = i == 0 ? 0.0 : 0.44, x1 = i + 1 == columns ? 1.0 : 0.44, y0 = j == 0 ? 0.0 : 0.52,
                   y1 = j + 1 == rows ? 1.0 : 0.52;
      const int edges =
          (i == 0 ? kUMin : 0) | (i + 1 == columns ? kUMax : 0) | (j == 0 ? kVMin : 0) | (j + 1 == rows ? kVMax : 0);
      const int nx = static_cast<int>(std::lround(elements * (x1 - x0))) + 2 * j,
                ny = static_cast<int>(std::lround(elements * (y1 - y0))) + 3 * i;
      out.push_back(make_shell(fmt::format("p{}", 2 * j + i), flat(x0, x1, y0, y1, nx, ny), 0.01, elastic(2e11, 0.3), 2,
                               2, {hold(edges, false)}, {pressure(kPressure)}));
    }
  return out;
}

}  // namespace

TEST(JoinedEquilibrium, OfAPlateInPiecesIsNaviers) {
  const double stiffness = 2e11 * 1e-6 / (12.0 * (1.0 - 0.09)), exact = kNavier * kPressure / stiffness;
  Joined one(plate_in(1, 1));
  ASSERT_TRUE(one.find().converged);
  EXPECT_NEAR(one.moved(0, {0.5, 0.5}).z(), exact, 5e-3 * exact);
  const auto look = [&](int columns, int rows, int shell, const Vec2& middle) {
    SCOPED_TRACE(columns * rows);
    Joined pieces(plate_in(columns, rows));
    const RelaxationResult r = pieces.find(1e-12);
    ASSERT_TRUE(r.converged) << r.residual;
    EXPECT_EQ(r.steps, 0);
    EXPECT_NEAR(pieces.moved(shell, middle).z(), exact, 5e-3 * exact);
    const auto [left, borne] = pieces.left_and_borne();
    EXPECT_LT(left, 1e-8 * kPressure);                     // round-off of positions times the stiffness
    EXPECT_NEAR(borne.z(), -kPressure, 1e-9 * kPressure);  // of a square metre
  };
  look(2, 1, 1, {0.06, 0.5});
  look(2, 2, 1, {0.06, 0.5});
}

TEST(JoinedEquilibrium, NewtonAndRelaxationAgree) {
  Joined newton(plate_in(2, 1, 6)), relaxed(plate_in(2, 1, 6));
  ASSERT_TRUE(newton.find().converged);
  RelaxationRules rules;
  rules.tolerance = 1e-6, rules.most_newton = 0;
  const RelaxationResult r = relax(relaxed.all, rules);
  ASSERT_TRUE(r.converged) << r.residual;
  EXPECT_GT(r.steps, 100);
  const double w = newton.moved(1, {0.06, 0.5}).z();
  EXPECT_NEAR(relaxed.moved(1, {0.06, 0.5}).z(), w, 1e-4 * w);
}

namespace {

constexpr double kShare = 1e-3;  // of the roof's weight: linear theory

/// A part of a quarter of the roof from share v0 to v1 of its half length.
ShellModel roof_part(double v0, double v1, int nu, int nv) {
  const double angle = 40.0 * kHalfTurn / 180.0;
  Patch p = cylinder(25.0, 25.0 * (v1 - v0), angle, nu, nv, 3);
  p = placed(p, Vec3(0, 0, 25.0 * v0), Quat(Eigen::AngleAxisd(0.5 * angle, Vec3::UnitZ())));
  for (Vec3& x : p.control_points) x = Vec3(x.y(), x.z(), x.x());
  std::vector<Support> supports{mirror(kUMin, 0)};
  if (v0 == 0.0) supports.push_back(mirror(kVMin, 1));
  if (v1 == 1.0) supports.push_back(hold(kVMax, false, {true, false, true}));
  ShellMaterial m = elastic(4.32e8, 0.0);
  m.density = 1.0;
  return make_shell(fmt::format("roof_{}", v0), p, 0.25, m, 2, 3, supports);
}

}  // namespace

// 0.3006: the limit of Kirchhoff-Love theory.
TEST(JoinedEquilibrium, OfScordelisAndLosRoofInTwoPiecesIsThePublishedOne) {
  const Vec3 weight(0, 0, -90.0 / 0.25 * kShare);
  for (const int more : {0, 3}) {
    SCOPED_TRACE(more);
    Joined roof({roof_part(0.0, 0.4, 12, 5), roof_part(0.4, 1.0, 12 + more, 8)}, 1e-6, weight);
    const RelaxationResult r = roof.find();
    ASSERT_TRUE(r.converged) << r.residual;
    const Patch& p = roof.rig.model(0).patch;
    EXPECT_NEAR(-roof.moved(0, {p.knots_u.end(), 0.0}).z() / kShare, 0.3006, 5e-3 * 0.3006);
    double mass = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      for (const double m : roof.rig.model(k).mass) mass += m;
    EXPECT_NEAR(roof.left_and_borne().second.z() / (-mass * weight.z()), 1.0, 1e-8);
  }
}

namespace {

std::vector<ShellModel> strip_in(int pieces, double shear) {
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, shear);
  std::vector<ShellModel> out;
  const double middle = pieces == 1 ? 10.0 : 4.0;
  out.push_back(make_shell("root", flat(0, middle, 0, 1, pieces == 1 ? 40 : 16, 2), 0.1, elastic(1.2e6, 0.0), 2, 2,
                           {hold(kUMin, true)}, pieces == 1 ? std::vector<Load>{load} : std::vector<Load>{}));
  if (pieces == 2)
    out.push_back(make_shell("tip", flat(middle, 10, 0, 1, 24, 3), 0.1, elastic(1.2e6, 0.0), 2, 2, {}, {load}));
  return out;
}

}  // namespace

// Sze, Liu, Lo 2004: the tip rises by 6.698 and moves back by 3.286 under the whole shear.
TEST(JoinedEquilibrium, OfAStripOfTwoPiecesThatBendsFarIsThatOfOne) {
  Joined one(strip_in(1, 4.0)), two(strip_in(2, 4.0));
  ASSERT_TRUE(one.find(1e-8).converged);
  const RelaxationResult r = two.find(1e-8);
  ASSERT_TRUE(r.converged) << r.residual;
  const Vec3 whole = one.moved(0, {10.0, 0.5}), pieces = two.moved(1, {6.0, 0.5});
  EXPECT_NEAR(whole.z(), 6.698, 0.01 * 6.698);
  EXPECT_LT((pieces - whole).norm(), 5e-3 * whole.norm());
  EXPECT_NEAR(two.left_and_borne().second.z(), -4.0, 1e-6);
}

namespace {

constexpr double kColumn = 1.0, kArm = 0.6, kWide = 0.1, kThin = 0.01;

/// A column with an arm at right angles at its top, which a crease joins; a force at the end of the arm.
std::vector<ShellModel> bracket(double force) {
  const Patch column = placed(flat(-0.5 * kColumn, 0.5 * kColumn, -0.5 * kWide, 0.5 * kWide, 20, 2),
                              Vec3(0, 0, 0.5 * kColumn), Quat(Eigen::AngleAxisd(-0.5 * kHalfTurn, Vec3::UnitY())));
  const Patch arm = placed(flat(0, kArm, -0.5 * kWide, 0.5 * kWide, 14, 3), Vec3(0, 0, kColumn), Quat::Identity());
  Load load;
  load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 0, force / kWide);
  return {make_shell("column", column, kThin, elastic(2e11, 0.0), 2, 2, {hold(kUMin, true)}),
          make_shell("arm", arm, kThin, elastic(2e11, 0.0), 2, 2, {}, {load})};
}

}  // namespace

// Beams: P b^3/(3 E I) + P b^2 a/(E I), beside what stretches the column.
TEST(JoinedEquilibrium, ACreaseKeepsItsAngle) {
  const double force = 1.0, bending = 2e11 * kWide * std::pow(kThin, 3) / 12.0;
  const double exact = force * (std::pow(kArm, 3) / 3.0 + kArm * kArm * kColumn) / bending;
  Joined pieces(bracket(force));
  const RelaxationResult r = pieces.find(1e-12);
  ASSERT_TRUE(r.converged) << r.residual;
  EXPECT_NEAR(pieces.moved(1, {kArm, 0.5 * kWide}).z(), exact, 5e-3 * exact);
  EXPECT_NEAR(pieces.left_and_borne().second.z(), -force, 1e-7 * force);  // round-off of positions times the stiffness
}

// A crease whose direction supports hold has no gradient: it bears nothing, and the arm is sheared in its plane.
TEST(JoinedEquilibrium, ACreaseWhoseDirectionIsHeldBearsNothing) {
  for (const bool newton : {true, false}) {
    std::vector<ShellModel> models = bracket(0.0);
    Load load;
    load.kind = Load::Kind::kEdgeForce, load.edges = kUMax, load.force = Vec3(0, 100.0 / kWide, 0);
    Support plane;  // all may move along y alone
    plane.axes = {true, false, true}, plane.clamped = false, plane.regions = {{Vec2(0, 0), Vec2(kColumn, kWide)}};
    const Patch column = models[0].patch, arm = models[1].patch;
    models = {make_shell("column", column, kThin, elastic(2e11, 0.0), 2, 2, {hold(kUMin, false), plane}),
              make_shell("arm", arm, kThin, elastic(2e11, 0.0), 2, 2, {plane}, {load})};
    Joined pieces(std::move(models));
    RelaxationRules rules;
    rules.tolerance = 1e-9, rules.most_newton = newton ? 60 : 0;
    const RelaxationResult r = relax(pieces.all, rules, &pieces.seams);
    ASSERT_TRUE(r.converged) << r.residual << newton;
    // of one straight strip in shear alone: F L / (G A)
    const double shear = 100.0 * (kColumn + kArm) / (1e11 * kWide * kThin);
    EXPECT_NEAR(pieces.moved(1, {kArm, 0.5 * kWide}).y(), shear, 0.02 * shear);
    EXPECT_NEAR(pieces.left_and_borne().second.y(), -100.0, 1e-5);
  }
}

// A force that follows nothing and turns the arm by far: the angle at the crease stays a right one.
TEST(JoinedEquilibrium, ACreaseKeepsItsAngleAlsoWhereItTurnsFar) {
  Joined pieces(bracket(-2000.0));
  const RelaxationResult r = pieces.find(1e-8);
  ASSERT_TRUE(r.converged) << r.residual;
  const auto along = [&](int shell, const Vec2& a, const Vec2& b) {
    return Vec3(pieces.rig.at(shell, b) - pieces.rig.at(shell, a)).normalized();
  };
  const Vec3 up = along(0, {kColumn - 1e-3, 0.05}, {kColumn, 0.05}), out = along(1, {0.0, 0.05}, {1e-3, 0.05});
  EXPECT_LT(out.x(), 0.9);  // it has turned
  EXPECT_NEAR(up.dot(out), 0.0, 0.02);
  EXPECT_NEAR(pieces.left_and_borne().second.z(), 2000.0, 2e-3);
}

namespace {

ShellModel trimmed(const Patch& p, const std::vector<Vec2>& ring, const std::string& name, int edges) {
  return make_shell(name, p, 0.01, elastic(2e11, 0.3), 2, 2, {hold(edges, false)}, {pressure(kPressure)},
                    TrimLoops(Vec2::Zero(), Vec2(p.knots_u.end(), p.knots_v.end()), {{ring, false, {}}}));
}

// The square in two pieces along a bent line.
std::vector<ShellModel> tied_plate() {
  return {trimmed(flat(0, 0.8, 0, 1, 14, 17), {{0, 0}, {0.4, 0}, {0.55, 0.5}, {0.45, 1}, {0, 1}, {0, 0}}, "left",
                  kUMin | kVMin | kVMax),
          trimmed(flat(0.2, 1, 0, 1, 16, 20), {{0.2, 0}, {0.8, 0}, {0.8, 1}, {0.25, 1}, {0.35, 0.5}, {0.2, 0}}, "right",
                  kUMax | kVMin | kVMax)};
}

}  // namespace

TEST(JoinedEquilibrium, OfAPlateThatTiesJoinIsNaviers) {
  const double stiffness = 2e11 * 1e-6 / (12.0 * (1.0 - 0.09)), exact = kNavier * kPressure / stiffness;
  Joined pieces(tied_plate());
  ASSERT_FALSE(pieces.rig.stitching().empty());
  const RelaxationResult r = pieces.find(1e-11);
  ASSERT_TRUE(r.converged) << r.residual;
  EXPECT_NEAR(pieces.moved(0, {0.5, 0.5}).z(), exact, 0.01 * exact);
  double area = 0.0;
  for (std::size_t k = 0; k < 2; ++k)
    for (const double m : pieces.rig.model(k).mass) area += m / 10.0;  // of 10 kg/m^2
  EXPECT_NEAR(area, 1.0, 1e-9);
  EXPECT_NEAR(pieces.left_and_borne().second.z(), -kPressure, 1e-8 * kPressure);
}

TEST(JoinedModes, OfAPlateInPiecesAreMultiplesOfPiSquared) {
  const double unit = std::sqrt(2e11 * 1e-6 / (12.0 * (1.0 - 0.09)) / 10.0) * kHalfTurn / 2.0;  // of pi^2 [Hz]
  const double multiple[] = {2, 5, 5, 8};
  for (auto&& models : {plate_in(1, 1), plate_in(2, 2), tied_plate()}) {
    SCOPED_TRACE(models.back().name);
    Joined pieces(models);
    const ModeSet found = vibration_modes(pieces.all, 4, 1);
    EXPECT_EQ(found.rigid, 0);
    EXPECT_EQ(found.unstable, 0);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found.modes[k].frequency / (unit * multiple[k]), 1.0, 0.012) << k;
  }
}

// The bracket swings in its plane: beside one piece of the same length it is softer, and free it has six rigid motions.
TEST(JoinedModes, OfAFreeBracketLeaveOutSixRigidMotions) {
  std::vector<ShellModel> models = bracket(0.0);
  models[0] = make_shell("column", models[0].patch, kThin, elastic(2e11, 0.0), 2, 2, {});
  Joined pieces(models);
  const ModeSet found = vibration_modes(pieces.all, 2, 1);
  EXPECT_EQ(found.rigid, 6);
  EXPECT_EQ(found.unstable, 0);
  EXPECT_GT(found.modes[0].frequency, 10.0);
}
