// What a support holds becomes one static body, and the shell is empty.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/parting/remains.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/prisms.h"

using namespace sunder;
using namespace sunder::shell;
using sunder::test::volume_of_prisms;

namespace {

ShellModel held_pane() {
  Support clamp;
  clamp.edges = kUMin;
  return make_shell("pane", plate(0.2, 0.2, 10, 10, Vec3(0.3, 0.1, 0.5), Quat(Eigen::AngleAxisd(0.7, Vec3::UnitY()))),
                    0.004, glass(), 2, 2, {clamp});
}

Handoff frozen(const ShellModel& m, ShellState& s) {
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  return freeze(m, s, t, pieces, 7);
}

const ConvexShape& shape_of(const Handoff& h) { return std::get<ConvexShape>(h.body.shape); }

}  // namespace

TEST(Freeze, MakesAStaticBodyOfThePaneWhereItStands) {
  const ShellModel m = held_pane();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const Handoff h = frozen(m, s);
  EXPECT_TRUE(h.body.is_static);
  EXPECT_EQ(h.body.id, 7u);
  EXPECT_EQ(h.body.name, "pane_remains");
  EXPECT_NEAR(h.area, 0.04, 1e-12);
  EXPECT_NEAR(volume_of_prisms(shape_of(h)), 0.04 * 0.004, 1e-9 * 0.04 * 0.004);
  EXPECT_LE(shape_of(h).parts.size(), 2u);  // it is flat
  const Vec3 normal = Quat(Eigen::AngleAxisd(0.7, Vec3::UnitY())) * Vec3::UnitZ(), centre(0.3, 0.1, 0.5);
  for (const auto& part : shape_of(h).parts)
    for (const Vec3& x : part) EXPECT_NEAR(std::abs(normal.dot(x - centre)), 0.002, 1e-12);
  for (int i = 0; i < m.control_points(); ++i) {
    EXPECT_TRUE(s.motion.detached[m.tables.slot(i)]);
    EXPECT_EQ(s.motion.mass[m.tables.slot(i)], 0.0);
  }
}

TEST(Freeze, LeavesOutWhatNothingHolds) {
  const ShellModel m = held_pane();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.12, 0.0}, {0.12, 0.2}}, 0.0);
  const Handoff h = frozen(m, s);
  EXPECT_NEAR(h.area, 0.12 * 0.2, 1e-9);
  EXPECT_NEAR(volume_of_prisms(shape_of(h)), 0.12 * 0.2 * 0.004, 1e-9);
  for (int i = 0; i < m.control_points(); ++i) EXPECT_TRUE(s.motion.detached[m.tables.slot(i)]);  // the other half too
}

// What has swung as a whole keeps its rest shape; what is bent is taken in flat parts of its outline.
TEST(Freeze, TakesWhatIsBentAsItStands) {
  Support hinge;
  hinge.edges = kUMin, hinge.clamped = false;
  const ShellModel m =
      make_shell("flap", plate(0.2, 0.2, 10, 10, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {hinge});
  ShellState swung = make_state(m, Vec3::Zero(), 0), bent = make_state(m, Vec3::Zero(), 0);
  const Quat turn(Eigen::AngleAxisd(1.1, Vec3::UnitY()));
  const double radius = 0.1;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 rest = swung.position(slot),
               arc = Vec3(radius * std::sin(rest.x() / radius), rest.y(), radius * (1.0 - std::cos(rest.x() / radius)));
    for (int d = 0; d < 3; ++d) {
      const std::size_t k = static_cast<std::size_t>(d) * m.tables.component_stride + slot;
      swung.motion.x[k] = (turn * rest)[d], bent.motion.x[k] = arc[d];
    }
  }
  const Handoff flat = frozen(m, swung), curved = frozen(m, bent);
  EXPECT_LE(shape_of(flat).parts.size(), 2u);
  for (const auto& part : shape_of(flat).parts)
    for (const Vec3& x : part) EXPECT_NEAR(std::abs((turn * Vec3::UnitZ()).dot(x)), 0.002, 1e-9);
  // A chord of 40 mm is off the arc by half the thickness; the sides are halved until they are shorter.
  EXPECT_GE(shape_of(curved).parts.size(), 5u);
  EXPECT_LE(shape_of(curved).parts.size(), 16u);
  EXPECT_NEAR(volume_of_prisms(shape_of(curved)), 0.2 * 0.2 * 0.004, 0.03 * 0.2 * 0.2 * 0.004);
  double furthest = 0.0;  // off the arc, whose control points lie a little outside of it
  for (const auto& part : shape_of(curved).parts)
    for (const Vec3& x : part)
      furthest = std::max(furthest, std::abs(std::hypot(x.x(), x.z() - radius) - radius) - 0.002);
  EXPECT_LT(furthest, 1e-3);
}

// Two lips of a pane that is torn halfway, one bent up and one down: each is drawn where it stands, up to the crack.
// Functions of the uncut patch would draw a steep strip between them, whose faces fold.
TEST(Freeze, DrawsBothSidesOfAnOpenCrackWhereTheyStand) {
  Support clamp;
  clamp.edges = kUMin;
  const ShellModel m =
      make_shell("pane", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {clamp});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.1, 0.1}, {0.2, 0.1}}, 0.0);
  const double curve = 1.0;  // [1/m]
  const auto lift = [&](const Vec3& rest) {
    const double along = std::max(0.0, rest.x());  // from the crack's tip
    return (rest.y() > 0.0 ? curve : -curve) * along * along;
  };
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    s.motion.x[2 * m.tables.component_stride + static_cast<std::size_t>(slot)] += lift(s.position(slot));
  }
  const Handoff h = frozen(m, s);
  ASSERT_EQ(h.drawn.rest.size(), h.drawn.points.size());
  ASSERT_FALSE(h.drawn.points.empty());
  double furthest = 0.0, at_the_lips = 0.0;
  for (std::size_t i = 0; i + 1 < h.drawn.points.size(); i += 2) {
    const Vec3 middle = 0.5 * (h.drawn.points[i] + h.drawn.points[i + 1]),
               rest = 0.5 * (h.drawn.rest[i] + h.drawn.rest[i + 1]);
    furthest = std::max(furthest, std::abs(middle.z() - lift(rest)));
    if (std::abs(rest.y()) < 1e-3) at_the_lips = std::max(at_the_lips, std::abs(middle.z()));
  }
  EXPECT_LT(furthest, 0.05 * curve * 0.1 * 0.1);
  EXPECT_GT(at_the_lips, 0.9 * curve * 0.1 * 0.1);
  std::map<std::pair<int, int>, int> sides;  // directed: each once, and its opposite too
  double steepest = 1.0;
  for (const auto& c : h.drawn.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[{c[k], c[(k + 1) % 3]}];
    const Vec3 n = (h.drawn.points[c[1]] - h.drawn.points[c[0]]).cross(h.drawn.points[c[2]] - h.drawn.points[c[0]]);
    const bool edge = c[0] / 2 == c[1] / 2 || c[1] / 2 == c[2] / 2 || c[2] / 2 == c[0] / 2;
    if (!edge) steepest = std::min(steepest, std::abs(n.normalized().z()));
  }
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((sides.count({side.second, side.first})), 1u);
  }
  EXPECT_GT(steepest, 0.97 * std::cos(std::atan(2.0 * curve * 0.1)));
}
