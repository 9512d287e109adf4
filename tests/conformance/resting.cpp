// Bodies at rest do not move, and a stack of thin plates stands.
#include <algorithm>
#include <cmath>

#include "tests/conformance/suite.h"

namespace sunder::conformance {
namespace {

using namespace link::capability;

// A tenth of a millimetre is a few percent of the thinnest pane and does not show in a picture.
constexpr double kHeight_m = 1e-4;
// At rest a contact solver leaves a few percent of the speed that gravity adds in a window, 10 mm/s at 1 ms.
constexpr double kSpeed_m_s = 1e-3;
// A tenth of a plate's thickness for all twenty: a pile that sinks by a thickness would show.
constexpr double kStack_m = 3e-4;

// A light body gives way a little under a heavy one. Squeezed out, it lets the upper one down by its whole height.
constexpr double kSquashed_m = 1e-3;

// Dropped from a small height. A body born in contact may keep an overlap, which would hide an engine with gaps.
constexpr double kDrop_m = 2e-3;

void lie(Suite& s, const RigidBody& lower, const RigidBody& upper) {
  const RigidBody dropped = at(upper, upper.motion.position + Vec3(0, 0, kDrop_m));
  Play play(s.target, {{{lower, dropped}, law(0.5, 0.0), {}}, gravity()});
  play.run(1.0);
  const BodyMotion &end = play.body(upper.id).motion, &start = upper.motion;
  s.report.check_error("height", end.position.z(), start.position.z(), std::abs(end.position.z() - start.position.z()),
                       kHeight_m, "after 1 s [m]");
  s.report.check("drift", (end.position - start.position).head<2>().norm(), 0.0, kHeight_m, "sideways [m]");
  s.report.check("speed", end.velocity.norm(), 0.0, kSpeed_m_s, "[m/s]");
  play.end();
}

void stack(Suite& s, const std::function<RigidBody(BodyId)>& make) {
  constexpr int count = 20;
  constexpr double thickness = 0.003;
  std::vector<RigidBody> bodies{half_space(1)};
  for (int i = 0; i < count; ++i) bodies.push_back(at(make(static_cast<BodyId>(2 + i)), {0, 0, (i + 0.5) * thickness}));
  Play play(s.target, {{bodies, law(0.5, 0.0), {}}, gravity()});
  play.run(2.0);
  double height = 0.0, drift = 0.0;
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Vec3 moved = play.body(bodies[i].id).motion.position - bodies[i].motion.position;
    height = std::max(height, std::abs(moved.z())), drift = std::max(drift, moved.head<2>().norm());
  }
  s.report.check("height", height, 0.0, kStack_m, "worst of twenty plates after 2 s [m]");
  s.report.check("drift", drift, 0.0, kStack_m, "sideways [m]");
  play.end();
}

// A cube of 0.2 m and 1 kg under one that is heavier by a ratio, exactly stacked.
void heavy_on_light(Suite& s, double ratio, double window_s) {
  const double half = 0.1;
  RigidBody lower = at(box(2, {half, half, half}), {0, 0, half}),
            upper = at(box(3, {half, half, half}), {0, 0, 3 * half});
  for (RigidBody* b : {&lower, &upper}) {
    const double mass = b == &upper ? ratio : 1.0;
    b->principal_inertia *= mass / b->mass, b->mass = mass;
  }
  const RigidBody ground = at(fixed(box(1, {1, 1, 0.05})), {0, 0, -0.05});
  Play play(s.target, {{{ground, lower, upper}, law(0.8, 0.0), {}}, gravity(), window_s});
  play.run(2.0);
  for (const RigidBody* b : {&lower, &upper}) {
    const Vec3 moved = play.body(b->id).motion.position - b->motion.position;
    const std::string name = b == &upper ? "upper" : "lower";
    s.report.check(name + "_height", std::abs(moved.z()), 0.0, kSquashed_m, "after 2 s [m]");
    s.report.check(name + "_drift", moved.head<2>().norm(), 0.0, 0.1 * half, "sideways [m]");
  }
  play.end();
}

}  // namespace

std::vector<Case> resting_cases() {
  const auto slab = at(fixed(box(1, {0.2, 0.2, 0.02})), {0, 0, -0.02});
  const auto tile = [](BodyId id) { return plate(id, {rectangle(-0.075, -0.075, 0.075, 0.075)}, 0.003); };
  return {
      {"rest_sphere",
       "a sphere lies on a half space",
       {kSpheres, kHalfSpaces, kContact},
       [](Suite& s) {
         lie(s, half_space(1), at(sphere(2, 0.05), {0, 0, 0.05}));
       }},
      {"rest_box",
       "a box lies on a half space",
       {kBoxes, kHalfSpaces, kContact},
       [](Suite& s) {
         lie(s, half_space(1), at(box(2, {0.05, 0.04, 0.02}), {0, 0, 0.02}));
       }},
      {"rest_box_on_box",
       "a box lies on a static box",
       {kBoxes, kContact},
       [=](Suite& s) {
         lie(s, slab, at(box(2, {0.05, 0.04, 0.02}), {0, 0, 0.02}));
       }},
      {"rest_shard",
       "a shard lies on a half space",
       {kConvexHulls, kHalfSpaces, kContact},
       [=](Suite& s) {
         lie(s, half_space(1), at(tile(2), {0, 0, 0.0015}));
       }},
      {"rest_shard_on_box",
       "a shard lies on a static box",
       {kConvexHulls, kBoxes, kContact},
       [=](Suite& s) {
         lie(s, slab, at(tile(2), {0, 0, 0.0015}));
       }},
      {"stack_boxes",
       "twenty boxes 150 x 150 x 3 mm stand",
       {kBoxes, kHalfSpaces, kContact, kFriction},
       [](Suite& s) { stack(s, [](BodyId id) {
                        return box(id, {0.075, 0.075, 0.0015});
                      }); }},
      {"stack_100_to_1",
       "a cube on one that is a hundred times lighter, windows of 2 ms",
       {kBoxes, kContact, kFriction},
       [](Suite& s) { heavy_on_light(s, 100.0, 2e-3); }},
      {"stack_1000_to_1",
       "a thousand times lighter, windows of 10 ms",
       {kBoxes, kContact, kFriction, kMassRatios},
       [](Suite& s) { heavy_on_light(s, 1000.0, 1e-2); }},
      {"stack_advised",
       "a thousand times lighter, in windows that the warning of run.json names",
       {kBoxes, kContact, kFriction},
       [](Suite& s) { heavy_on_light(s, 1000.0, s.info.can(kDoublePrecision) ? 3.1e-4 : 1e-4); }},
      {"stack_shards",
       "the same as convex hulls",
       {kConvexHulls, kHalfSpaces, kContact, kFriction},
       [=](Suite& s) { stack(s, tile); }},
  };
}

}  // namespace sunder::conformance
