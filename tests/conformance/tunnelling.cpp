// Number of fast thin shards that pass through a thin plate.
#include <cmath>
#include <set>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

constexpr int kShards = 300, kColumns = 18;
constexpr double kSide = 0.03, kThickness = 0.004, kSpeed = 10.0;  // [m], [m/s]
constexpr double kSpacing = 0.055;

std::vector<RigidBody> rain() {
  std::mt19937 random(11);
  std::vector<RigidBody> out;
  for (int i = 0; i < kShards; ++i) {
    const auto id = static_cast<BodyId>(2 + i);
    const double a = uniform(random, -3, 3), b = uniform(random, -3, 3), c = uniform(random, -3, 3);
    const RigidBody shard = turned(plate(id, {rectangle(0, 0, kSide, kSide)}, kThickness), {a, b, c});
    const double height = uniform(random, 0.05, 0.3);
    const Vec3 place(kSpacing * (i % kColumns - 0.5 * (kColumns - 1)), kSpacing * (i / kColumns - 8.0), height);
    out.push_back(moving(at(shard, place), {0, 0, -kSpeed}, {c, a, b}));
  }
  return out;
}

// Counts shards whose centre was half a thickness below the lower face, away from the edges.
void fall(Suite& s, const RigidBody& below, double lower_face, double window_s, double allowed) {
  std::vector<RigidBody> bodies = rain();
  bodies.push_back(below);
  Play play(s.target, {{bodies, law(0.5, 0.0), {}}, gravity(), window_s});
  std::set<BodyId> passed;
  for (long i = std::lround(0.08 / window_s); i > 0; --i) {
    play.window();
    for (const link::State& state : play.states()) {
      const Vec3& x = state.motion.position;
      if (x.z() < lower_face - 0.5 * kThickness && x.head<2>().cwiseAbs().maxCoeff() < 0.55) passed.insert(state.id);
    }
  }
  s.report.check(fmt::format("window_{:g}ms", 1e3 * window_s), static_cast<double>(passed.size()), 0.0, allowed,
                 "shards of 300 that pass at 10 m/s");
  play.end();
}

void onto_plate(Suite& s) {
  const RigidBody pane = fixed(box(1, {0.6, 0.6, 0.5 * kThickness}));
  // 5 mm a window is 1.25 thicknesses, the largest approach in a window that the coupler allows: no shard may pass. At
  // 10 mm a window one in a hundred may.
  fall(s, pane, -0.5 * kThickness, 5e-4, 0.0);
  fall(s, pane, -0.5 * kThickness, 1e-3, 0.01 * kShards);
}

void onto_half_space(Suite& s) {  // no shard passes at any speed
  for (const double window_s : {5e-4, 1e-3}) fall(s, half_space(1), 0.0, window_s, 0.0);
}

RigidBody hull_box(BodyId id, const Vec3& half) {
  return plate(id, {rectangle(-half.x(), -half.y(), half.x(), half.y())}, 2.0 * half.z());
}

// A cube or ball of 0.2 m flies at a wall of 0.2 m, frictionless and without a bounce, over up to forty times its size
// a window. It stops before the wall, or leaves sideways where it hits with an edge: it never gets through, and never
// comes back faster than it came.
void shoot(Suite& s, const std::string& what, const RigidBody& cube, const RigidBody& wall, const Vec3& turn) {
  constexpr double half = 0.1;
  const bool is_round = std::holds_alternative<SphereShape>(cube.shape);
  for (const auto& [speed, window_s] :
       {std::pair{20.0, 1e-3}, {50.0, 1e-3}, {200.0, 1e-3}, {50.0, 1.0 / 60}, {500.0, 1.0 / 60}}) {
    const RigidBody shot = moving(at(turned(cube, turn), {-2.0, 0.013, -0.021}), {speed, 0, 0});
    Play play(s.target, {{{shot, fixed(wall)}, law(0.0, 0.0), {}}, Vec3::Zero(), window_s});
    double deepest = -1.0, back = 0.0, fastest = 0.0;
    for (long i = std::lround(4.0 / speed / window_s) + 4; i > 0; --i) {
      play.window();
      const BodyMotion& now = play.body(shot.id).motion;
      const Vec3 sides = now.orientation.conjugate() * Vec3::UnitX();
      const double reach = is_round ? half : half * sides.lpNorm<1>();
      deepest = std::max(deepest, now.position.x() + reach + half);
      back = std::max(back, -now.velocity.x()), fastest = std::max(fastest, play.kinetic_energy());
    }
    play.end();
    const std::string name = fmt::format("{}_{:g}m_{:.0f}ms", what, speed, 1e3 * window_s);
    // Where the cube is askew, an edge hits first. In the rest of the window the cube turns into the wall a little, and
    // then its other side pushes it back.
    s.report.check(name + "_depth", std::max(0.0, deepest), 0.0, (turn.isZero() ? 0.1 : 0.4) * half,
                   is_round ? "of the ball in the wall [m]" : "of the cube in the wall [m]");
    s.report.check(name + "_back", back / speed, 0.0, turn.isZero() ? 0.02 : 0.2, "share of the speed");
    s.report.check(name + "_energy", std::max(0.0, 2.0 * fastest / (shot.mass * speed * speed) - 1.0), 0.0, 1e-6,
                   "gain");
  }
}

}  // namespace

std::vector<Case> tunnelling_cases() {
  const Vec3 cube(0.1, 0.1, 0.1), wall(0.1, 2.0, 2.0), straight(0, 0, 0), askew(0.3, 0.5, -0.2);
  return {
      {"tunnelling_plate", "300 shards fall onto a 4 mm plate", {kConvexHulls, kBoxes, kContact}, onto_plate},
      {"tunnelling_half_space",
       "300 shards fall onto a half space",
       {kConvexHulls, kHalfSpaces, kContact},
       onto_half_space},
      {"wall_hull",
       "a hull is shot at a static box",
       {kConvexHulls, kBoxes, kContact},
       [=](Suite& s) {
         shoot(s, "straight", hull_box(2, cube), box(1, wall), straight);
         shoot(s, "askew", hull_box(2, cube), box(1, wall), askew);
       }},
      {"wall_hulls",
       "a hull is shot at a static hull",
       {kConvexHulls, kContact},
       [=](Suite& s) {
         shoot(s, "straight", hull_box(2, cube), hull_box(1, wall), straight);
         shoot(s, "askew", hull_box(2, cube), hull_box(1, wall), askew);
       }},
      {"wall_box",
       "a box is shot at a static box",
       {kBoxes, kContact},
       [=](Suite& s) {
         shoot(s, "straight", box(2, cube), box(1, wall), straight);
         shoot(s, "askew", box(2, cube), box(1, wall), askew);
       }},
      {"wall_sphere",
       "a sphere is shot at a static sphere, head-on",
       {kSpheres, kContact},
       [=](Suite& s) {
         shoot(s, "straight", sphere(2, 0.1), at(sphere(1, 5.0), {4.9, 0.013, -0.021}), straight);
       }},
  };
}

}  // namespace sunder::conformance
