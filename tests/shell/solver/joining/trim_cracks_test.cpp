// Cracks over ties along trims.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "shell/solver/joining/seam_cracks.h"
#include "shell/solver/joining/trim_cracks.h"
#include "shell/solver/parting/pieces.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kCross = 0.52;  // height at which cracks meet the seam

ShellModel trimmed_piece(const Patch& p, const std::vector<Vec2>& ring) {
  const Patch own = with_parameters_as_lengths(p);
  return make_shell("p", p, 0.01, glass(), 2, p.degree(), {}, {},
                    TrimLoops(Vec2::Zero(), {own.knots_u.end(), own.knots_v.end()}, {{ring, false, {}}}));
}

// A square in two pieces along the line from (0.45, 0) to (0.55, 1); the right one's parameters are turned.
Stitched plates(int times) {
  const Patch right = turned(flat(0.3, 1, 0, 1, 10, 13), times);
  std::vector<Vec2> ring{{0.15, 0}, {0.7, 0}, {0.7, 1}, {0.25, 1}, {0.15, 0}};
  for (int k = 0; k < times; ++k)  // u' = v, v' = high - u
    for (Vec2& p : ring) p = Vec2(p.y(), (k % 2 == 0 ? 0.7 : 1.0) - p.x());
  return Stitched({trimmed_piece(flat(0, 0.8, 0, 1, 8, 10), {{0, 0}, {0.45, 0}, {0.55, 1}, {0, 1}, {0, 0}}),
                   trimmed_piece(right, ring)});
}

double seam_at(double y) { return 0.45 + 0.1 * y; }

// Ends a crack on the seam of the left plate, from `from`, as a tip does.
Tip end_on_seam(Stitched& s, const Vec2& from) {
  const Vec2 to(seam_at(kCross), kCross), d = (to - from).normalized();
  insert_polyline(s.model(0), s.state(0), {from, to + 2e-3 * s.model(0).spacing * d}, 0.0);
  const CrackGraph& cracks = s.state(0).cracks.graph;
  Tip tip;
  for (const CrackEdge& e : cracks.edges())
    if (!e.is_trim() && (e.b - to).norm() < 0.1 * s.model(0).spacing)
      tip.edge = static_cast<int>(&e - cracks.edges().data()), tip.vertex = e.to, tip.p = e.b;
  tip.direction = d, tip.alive = false;
  s.state(0).cracks.tips.push_back(tip);
  return tip;
}

Vec3 place(const Stitched& s, int shell, const Vec2& p) { return s.model(shell).patch.evaluate(p).x; }

}  // namespace

TEST(TrimCracks, GoOnFromTheSamePlaceInTheSameDirection) {
  for (const int times : {0, 1, 2, 3})
    for (const Vec2& from : {Vec2(0.2, 0.52), Vec2(0.3, 0.3), Vec2(0.35, 0.7)}) {
      Stitched s = plates(times);
      ASSERT_EQ(s.seams().size(), 1u);
      const Tip tip = end_on_seam(s, from);
      ASSERT_GE(tip.edge, 0);
      EXPECT_EQ(propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0), 1);
      ASSERT_EQ(s.state(1).cracks.tips.size(), 1u) << times;
      const Tip& on = s.state(1).cracks.tips[0];
      EXPECT_TRUE(on.alive);
      EXPECT_LT(on.pending, 0.0);
      const CrackGraph& cracks = s.state(1).cracks.graph;
      const Vec3 start = place(s, 1, cracks.edges()[cracks.trims()].a), end = place(s, 1, on.p),
                 met(seam_at(kCross), kCross, 0.0);
      const Vec3 way = (end - start).normalized(), before(tip.direction.x(), tip.direction.y(), 0.0);
      EXPECT_LT((start - met).norm(), 0.03 * s.model(1).spacing) << times;
      EXPECT_LT((way - before).norm(), 1e-3) << times;
      EXPECT_EQ(propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0), 0);  // once
    }
}

TEST(TrimCracks, NothingStartsWhereTheOtherShellIsCrackedOrCannotCrack) {
  Stitched whole = plates(0);
  end_on_seam(whole, {0.2, 0.52});
  EXPECT_EQ(propagate_over_seams(whole.seams(), whole.refs(), {1, 0}, whole.stitching(), 0.0), 0);
  EXPECT_FALSE(whole.state(1).cracks.graph.has_cracks());
  Stitched cracked = plates(0);
  end_on_seam(cracked, {0.2, 0.52});
  insert_polyline(cracked.model(1), cracked.state(1), {{0.5, 0.52}, {seam_at(kCross) - 0.3, kCross}}, 0.0);
  const std::size_t edges = cracked.state(1).cracks.graph.edges().size();
  EXPECT_EQ(propagate_over_seams(cracked.seams(), cracked.refs(), {1, 1}, cracked.stitching(), 0.0), 0);
  EXPECT_EQ(cracked.state(1).cracks.graph.edges().size(), edges);
}

// A crack that comes along the seam crosses it at a small angle, and goes into the other plate.
TEST(TrimCracks, AFlatOneCrossesAllTheSame) {
  Stitched s = plates(1);
  const Vec2 along = Vec2(0.1, 1.0).normalized();
  end_on_seam(s, Vec2(seam_at(kCross), kCross) - 0.2 * along + 1e-3 * Vec2(-along.y(), along.x()));
  EXPECT_EQ(propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0), 1);
  ASSERT_EQ(s.state(1).cracks.tips.size(), 1u);
  const Vec3 end = place(s, 1, s.state(1).cracks.tips[0].p);
  EXPECT_GT(end.x() - seam_at(end.y()), 0.2 * s.model(1).spacing);
  EXPECT_GT(end.y(), kCross);
}

// After a crack through both plates nothing joins what is above it to what is below, and ties further off stay.
TEST(TrimCracks, PartTiesAcrossThemAndNoOthers) {
  for (const int times : {0, 1}) {
    Stitched s = plates(times);
    const auto cracked = [&](double y) { return kCross + 0.3 * y; };
    const auto height = [&](int shell, int slot) {
      const ShellModel& m = s.model(shell);
      const int point = m.tables.control_point(slot);
      const Vec3 x = place(s, shell, m.trim.home[point]);
      return x.y() - cracked(x.x() - seam_at(kCross));
    };
    int before = 0, after = 0, across = 0, left = 0;
    const double far = 4.0 * s.model(0).spacing;
    s.stitching().each_link([&](int a, int i, int, int) { before += std::abs(height(a, i)) > far; });
    const auto cut = [&](int shell, double from, double to) {
      std::vector<Vec2> line;
      for (const double x : {from, to}) {
        Vec2 p(x, cracked(x - seam_at(kCross)));
        if (shell == 1) p.x() -= 0.3;
        for (int k = 0; k < times && shell == 1; ++k) p = Vec2(p.y(), (k % 2 == 0 ? 0.7 : 1.0) - p.x());
        line.push_back(p);
      }
      insert_polyline(s.model(shell), s.state(shell), line, 0.0);
    };
    cut(0, 0.0, seam_at(kCross)), cut(1, seam_at(kCross), 1.0);
    propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0);
    EXPECT_TRUE(s.stitching().parted());
    s.stitching().each_link([&](int a, int i, int b, int j) {
      after += std::abs(height(a, i)) > far, ++left;
      across += (height(a, i) > 0.0) != (height(b, j) > 0.0);
    });
    EXPECT_EQ(across, 0) << times;
    EXPECT_GE(after, before) << times;  // functions beside a crack reach further
    EXPECT_GT(left, before);            // beside the crack, too
    // What is above moves on by itself: it loses nothing to what is below.
    Vec3 own = Vec3::Zero(), later = Vec3::Zero();
    const auto above = [&](Vec3& sum) {
      for (int k = 0; k < 2; ++k) {
        std::vector<Piece> pieces;
        const Triangulation t = partition(s.model(k), s.state(k), pieces);
        for (int i = 0; i < s.model(k).control_points(); ++i)
          if (const int slot = s.model(k).tables.slot(i); height(k, slot) > 0.0)
            sum += s.state(k).motion.mass[slot] * s.state(k).velocity(slot);
      }
    };
    for (int k = 0; k < 2; ++k)
      for (int i = 0; i < s.model(k).control_points(); ++i)
        if (const int slot = s.model(k).tables.slot(i);
            height(k, slot) > 0.0 && s.state(k).motion.inverse_mass[slot] > 0.0)
          s.state(k).add_velocity(slot, Vec3(1.0, 0.2, 0.3));
    above(own);
    const auto sums = s.sums();
    s.run(200, 0.5 * s.stable());
    above(later);
    EXPECT_LT((later - own).norm(), 1e-12 * own.norm()) << times;
    EXPECT_LT((s.sums().momentum - sums.momentum).norm(), 1e-12 * sums.momentum_scale);
    EXPECT_LT((s.sums().angular - sums.angular).norm(), 1e-12 * sums.angular_scale);
  }
}

// In a bent, spinning plate new ties hold where they are: momenta stay, and nothing is pulled together at once.
TEST(TrimCracks, NewTiesKeepMomentaAndPlaces) {
  Stitched s = plates(1);
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); ++i) {
      const int slot = s.model(k).tables.slot(i);
      if (s.state(k).motion.inverse_mass[slot] == 0.0) continue;
      const Vec3 x = s.state(k).position(slot) - Vec3(0.5, 0.5, 0.0);
      s.state(k).add_velocity(slot, Vec3(3, 5, -4).cross(x) + Vec3(0, 0, 20.0 * x.y() * x.y() - 10.0 * x.x() * x.x()));
    }
  s.stitching().align_velocities(s.refs());
  const double dt = 0.5 * s.stable();
  s.run(100, dt);
  const auto before = s.sums();
  const double energy = s.forces(true) + s.kinetic(dt);
  end_on_seam(s, {0.2, 0.52});
  const double cut = s.forces(true) + s.kinetic(dt);
  propagate_over_seams(s.seams(), s.refs(), {1, 1}, s.stitching(), 0.0);
  const auto after = s.sums();
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * before.angular_scale);
  const double now = s.forces(true) + s.kinetic(dt);
  // cutting takes energy, and so does what no longer fits; else it is booked
  const double injected = s.state(0).book.injected + s.state(1).book.injected;
  EXPECT_LT(now, energy * (1.0 + 1e-9) + injected);
  EXPECT_LT(injected, 1e-3 * energy);
  EXPECT_GT(now, cut * (1.0 - 0.02));
  s.run(400, dt);
  const auto end = s.sums();
  EXPECT_LT((end.momentum - before.momentum).norm(), 1e-11 * before.momentum_scale);
  EXPECT_LT((end.angular - before.angular).norm(), 1e-11 * before.angular_scale);
  EXPECT_LT(s.forces(true) + s.kinetic(dt), now * (1.0 + 1e-3));
}

// Once all ties have parted, nothing is left to keep.
TEST(TrimCracks, NothingIsKeptWhereAllHasParted) {
  Stitched s = plates(0);
  s.stitching().release(s.refs(), [](int shell, int) { return shell == 1; });
  int left = 0;
  s.stitching().each_link([&](int, int, int, int) { ++left; });
  EXPECT_EQ(left, 0);
  for (std::size_t i = 0; i < s.state(1).motion.mass.size(); ++i)
    if (s.state(1).motion.inverse_mass[i] > 0.0) s.state(1).add_velocity(static_cast<int>(i), Vec3(1.0, 0.2, 0.3));
  const auto before = s.sums();
  s.run(20, 0.5 * s.stable());
  EXPECT_LT((s.sums().momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
  for (std::size_t i = 0; i < s.state(0).motion.mass.size(); ++i)
    EXPECT_LT(s.state(0).velocity(static_cast<int>(i)).norm(), 1e-9);  // round-off of the shape at rest
}
