// What points see past cracks, by brute force.
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/fracture/visibility.h"
#include "shell/solver/cracking/insertion.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellModel sheet() {
  return make_shell("p", plate(0.2, 0.2, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
}

}  // namespace

TEST(Visibility, KeptWhileCracksGrowSeesWhatIsVisible) {
  const ShellModel m = sheet();
  const ControlGrid grid = control_grid(m);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 0.2);
  CrackGraph g({0, 0}, {0.2, 0.2}, 2.0 * m.spacing, 1e-2 * m.spacing);
  std::vector<Visibility> kept;
  for (int i = 0; i < 60; ++i) {
    const Vec2 p(uniform(random), uniform(random));
    kept.emplace_back(grid, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
  }
  for (int step = 0; step < 12; ++step) {
    for (int k = 0; k < 3; ++k) {
      const Vec2 a(uniform(random), uniform(random)), d(uniform(random) - 0.1, uniform(random) - 0.1);
      const int from = g.add_vertex(a), to = g.add_vertex(a + 1.5 * m.spacing * d.normalized());
      g.add_edge(from, to, g.new_crack(), 0.0, 0);
    }
    const int end = static_cast<int>(g.edges().size()) - 1;  // the last is only tried
    for (Visibility& visibility : kept) {
      visibility.update(grid, g, end);
      std::set<int> seen, visible;
      visibility.each(grid, [&](int k) { seen.insert(k); });
      for (int k = 0; k < m.control_points(); ++k)
        if (grid.offset(visibility.point(), k).cwiseAbs().maxCoeff() < kLargestSupport &&
            g.visible(visibility.point(), m.parameter[k], end))
          visible.insert(k);
      EXPECT_EQ(seen, visible) << "step " << step;
    }
    g.undo_edge();
  }
}

// Along rows and columns of control points, through them and through the eye itself, where round-off would decide.
TEST(Visibility, LosesWhatAnEdgeAlongTheLatticeHides) {
  const ShellModel m = sheet();
  const ControlGrid grid = control_grid(m);
  const double h = m.spacing;
  const Vec2 eye = m.parameter[10 * m.tables.columns + 10] + Vec2(0.3 * h, 0.2 * h),
             corner = m.parameter[11 * m.tables.columns + 11];
  const std::pair<Vec2, Vec2> edges[] = {
      {eye + Vec2(-h, 0.5 * h), eye + Vec2(h, 0.5 * h)},                                    // flat
      {eye + Vec2(0.5 * h, -h), eye + Vec2(0.5 * h, h)},                                    // upright
      {corner - Vec2(h, 0), corner + Vec2(h, 0)},                                           // on a row
      {corner - Vec2(0, h), corner + Vec2(0, h)},                                           // on a column
      {corner, corner + Vec2(h, h)},                                                        // from a control point
      {eye + Vec2(h, 0), eye + Vec2(2 * h, h)},                                             // an end level with the eye
      {eye, eye + Vec2(h, 0.3 * h)},                                                        // from the eye
      {eye + Vec2(h, 0), eye + Vec2(2 * h, 0)},                                             // in line with it
      {eye + 0.4 * (corner - eye), eye + 0.4 * (corner - eye) + Vec2(0.7 * h, -0.2 * h)}};  // on the way to one
  int lost = 0;
  for (const auto& [a, b] : edges) {
    CrackGraph g({0, 0}, {0.2, 0.2}, 2.0 * h, 0.0);
    const int from = g.add_vertex(a), to = g.add_vertex(b);
    ASSERT_EQ(g.add_edge(from, to, g.new_crack(), 0.0, 0), 0);
    const CrackEdge& e = g.edges()[0];
    const Visibility open(grid, eye, m.patch.knots_u.span_of(eye.x()), m.patch.knots_v.span_of(eye.y()));
    Visibility seen = open;
    seen.update(grid, g, 1);
    std::set<int> left;
    seen.each(grid, [&](int k) { left.insert(k); });
    open.each(grid, [&](int k) {
      const bool hidden = segments_meet(eye, m.parameter[k], e.long_a, e.long_b);
      EXPECT_EQ(left.count(k), hidden ? 0u : 1u) << "control point " << k;
      Visibility one = open;
      one.close(), one.show(grid, k);
      EXPECT_EQ(one.loses(grid, e), hidden) << "control point " << k;
      lost += hidden;
    });
    EXPECT_FALSE(seen.loses(grid, e));
  }
  EXPECT_GT(lost, 100);
}
