// Prescribed cuts: what they cut off, and how they meet.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shell/geometry/plane_curves.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/parting/handoff.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel pane(int degree = 2) {
  return make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity(), degree), 0.004, glass(), 2, degree,
                    {});
}

int pieces_after(const ShellModel& m, const std::vector<Vec2>& points) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, points, 0.0);
  std::vector<Piece> pieces;
  return partition(m, s, pieces).pieces;
}

}  // namespace

TEST(ClosedCut, SeparatesARoundPiece) {
  for (const int degree : {2, 3}) {
    const ShellModel m = pane(degree);
    for (const Vec2& centre : {Vec2(0.1, 0.1), Vec2(0.083, 0.117)})
      for (const double radius : {0.6, 2.0, 5.0, 8.0})
        EXPECT_EQ(pieces_after(m, crack_points(circle_curve(centre, radius * m.spacing), m.spacing)), 2)
            << centre.transpose() << " " << radius << " " << degree;
  }
}

TEST(ClosedCut, SeparatesWhenTheLastOfItsPiecesIsMade) {
  const ShellModel m = pane();
  const std::vector<Vec2> ring = crack_points(circle_curve(Vec2(0.1, 0.1), 5.0 * m.spacing), m.spacing);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::vector<Piece> pieces;
  for (std::size_t k = 1; k < ring.size(); ++k) {
    EXPECT_EQ(partition(m, s, pieces).pieces, 1) << k;
    insert_polyline(m, s, {ring[k - 1], ring[k]}, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), k);
  }
  EXPECT_EQ(partition(m, s, pieces).pieces, 2);
}

TEST(ClosedCut, SeparatesWhereItBeginsBesideTheBorder) {
  const ShellModel m = pane();
  // its first point is half a spacing off: an open cut would run out there
  const std::vector<Vec2> square{{0.195, 0.1}, {0.1, 0.15}, {0.05, 0.1}, {0.1, 0.05}, {0.195, 0.1}};
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, square, 0.0);
  EXPECT_EQ(s.cracks.graph.vertices().size(), s.cracks.graph.edges().size());  // one ring
  std::vector<Piece> pieces;
  EXPECT_EQ(partition(m, s, pieces).pieces, 2);
  std::vector<Vec2> open = square;
  open.pop_back();
  EXPECT_EQ(pieces_after(m, open), 1);
}

TEST(ClosedCut, OfTwoCirclesThatCrossMakesALens) {
  const ShellModel m = pane();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  for (const double x : {0.08, 0.12}) insert_polyline(m, s, crack_points(circle_curve({x, 0.1}, 0.05), m.spacing), 0.0);
  std::vector<Piece> pieces;
  EXPECT_EQ(partition(m, s, pieces).pieces, 4);  // two moons, the lens and the sheet around
}

// A triangle as three cuts between the same corners, in any order and direction, frees it as one closed cut does.
TEST(CutsThatMeet, AreJoined) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> at(0.03, 0.17);
  for (const int degree : {2, 3}) {
    const ShellModel m = pane(degree);
    const auto pieces_of = [&](const std::vector<std::vector<Vec2>>& cuts) {
      ShellState s = make_state(m, Vec3::Zero(), 0);
      for (const auto& cut : cuts) insert_polyline(m, s, cut, 0.0);
      std::vector<Piece> pieces;
      return partition(m, s, pieces).pieces;
    };
    for (int n = 0; n < 30; ++n) {
      Vec2 a(at(random), at(random)), b(at(random), at(random)), c(at(random), at(random));
      if (std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()) < 1e-3) continue;
      EXPECT_EQ(pieces_of({{a, b, c, a}}), 2);
      EXPECT_EQ(pieces_of({{a, b, c}, {c, a}}), 2) << n;
      EXPECT_EQ(pieces_of({{a, c}, {a, b, c}}), 2) << n;
      EXPECT_EQ(pieces_of({{b, a}, {b, c}, {a, c}}), 2) << n;
      EXPECT_EQ(pieces_of({{b, a}, {a, c}, {b, a}, {c, b}}), 2) << n;  // one of them twice
      // the third side ends on the first two; then it is there before them
      const Vec2 p = a + 0.31 * (b - a), q = c + 0.43 * (b - c);
      EXPECT_EQ(pieces_of({{a, b, c}, {p, q}}), 2) << n;
      EXPECT_EQ(pieces_of({{p, q}, {a, b, c}}), 2) << n;
      EXPECT_EQ(pieces_of({{p, q}, {c, b}, {b, a}}), 2) << n;
      // a side in two that meet head-on
      EXPECT_EQ(pieces_of({{a, p}, {p, b}, {b, c, a}}), 2) << n;
    }
  }
}

TEST(CutsThatMeet, HaveNoEdgeTwice) {
  const ShellModel m = pane();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const std::vector<Vec2> cut{{0.05, 0.06}, {0.13, 0.08}, {0.14, 0.15}};
  insert_polyline(m, s, cut, 0.0);
  const std::size_t edges = s.cracks.graph.edges().size();
  const double length = s.cracks.graph.total_length();
  insert_polyline(m, s, cut, 0.0);
  insert_polyline(m, s, {cut.rbegin(), cut.rend()}, 0.0);
  EXPECT_EQ(s.cracks.graph.edges().size(), edges);
  EXPECT_EQ(s.cracks.graph.total_length(), length);
}

TEST(Cut, LeavesAloneWhatHasComeOff) {
  const ShellModel m = pane();
  for (const double left : {0.0495, 0.0527, 0.056}) {  // the last edges before the hole end anywhere beside it
    ShellState s = make_state(m, Vec3::Zero(), 0);
    insert_polyline(m, s, {{left, 0.052}, {0.147, 0.051}, {0.146, 0.148}, {left, 0.149}, {left, 0.052}}, 0.0);
    std::vector<Piece> pieces;
    ASSERT_EQ(partition(m, s, pieces).pieces, 2);
    remove_piece(m, s, pieces[0].area < pieces[1].area ? pieces[0] : pieces[1]);
    const std::size_t edges = s.cracks.graph.edges().size();
    insert_polyline(m, s, {{0.083, 0.084}, {0.117, 0.085}, {0.1, 0.11}, {0.083, 0.084}}, 0.0);
    EXPECT_EQ(s.cracks.graph.edges().size(), edges);
    insert_polyline(m, s, {{0.0, 0.1}, {0.2, 0.103}}, 0.0);  // what stands is cut on either side
    EXPECT_LT(s.cracks.graph.edges().size(), edges + 18);
    EXPECT_EQ(partition(m, s, pieces).pieces, 3) << left;
  }
}

TEST(Cut, EndsThatMeetAreNotOpen) {
  const ShellModel m = pane();
  ShellState s = make_state(m, Vec3::Zero(), 0);
  insert_polyline(m, s, {{0.05, 0.06}, {0.1, 0.11}}, 0.0);
  const int first = static_cast<int>(s.cracks.graph.edges().size());
  insert_polyline(m, s, {{0.1, 0.11}, {0.16, 0.09}}, 0.0);
  const int all = static_cast<int>(s.cracks.graph.edges().size());
  start_at_ends(m, s, 0, first);
  start_at_ends(m, s, first, all);
  ASSERT_EQ(s.cracks.tips.size(), 2u);
  EXPECT_LT((s.cracks.tips[0].p - Vec2(0.05, 0.06)).norm(), 1e-9);
  EXPECT_LT((s.cracks.tips[1].p - Vec2(0.16, 0.09)).norm(), 1e-9);
}

TEST(PrescribedCut, ThatEndsShortOfTheBorderDoesNotReachIt) {
  const ShellModel m = brittle_sheet();
  const double u = m.patch.knots_u.end(), v = 0.51 * m.patch.knots_v.end();
  for (const double gap : {0.9, 0.0}) {
    ShellState s = make_state(m, Vec3::Zero(), 1);
    insert_polyline(m, s, {{gap * m.spacing, v}, {u - gap * m.spacing, v}}, 0.0);
    std::vector<Piece> pieces;
    EXPECT_EQ(partition(m, s, pieces).pieces, gap > 0.0 ? 1 : 2);
  }
}
