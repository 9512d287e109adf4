// Engines have fixed lengths. In units of the scene's size a small or large scene gives the same result, to the bit.
#include <cmath>

#include <gtest/gtest.h>

#include "coupler/link/units.h"
#include "tests/rigid/trial.h"

using namespace sunder;
using namespace sunder::rigid;
using namespace sunder::rigid::testing;

namespace {

/// A scene with lengths and times multiplied by `by` and masses by its cube. Speeds stay.
Scene scaled(Scene scene, double by) {
  for (RigidBody& b : scene.bodies) {
    b.mass *= std::pow(by, 3), b.principal_inertia *= std::pow(by, 5);
    b.motion.position *= by, b.motion.angular_momentum *= std::pow(by, 4);
    if (auto* s = std::get_if<SphereShape>(&b.shape)) s->radius *= by;
    if (auto* s = std::get_if<BoxShape>(&b.shape)) s->half_size *= by;
    if (auto* s = std::get_if<ConvexShape>(&b.shape))
      for (auto& part : s->parts)
        for (Vec3& x : part) x *= by;
  }
  for (Joint& j : scene.joints) j.first_frame.position *= by, j.second_frame.position *= by;
  return scene;
}

/// Motions after windows of the scaled scene, scaled back, and rows of the next window.
std::string ends(const std::string& name, double by, double unit) {
  const auto inner = make_engine(name);
  link::InUnits engine(*inner);
  engine.set_unit(unit);
  const bool meets = engine.info().can(link::capability::kContact);
  const Scene scene = scaled(pile(), by);
  engine.set_contact_laws(scene.laws);
  Caller caller(engine, Trial::kWindow * by, kGravity / by);
  for (const RigidBody& b : scene.bodies) caller.add(b);
  if (meets)
    for (const Joint& j : scene.joints) engine.add_joint(j);
  for (int i = 0; i < 150; ++i) caller.window();
  std::string out;
  std::vector<PredictedState> motions;
  for (EngineState s : engine.states()) {
    motions.push_back({s.id, s.motion});
    s.motion.position /= by, s.motion.angular_momentum /= std::pow(by, 4);
    out += bits(s.motion);
    EXPECT_EQ(s.mass, caller.body(s.id).mass);
  }
  if (!meets) return out;
  if (engine.info().can(link::capability::kSaveRestore)) {  // another engine continues from there
    const auto fresh = make_engine(name);
    link::InUnits other(*fresh);
    other.set_unit(unit);
    other.set_contact_laws(scene.laws);
    for (RigidBody b : scene.bodies) other.add(b.is_static ? b : caller.body(b.id));
    for (const Joint& j : scene.joints) other.add_joint(j);
    other.restore(engine.save(), motions);
    caller.window();
    other.advance(Trial::kWindow * by, caller.predicted(), {});
    EXPECT_EQ(bits(other), bits(engine));
    motions.clear();
    for (const EngineState& s : engine.states()) motions.push_back({s.id, s.motion});
  }
  const auto rows = engine.rows(Trial::kWindow * by, motions, {10, 14});
  EXPECT_FALSE(rows.empty());
  for (ContactRow row : rows) {
    BodyMotion as_motion;
    as_motion.position = row.first_point / by, as_motion.velocity = row.second_point / by;
    as_motion.angular_momentum = row.normal * row.friction + Vec3::Constant(row.allowance / by);
    out += bits(as_motion);
  }
  return out;
}

}  // namespace

TEST(Units, ArePowersOfTwoForVeryThinAndThickShells) {
  for (const double length : {0.0, 1.26e-4, 0.004, 0.1, 0.127}) EXPECT_EQ(link::length_unit(length), 1.0) << length;
  EXPECT_EQ(link::length_unit(std::ldexp(0.005, -18)), std::ldexp(1.0, -18));
  EXPECT_EQ(link::length_unit(1e-6), std::ldexp(1.0, -12));
  EXPECT_EQ(link::length_unit(16.0), std::ldexp(1.0, 12));
}

TEST(Units, ScalesAreTheSameToTheBit) {
  for (const std::string& name : engine_names()) {
    const std::string one = ends(name, 1.0, 1.0);
    for (const int exponent : {-18, 12}) {
      const double by = std::ldexp(1.0, exponent);
      EXPECT_EQ(ends(name, by, by), one) << name << exponent;
    }
  }
  EXPECT_NE(ends("bullet", 16.0, 1.0), ends("bullet", 1.0, 1.0));  // without units: its margins are fixed lengths
}

TEST(Units, AreNamedWhereABodyIsRefused) {
  const auto inner = make_engine("bullet");
  link::InUnits engine(*inner);
  engine.set_unit(std::ldexp(1.0, -18));
  RigidBody bad = sphere(7, 1e-8, 1e-15);
  bad.mass = -1e-15;
  try {
    engine.add(bad);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "bad_body");
    EXPECT_EQ(e.field, "mass");
    EXPECT_NE(std::string(e.what()).find("in units of 3.8147e-06 m"), std::string::npos) << e.what();
  }
}
