#pragma once
// Cracks without mechanics, for what only their geometry decides.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "tests/shell/fixtures.h"

namespace sunder::shell {

constexpr double kSide = 0.2;

inline ShellModel wandered_sheet() {
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

}  // namespace sunder::shell
