// What is kept between two looks at the cracks is what a whole look would find.
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "shell/fracture/crack_loops.h"
#include "shell/fracture/triangulation.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/surroundings.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSide = 0.2;

ShellModel sheet() {
  return make_shell("p", plate(kSide, kSide, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
}

// Cracks that wander, an edge of one at a time, until they meet something; now and then one starts on an older one.
struct Wanderers {
  struct Tip {
    int vertex, crack;
    double angle;
    bool alive = true, fresh = true;
  };
  const ShellModel& m;
  CrackGraph graph{Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4};
  std::mt19937_64 random;
  std::vector<Tip> tips{};

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  void start() {
    Vec2 p(uniform(0.0, kSide), uniform(0.0, kSide));
    const double angle = uniform(0.0, 2.0 * std::numbers::pi);
    if (!graph.edges().empty() && random() % 2 == 0) {
      const CrackEdge& e = graph.edges()[random() % graph.edges().size()];
      p = e.a + uniform(0.0, 1.0) * (e.b - e.a) - 2e-3 * m.spacing * Vec2(std::cos(angle), std::sin(angle));
    }
    tips.push_back({graph.add_vertex(p), graph.new_crack(), angle, true, true});
  }
  void step() {
    Tip& tip = tips[random() % tips.size()];
    if (!tip.alive) return start();
    if (!std::exchange(tip.fresh, false)) tip.angle += uniform(-0.6, 0.6);
    const Vec2 a = graph.vertices()[tip.vertex], d(std::cos(tip.angle), std::sin(tip.angle));
    Vec2 b = a + m.spacing * d;
    double nearest = 1.0;
    graph.near(a, b, 0.0, [&](int k) {
      const CrackEdge& e = graph.edges()[k];
      const double p = orientation(e.a, e.b, a), q = orientation(e.a, e.b, b);
      const bool own = e.from == tip.vertex || e.to == tip.vertex;
      if (!own && segments_meet(a, b, e.a, e.b) && p / (p - q) > 0.01) nearest = std::min(nearest, p / (p - q));
      return true;
    });
    const bool inside = (b.array() > 0.0).all() && (b.array() < kSide).all();
    tip.alive = nearest == 1.0 && inside;
    b = a + nearest * (b - a) + (nearest < 1.0 ? 2e-3 * m.spacing : 0.0) * d;
    const int next = graph.add_vertex(b);
    graph.add_edge(tip.vertex, next, tip.crack, 0.0, 0);
    tip.vertex = next;
  }
};

void expect_same(const std::vector<SeenPoint>& a, const std::vector<SeenPoint>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    ASSERT_TRUE(a[k].block == b[k].block && a[k].lane == b[k].lane && a[k].offset == b[k].offset &&
                a[k].angle == b[k].angle && a[k].weight == b[k].weight);
}

}  // namespace

TEST(CrackLoops, NoPieceIsAddedUnlessALoopHasClosed) {
  const ShellModel m = sheet();
  int edges = 0, alarms = 0, pieces = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(seed)};
    CrackLoops loops;
    int before = 1;
    const std::array all{domain_of(m)};
    w.start();
    while (w.graph.edges().size() < 150) {
      const std::size_t known = w.graph.edges().size();
      w.step();
      if (w.graph.edges().size() == known) continue;
      const bool closed = loops.closed(w.graph, Vec2::Zero(), Vec2(kSide, kSide), m.spacing);
      const int now = triangulate(m.patch.knots_u, m.patch.knots_v, w.graph, {}, m.spacing, 0.0, all).pieces;
      EXPECT_TRUE(closed || now == before) << "edge " << known << " of seed " << seed;
      ++edges, alarms += closed, before = now;
    }
    pieces += before;
    // knots among the vertices draw the pieces finer and leave them the same
    const auto pieces_of = [&](std::span<const Eigen::AlignedBox2d> knots_in) {
      return triangulate(m.patch.knots_u, m.patch.knots_v, w.graph, m.parameter, m.spacing,
                         0.02 * m.spacing * m.spacing, knots_in);
    };
    const Triangulation fine = pieces_of(all), coarse = pieces_of({});
    EXPECT_EQ(fine.pieces, coarse.pieces);
    EXPECT_LT(coarse.triangles.size(), fine.triangles.size());
    // and so do knots in the box of one alone, to the triangle
    for (int piece = 0; piece < fine.pieces; ++piece) {
      const auto extent = [](const Triangulation& t, int number) {
        Eigen::AlignedBox2d box;
        double area = 0.0;
        for (const int i : t.triangles_of(number)) {
          const auto& c = t.triangles[i];
          EXPECT_EQ(t.piece[i], number);
          for (const int corner : c) box.extend(t.vertices[corner]);
          area += triangle_area(t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]]);
        }
        return std::pair(box, area);
      };
      const auto owned = std::find(fine.owner.begin(), fine.owner.end(), piece);
      if (owned == fine.owner.end()) continue;
      const auto [box, area] = extent(fine, piece);
      const Triangulation local = pieces_of(std::array{box});
      const int number = local.owner[owned - fine.owner.begin()];
      EXPECT_EQ(local.triangles_of(number).size(), fine.triangles_of(piece).size());
      EXPECT_NEAR(extent(local, number).second, area, 1e-12);
    }
    std::map<int, int> same;
    for (std::size_t k = 0; k < fine.owner.size(); ++k)
      EXPECT_EQ(same.try_emplace(fine.owner[k], coarse.owner[k]).first->second, coarse.owner[k]);
  }
  EXPECT_GT(pieces, 60);
  EXPECT_LT(alarms, 2 * pieces);
  EXPECT_LT(alarms, edges / 3);
}

TEST(CrackLoops, AnEdgeBackToTheFirstVertexClosesOne) {
  CrackGraph g(Vec2::Zero(), Vec2(1.0, 1.0), 0.1, 1e-3);
  CrackLoops loops;
  const int crack = g.new_crack(), a = g.add_vertex({0.3, 0.3}), b = g.add_vertex({0.6, 0.3}),
            c = g.add_vertex({0.5, 0.6});
  g.add_edge(a, b, crack, 0.0, 0), g.add_edge(b, c, crack, 0.0, 0);
  EXPECT_FALSE(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05));
  g.add_edge(c, a, crack, 0.0, 0);
  EXPECT_TRUE(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05));
}

TEST(CrackLoops, OneEdgeFromBorderToBorderClosesOne) {
  for (const bool across : {true, false}) {
    CrackGraph g(Vec2::Zero(), Vec2(1.0, 1.0), 0.1, 1e-3);
    CrackLoops loops;
    g.add_edge(g.add_vertex({0.3, -0.1}), g.add_vertex({0.4, across ? 1.1 : 0.9}), g.new_crack(), 0.0, 0);
    EXPECT_EQ(loops.closed(g, Vec2::Zero(), Vec2(1.0, 1.0), 0.05), across);
  }
}

TEST(Surroundings, AreTheSameWhetherKeptOrFoundAnew) {
  const ShellModel m = sheet();
  Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(3)};
  std::vector<std::pair<Look, Surroundings>> kept;
  for (int k = 0; k < 40; ++k) {
    const double angle = w.uniform(0.0, 2.0 * std::numbers::pi);
    kept.push_back({{{w.uniform(0.0, kSide), w.uniform(0.0, kSide)},
                     2.5 * m.spacing,
                     k % 2 ? Vec2(std::cos(angle), std::sin(angle)) : Vec2(Vec2::Zero()),
                     k % 4 == 1 ? k : -1},
                    {}});
  }
  w.start();
  std::vector<std::size_t> uncracked;
  for (auto& [look, known] : kept) uncracked.push_back(known.seen(m, w.graph, look).size());
  int hidden = 0;
  for (int step = 0; step < 400; ++step) {
    w.step();
    if (step % 7 != 0) continue;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      auto& [look, known] = kept[i];
      expect_same(known.seen(m, w.graph, look), Surroundings().seen(m, w.graph, look));
      if (step > 390) hidden += 2 * known.seen(m, w.graph, look).size() < uncracked[i];
    }
  }
  EXPECT_GT(hidden, 20U);              // cracks did hide some
  auto& [look, known] = kept.front();  // another look is no old one
  look.p += Vec2(0.013, 0.004);
  expect_same(known.seen(m, w.graph, look), Surroundings().seen(m, w.graph, look));
}

TEST(Neighbours, AreWhatSurroundsAPointWhetherKeptOrFoundAnew) {
  const ShellModel m = sheet();
  Wanderers w{m, {Vec2::Zero(), Vec2(kSide, kSide), 0.02, 1e-4}, std::mt19937_64(5)};
  std::vector<std::pair<Vec2, Neighbours>> kept;
  for (int k = 0; k < 40; ++k) kept.push_back({{w.uniform(0.0, kSide), w.uniform(0.0, kSide)}, {}});
  w.start();
  std::size_t most = 0, least = 1000000;
  for (int step = 0; step < 400; ++step) {
    w.step();
    if (step % 7 != 0) continue;
    for (auto& [p, known] : kept) {
      // now a larger circle, now the first again
      const double radius = (step % 91 == 0 ? 3.5 : 2.5) * m.spacing;
      const auto& near = known.seen(m, w.graph, p, radius);
      Surroundings anew;
      const auto& around = anew.seen(m, w.graph, {p, radius});
      ASSERT_EQ(near.size(), around.size());
      most = std::max(most, near.size()), least = std::min(least, near.size());
      for (std::size_t i = 0; i < near.size(); ++i) {
        EXPECT_EQ(near[i].block, around[i].block);
        EXPECT_EQ(near[i].lane, around[i].lane);
        EXPECT_EQ(near[i].weight, around[i].weight);
      }
    }
  }
  EXPECT_LT(3 * least, most);  // cracks did hide some
}
