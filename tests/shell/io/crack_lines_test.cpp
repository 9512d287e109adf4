// Crack lines of frames: where laminates are, and on bodies that took them along.
#include "shell/io/crack_lines.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

BodyMotion body_at(const Vec3& position, const Vec3& axis, double angle) {
  BodyMotion body;
  body.position = position;
  body.orientation = Quat(Eigen::AngleAxisd(angle, axis.normalized()));
  return body;
}

ShellModel split_pane(bool laminated) {
  ShellMaterial material = glass();
  if (laminated) material.interlayer = {0.001, 1100, 1e7, 0.4};
  return make_shell("pane", plate(0.2, 0.2, 16, 16, Vec3(0.1, 0.1, 0), Quat::Identity()), 0.004, material, 2, 2, {});
}

// A laminate of 0.2 m by 0.2 m with a crack in either half, turned and moved as a whole.
struct Turned {
  ShellModel model;
  ShellState state;
  BodyMotion motion = body_at({0.3, -0.2, 0.5}, {1.0, 2.0, -1.0}, 0.8);

  explicit Turned(bool laminated = true) : model(split_pane(laminated)), state(make_state(model, Vec3::Zero(), 0)) {
    insert_polyline(model, state, {{0.04, 0.05}, {0.06, 0.15}}, 0.25);
    insert_polyline(model, state, {{0.15, 0.05}, {0.16, 0.15}}, 0.5);
    for (int i = 0; i < model.control_points(); ++i) {
      const int slot = model.tables.slot(i);
      const Vec3 now = world(state.position(slot));
      for (int d = 0; d < 3; ++d)
        state.motion.x[static_cast<std::size_t>(d) * model.tables.component_stride + slot] = now[d];
    }
  }
  Vec3 world(const Vec3& at_rest) const { return motion.position + motion.orientation * at_rest; }
  bool on_the_left(int slot) const { return model.rest[slot] < 0.1; }
};

}  // namespace

TEST(CrackLines, OfALaminateMoveWithItAndOthersRest) {
  for (const bool laminated : {true, false}) {
    const Turned pane(laminated);
    const std::vector<DrawnLine> lines = crack_lines(pane.model, pane.state, 3);
    ASSERT_GE(lines.size(), 2u);
    for (const DrawnLine& line : lines) {
      EXPECT_EQ(line.shell, 3);
      EXPECT_DOUBLE_EQ(line.time, line.rest[0].x() < 0.1 ? 0.25 : 0.5);
      for (const int end : {0, 1}) {
        EXPECT_LT((line.rest[end].head<2>() - line.parameter[end]).norm(), 1e-12);
        EXPECT_LT((line.points[end] - line.rest[end] - line.displacement[end]).norm(), 1e-15);
        EXPECT_LT((line.points[end] - (laminated ? pane.world(line.rest[end]) : line.rest[end])).norm(), 1e-12);
      }
    }
  }
}

// A body takes the left crack along, and another the right one. Each then turns by itself.
TEST(CrackLines, GoOnWithTheBodyThatTookThem) {
  Turned pane;
  const auto left = [&](int slot) { return pane.on_the_left(slot); };
  const std::vector<DrawnLine> taken = leaving_lines(pane.model, pane.state, 0, left);
  const std::vector<DrawnLine> other = leaving_lines(pane.model, pane.state, 0, [&](int slot) { return !left(slot); });
  EXPECT_EQ(taken.size() + other.size(), crack_lines(pane.model, pane.state, 0).size());
  ASSERT_FALSE(taken.empty());
  ASSERT_FALSE(other.empty());
  const std::array<BodyMotion, 2> before{body_at(pane.world({0.05, 0.1, 0}), {0, 1, 1}, 1.1),
                                         body_at(pane.world({0.15, 0.1, 0}), {1, 0, 1}, -0.4)};
  const std::array<BodyMotion, 2> after{body_at({1, 2, 3}, {1, 1, 0}, 2.2), body_at({-1, 0, 2}, {0, 0, 1}, -1.5)};
  std::vector<DrawnLine> drawn;
  add_carried(after[0], seen_from(before[0], taken), drawn);
  add_carried(after[1], seen_from(before[1], other), drawn);
  ASSERT_EQ(drawn.size(), taken.size() + other.size());
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const int body = k < taken.size() ? 0 : 1;
    EXPECT_EQ(drawn[k].rest[0].x() < 0.1, body == 0);
    for (const int end : {0, 1}) {
      const Vec3 local =
          before[body].orientation.conjugate() * (pane.world(drawn[k].rest[end]) - before[body].position);
      EXPECT_LT((drawn[k].points[end] - (after[body].position + after[body].orientation * local)).norm(), 1e-12);
      EXPECT_LT((drawn[k].points[end] - drawn[k].rest[end] - drawn[k].displacement[end]).norm(), 1e-15);
    }
  }
  // What has left is drawn in its place at rest, so that a pattern has all cracks.
  for (int i = 0; i < pane.model.control_points(); ++i)
    if (left(pane.model.tables.slot(i))) pane.state.motion.detached[pane.model.tables.slot(i)] = 1;
  for (const DrawnLine& line : crack_lines(pane.model, pane.state, 0))
    EXPECT_EQ(line.displacement[0].norm() == 0.0, line.rest[0].x() < 0.1);
}

TEST(CrackLines, AreALineEachWithItsNumbers) {
  const Turned pane;
  const std::vector<DrawnLine> lines = crack_lines(pane.model, pane.state, 1);
  const VtpMesh mesh = line_mesh(lines);
  ASSERT_EQ(mesh.lines.size(), lines.size());
  ASSERT_EQ(mesh.points.size(), 2 * lines.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    EXPECT_EQ(mesh.points[mesh.lines[k][0]], lines[k].points[0]);
    EXPECT_EQ(mesh.points[mesh.lines[k][1]], lines[k].points[1]);
    EXPECT_EQ(mesh.cell_data[0].values[k], lines[k].crack);
    EXPECT_EQ(mesh.cell_data[2].values[k], 1.0);
    EXPECT_EQ(mesh.point_data[0].values[6 * k + 4], lines[k].displacement[1].y());
  }
}
