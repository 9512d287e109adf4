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

}  // namespace

std::vector<Case> tunnelling_cases() {
  return {
      {"tunnelling_plate", "300 shards fall onto a 4 mm plate", {kConvexHulls, kBoxes, kContact}, onto_plate},
      {"tunnelling_half_space",
       "300 shards fall onto a half space",
       {kConvexHulls, kHalfSpaces, kContact},
       onto_half_space},
  };
}

}  // namespace sunder::conformance
