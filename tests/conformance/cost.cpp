// Time of a window, exchange of messages included. Reported, never judged.
#include <algorithm>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

constexpr int kCostWindows = 100, kCostColumns = 32;
constexpr double kCostSpacing = 0.1;  // [m]: bodies do not touch

void cost(Suite& s, const std::function<RigidBody(BodyId)>& make, double height, bool floor) {
  for (const int count : {1, 100, 1000}) {
    std::vector<RigidBody> bodies;
    if (floor) bodies.push_back(half_space(1));
    for (int i = 0; i < count; ++i)
      bodies.push_back(at(make(static_cast<BodyId>(2 + i)),
                          {kCostSpacing * (i % kCostColumns), kCostSpacing * (i / kCostColumns), height}));
    Play play(s.target, {{bodies, law(0.5, 0.0), {}}, floor ? gravity() : Vec3(0, 0, 0)});
    std::vector<double> times;
    for (int i = 0; i < kCostWindows; ++i) {
      const std::vector<link::Motion> predicted = play.flight();
      const double before = seconds_now();
      play.window_on(predicted);
      times.push_back(seconds_now() - before);
    }
    std::nth_element(times.begin(), times.begin() + kCostWindows / 2, times.end());
    s.report.tell(fmt::format("bodies_{}", count), 1e6 * times[kCostWindows / 2], "microseconds a window, median");
    play.end();
  }
}

}  // namespace

std::vector<Case> cost_cases() {
  return {
      {"cost_flight",
       "spheres that fly",
       {kSpheres},
       [](Suite& s) {
         cost(
             s, [](BodyId id) { return sphere(id, 0.02); }, 1.0, false);
       }},
      {"cost_resting",
       "boxes that lie on a half space",
       {kBoxes, kHalfSpaces, kContact},
       [](Suite& s) {
         cost(
             s,
             [](BodyId id) {
               return box(id, {0.03, 0.02, 0.01});
             },
             0.01, true);
       }},
      {"cost_shards",
       "shards that lie on a half space",
       {kConvexHulls, kHalfSpaces, kContact},
       [](Suite& s) {
         cost(
             s, [](BodyId id) { return plate(id, {rectangle(0, 0, 0.06, 0.04)}, 0.004); }, 0.002, true);
       }},
  };
}

}  // namespace sunder::conformance
