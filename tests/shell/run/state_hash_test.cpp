// The hash of a state: what changes it, and what does not.
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shell/run/state_hash.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Rig sheet_and_ball() {
  RunSetup s = setup_of({{brittle_sheet(6)}});
  RigidBody b;
  b.id = 3, b.name = "ball", b.mass = 0.1, b.principal_inertia = Vec3::Constant(1e-5), b.shape = SphereShape{0.01};
  s.bodies = {b};
  Rig rig(std::move(s));
  insert_polyline(rig.model(), rig.state(), {{0.03, 0.05}, {0.12, 0.09}}, 0.0);
  return rig;
}

double next(double value) { return std::nextafter(value, 1e300); }

}  // namespace

TEST(StateHash, OfNothingIsThatOfNoBytes) {
  EXPECT_EQ(state_hash("", State{}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(StateHash, ChangesWithTheLastBitOfEachResult) {
  const std::string same = state_hash("a", sheet_and_ball().now());
  EXPECT_EQ(state_hash("a", sheet_and_ball().now()), same);
  const std::vector<std::function<void(Rig&)>> changes = {
      [](Rig& r) { r.state().motion.x[5] = next(r.state().motion.x[5]); },
      [](Rig& r) { r.state().motion.v[5] = next(r.state().motion.v[5]); },
      [](Rig& r) { r.state().layers.c_his[2] = 1e-30f; },
      [](Rig& r) {
        insert_polyline(r.model(), r.state(), {{0.15, 0.15}, {0.18, 0.15}}, 0.0);
      },
      [](Rig& r) { r.body().body.id = 4; },
      [](Rig& r) { r.body().body.motion.position.y() = next(0.0); },
      [](Rig& r) { r.body().body.motion.orientation.w() = next(1.0); },
      [](Rig& r) { r.body().body.motion.velocity.z() = next(0.0); },
      [](Rig& r) { r.body().body.motion.angular_momentum.x() = next(0.0); },
      [](Rig& r) { r.now().shells[0].state.reset(); },
  };
  std::set<std::string> seen{same, state_hash("b", sheet_and_ball().now())};
  for (const auto& change : changes) {
    Rig rig = sheet_and_ball();
    change(rig);
    seen.insert(state_hash("a", rig.now()));
  }
  EXPECT_EQ(seen.size(), changes.size() + 2);  // each is another one
}

TEST(StateHash, DoesNotKnowForcesTimesOrCaches) {
  Rig rig = sheet_and_ball();
  const std::string before = state_hash("", rig.now());
  rig.state().motion.force.assign(rig.state().motion.force.size(), 1.0);
  rig.state().caches = {};
  rig.times()[Stage::kIo] = 3.0;
  rig.body().linear_impulse = Vec3(1, 2, 3);
  EXPECT_EQ(state_hash("", rig.now()), before);
}
