#pragma once
// An engine with its caller, for tests that compare runs to the bit.
#include <functional>
#include <string>
#include <vector>

#include "coupler/core/error.h"
#include "rigid/engine/bullet_engine.h"
#include "tests/rigid/shards.h"

namespace sunder::rigid::testing {

/// All that an engine gets before its first window.
struct Scene {
  std::vector<RigidBody> bodies;
  std::vector<ContactLaw> laws{{0, 0, 0.4, 0.2}};
  std::vector<Joint> joints{};
};

/// A pane cut into overlapping neighbours above the floor, with a box and a ball on it, a shard of two parts, a hinge
/// and a ball joint.
inline Scene pile() {
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
  RigidBody arm = box(4, Vec3(0.03, 0.005, 0.005), 0.02);
  arm.motion.position = Vec3(0.05 + 0.02 + 0.03, 0.03, 0.02);
  for (const RigidBody& b : {brick, ball, angle, arm}) scene.bodies.push_back(b);
  scene.joints.push_back({1, "hinge", Joint::Kind::kHinge, 4, 1, {Vec3(-0.03, 0, 0), {}}, {Vec3(0.02, 0, 0), {}}});
  const Vec3 hook = ball.motion.position + Vec3(0, 0, 0.05);
  scene.joints.push_back({2, "string", Joint::Kind::kBall, 2, 0, {Vec3(0, 0, 0.05), {}}, {hook, {}}});
  for (Joint& j : scene.joints) j.first_frame.orientation = j.second_frame.orientation = Quat::Identity();
  return scene;
}

struct Trial {
  static constexpr double kWindow = 0.25e-3;  // [s]

  BulletEngine engine;
  Caller caller;

  explicit Trial(const Scene& scene, double window_s = kWindow, double gravity = kGravity)
      : caller(engine, window_s, gravity) {
    engine.set_contact_laws(scene.laws);
    for (const RigidBody& b : scene.bodies) caller.add(b);
    for (const Joint& j : scene.joints) engine.add_joint(j);
  }
  std::vector<PredictedState> motions() const {
    std::vector<PredictedState> out;
    for (const EngineState& s : engine.states()) out.push_back({s.id, s.motion});
    return out;
  }
  void windows(int count) {
    for (int i = 0; i < count; ++i) caller.window();
  }
};

/// The scene with its bodies where the trial has them, in the same order.
inline Scene moved(Scene scene, const Trial& trial) {
  for (RigidBody& b : scene.bodies)
    if (!b.is_static) b.motion = trial.caller.body(b.id).motion;
  return scene;
}

inline std::string bits(const BodyMotion& m) {
  std::string out;
  const auto put = [&](const double* numbers, std::size_t count) {
    out.append(reinterpret_cast<const char*>(numbers), count * sizeof(double));
  };
  put(m.position.data(), 3), put(m.orientation.coeffs().data(), 4);
  put(m.velocity.data(), 3), put(m.angular_momentum.data(), 3);
  return out;
}

inline std::string bits(const Engine& engine) {
  std::string out;
  for (const EngineState& s : engine.states()) out += bits(s.motion);
  return out;
}

/// Kind of the Error that the call throws.
inline std::string kind_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.status == Exit::kBadInput ? error.kind : "another status";
  }
  return "accepted";
}

}  // namespace sunder::rigid::testing
