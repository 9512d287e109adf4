#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "coupler/core/error.h"
#include "rigid/engine/bullet_engine.h"
#include "tests/rigid/shards.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

constexpr double kWindow = 0.25e-3;  // [s]

/// Everything an engine is given before its first window.
struct Scene {
  std::vector<RigidBody> bodies;
  std::vector<ContactLaw> laws{{0, 0, 0.4, 0.2}};
};

/// A pane cut into overlapping neighbours above the floor, a box and a ball upon it, and a shard of two parts.
Scene pile() {
  Scene scene;
  scene.bodies.push_back(half_space(500));
  const double a = 0.04, o = 0.1e-3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      scene.bodies.push_back(plate(static_cast<BodyId>(10 + 3 * j + i),
                                   {rectangle(i * a - o, j * a - o, (i + 1) * a + o, (j + 1) * a + o)}, 0.004));
  for (RigidBody& b : scene.bodies)
    if (!b.is_static) b.motion.position.z() = 0.004;
  RigidBody brick = box(1, Vec3(0.02, 0.015, 0.01), 0.06), ball = sphere(2, 0.015, 0.04);
  brick.motion.position = Vec3(0.05, 0.03, 0.02);
  ball.motion.position = Vec3(0.08, 0.09, 0.03);
  ball.motion.velocity = Vec3(0.1, -0.2, -1.0);
  RigidBody angle = plate(3, {rectangle(0, 0, 0.06, 0.02), rectangle(0, 0.02, 0.02, 0.06)}, 0.004);
  angle.motion.position += Vec3(0.05, 0.05, 0.05);
  angle.motion.orientation = rotation_from_vector(Vec3(0.3, 0.2, 0.1)) * angle.motion.orientation;
  for (const RigidBody& b : {brick, ball, angle}) scene.bodies.push_back(b);
  return scene;
}

/// One engine and its caller.
struct Trial {
  BulletEngine engine;
  Caller caller{engine, kWindow, kGravity};

  explicit Trial(const Scene& scene) {
    engine.set_contact_laws(scene.laws);
    for (const RigidBody& b : scene.bodies) caller.add(b);
  }
  std::vector<Handback> motions() const {
    std::vector<Handback> out;
    for (const EngineState& s : engine.states()) out.push_back({s.id, s.motion});
    return out;
  }
  void windows(int count) {
    for (int i = 0; i < count; ++i) caller.window();
  }
};

/// The scene with its bodies where the run has them, in the same order.
Scene moved(Scene scene, const Trial& run) {
  for (RigidBody& b : scene.bodies)
    if (!b.is_static) b.motion = run.caller.body(b.id).motion;
  return scene;
}

std::string bits(const Engine& engine) {
  std::string out;
  const auto put = [&](const double* numbers, std::size_t count) {
    out.append(reinterpret_cast<const char*>(numbers), count * sizeof(double));
  };
  for (const EngineState& s : engine.states()) {
    put(s.motion.position.data(), 3), put(s.motion.orientation.coeffs().data(), 4);
    put(s.motion.velocity.data(), 3), put(s.motion.angular_momentum.data(), 3);
  }
  return out;
}

std::vector<RigidBody> late_shards(BodyId first) {
  std::vector<RigidBody> shards = thrown_shards(4, first);
  for (RigidBody& b : shards) {
    b.id += first;
    b.motion.position = 0.2 * b.motion.position + Vec3(0.03, 0.03, 0.0);
  }
  return shards;
}

TEST(BulletSave, AFreshEngineGoesOnToTheBit) {
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
  // sunk 1 mm into the box: kept, not thrown out
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
    const std::vector<Handback> motions = run.motions();
    const auto advance = [&] {  // with the same handbacks each time: the caller's own copies do not go back
      std::vector<Handback> handbacks = motions;
      for (int k = 0; k < 3; ++k)
        for (Handback& m : handbacks) {
          m.motion.velocity.z() -= kGravity * kWindow;
          m.motion.position += kWindow * m.motion.velocity;
          if (m.id == handbacks.back().id) run.engine.advance(kWindow, handbacks, {});
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

std::string kind_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.status, Exit::kBadInput);
    return error.kind;
  }
  return "accepted";
}

TEST(BulletSave, RefusesCachesThatItCannotHaveWritten) {
  const Scene scene = pile();
  Trial run(scene);
  run.windows(20);
  const std::string caches = run.engine.save();
  const std::vector<Handback> there = run.motions();
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
  std::vector<Handback> fewer = there, wrong = there;
  fewer.pop_back();
  wrong[0].motion.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(kind_of([&] { run.engine.restore(caches, fewer); }), "bad_handback");
  EXPECT_EQ(kind_of([&] { run.engine.restore(caches, wrong); }), "bad_handback");
  EXPECT_EQ(bits(run.engine), before);  // nothing moved
  run.engine.restore(caches, there);
}

}  // namespace
}  // namespace sunder::rigid
