#include <gtest/gtest.h>

#include <limits>

#include "tests/rigid/trial.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

std::vector<RigidBody> late_shards(BodyId first) {
  std::vector<RigidBody> shards = thrown_shards(4, first);
  for (RigidBody& b : shards) {
    b.id += first;
    b.motion.position = 0.2 * b.motion.position + Vec3(0.03, 0.03, 0.0);
  }
  return shards;
}

TEST(BulletSave, AnotherEngineContinuesToTheBit) {
  for (int before : {0, 1, 40, 400}) {  // nothing inserted yet, newborn, in flight, at rest
    const Scene scene = pile();
    Trial first(scene);
    first.windows(before);
    const std::string caches = first.engine.save();
    Trial second(moved(scene, first));
    second.engine.restore(caches, first.motions());
    for (int i = 0; i < 300; ++i) {
      first.caller.window(), second.caller.window();
      ASSERT_EQ(bits(first.engine), bits(second.engine)) << before << " windows before, after " << i;
      if (i % 60 == 59)
        for (const RigidBody& b : late_shards(static_cast<BodyId>(100 + i))) first.caller.add(b), second.caller.add(b);
    }
  }
}

TEST(BulletSave, BodiesAddedSinceTheLastWindowAreNewbornOnBothSides) {
  Scene scene = pile();
  Trial first(scene);
  first.windows(100);
  // overlaps the box by 1 mm: the overlap stays, without a throw
  RigidBody born = box(200, Vec3(0.02, 0.015, 0.01), 0.06);
  born.motion = first.caller.body(1).motion;
  born.motion.position.z() += 0.019;
  first.caller.add(born);
  scene.bodies.push_back(born);
  const std::string caches = first.engine.save();
  Trial second(moved(scene, first));
  second.engine.restore(caches, first.motions());
  for (int i = 0; i < 300; ++i) {
    first.caller.window(), second.caller.window();
    ASSERT_EQ(bits(first.engine), bits(second.engine)) << i;
  }
  const double apart = first.caller.body(200).motion.position.z() - first.caller.body(1).motion.position.z();
  EXPECT_NEAR(apart, 0.019, 0.2e-3);
}

TEST(BulletSave, TheSameEngineTakesWindowsAgain) {
  Trial run(pile());
  run.windows(60);
  for (int i = 0; i < 50; ++i) {
    const std::string caches = run.engine.save(), start = bits(run.engine);
    const std::vector<PredictedState> motions = run.motions();
    const auto advance = [&] {  // with the same predicted states each time: the caller's copies are not restored
      std::vector<PredictedState> predicted = motions;
      for (int k = 0; k < 3; ++k)
        for (PredictedState& m : predicted) {
          m.motion.velocity.z() -= kGravity * Trial::kWindow;
          m.motion.position += Trial::kWindow * m.motion.velocity;
          if (m.id == predicted.back().id) run.engine.advance(Trial::kWindow, predicted, {});
        }
      return bits(run.engine);
    };
    const std::string once = advance();
    ASSERT_NE(once, start);
    run.engine.restore(caches, motions);
    ASSERT_EQ(bits(run.engine), start);
    ASSERT_EQ(advance(), once) << i;
    run.engine.restore(caches, motions);
    ASSERT_EQ(run.engine.save(), caches) << i;
    run.caller.window();
  }
}

TEST(BulletSave, RefusesCachesThatItCannotHaveWritten) {
  const Scene scene = pile();
  Trial run(scene);
  run.windows(20);
  const std::string caches = run.engine.save();
  const std::vector<PredictedState> there = run.motions();
  const std::string before = bits(run.engine);
  const auto refused = [&](const std::string& bytes) {
    return kind_of([&] { run.engine.restore(bytes, there); }) == "bad_state";
  };
  EXPECT_TRUE(refused(""));
  EXPECT_TRUE(refused("sunder bullet caches"));
  EXPECT_TRUE(refused(caches + "x"));
  for (std::size_t length = 0; length < caches.size(); ++length) EXPECT_TRUE(refused(caches.substr(0, length)));
  for (std::size_t i = 0; i < caches.size(); ++i)
    for (int bit = 0; bit < 8; bit += 3) {
      std::string bytes = caches;
      bytes[i] = static_cast<char>(bytes[i] ^ (1 << bit));
      EXPECT_TRUE(refused(bytes)) << i;
    }
  BulletEngine other;  // without these bodies
  EXPECT_EQ(kind_of([&] { other.restore(caches, {}); }), "bad_state");
  std::vector<PredictedState> fewer = there, wrong = there;
  fewer.pop_back();
  wrong[0].motion.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kind_of([&] { run.engine.restore(caches, fewer); }), "bad_predicted_state");
  EXPECT_EQ(kind_of([&] { run.engine.restore(caches, wrong); }), "bad_predicted_state");
  EXPECT_EQ(bits(run.engine), before);  // nothing moved
  run.engine.restore(caches, there);
}

}  // namespace
}  // namespace sunder::rigid
