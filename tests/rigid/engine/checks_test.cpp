// What every engine refuses: bodies, joints, laws, predicted states and saved states that cannot be.
#include "rigid/engine/checks.h"

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/rigid/every_engine.h"

namespace sunder::rigid {
namespace {

using namespace testing;  // NOLINT: the helpers of this folder

class EveryEngineRefuses : public EveryEngine {};
INSTANTIATE_TEST_SUITE_P(Of, EveryEngineRefuses, ::testing::Values(kBullet, kOde), name_of);

TEST_P(EveryEngineRefuses, BodiesThatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(RigidBody&)>>> faults = {
      {"id 0", [](RigidBody& b) { b.id = 0; }},
      {"id twice", [](RigidBody& b) { b.id = 1; }},
      {"mass 0", [](RigidBody& b) { b.mass = 0.0; }},
      {"mass nan", [&](RigidBody& b) { b.mass = nan; }},
      {"inertia", [](RigidBody& b) { b.principal_inertia.y() = -1.0; }},
      {"position", [&](RigidBody& b) { b.motion.position.z() = nan; }},
      {"momentum", [](RigidBody& b) { b.motion.angular_momentum.x() = 1.0 / 0.0; }},
      {"orientation", [](RigidBody& b) { b.motion.orientation.w() = 2.0; }},
      {"no parts", [](RigidBody& b) { b.shape = ConvexShape{}; }},
      {"3 corners", [](RigidBody& b) { std::get<ConvexShape>(b.shape).parts[0].resize(3); }},
      {"flat",
       [](RigidBody& b) {
         for (Vec3& p : std::get<ConvexShape>(b.shape).parts[0]) p.z() = 0.001;
       }},
      {"a line",
       [](RigidBody& b) {
         for (Vec3& p : std::get<ConvexShape>(b.shape).parts[0]) p = p.x() * Vec3(1, 2, 3);
       }},
      {"a point",
       [](RigidBody& b) {
         for (Vec3& p : std::get<ConvexShape>(b.shape).parts[0]) p = Vec3(1, 2, 3);
       }},
      {"corner nan", [&](RigidBody& b) { std::get<ConvexShape>(b.shape).parts[0][2].x() = nan; }},
      {"radius", [](RigidBody& b) { b.shape = SphereShape{-1.0}; }},
      {"half size", [](RigidBody& b) { b.shape = BoxShape{Vec3(1, 0, 1)}; }},
      {"moving half space", [](RigidBody& b) { b.shape = HalfSpaceShape{}; }},
  };
  const auto engine = make();
  const RigidBody good = plate(2, {rectangle(0, 0, 0.02, 0.01)}, 0.003);
  engine->add(sphere(1, 0.1, 1.0));
  for (const auto& [name, spoil] : faults) {
    RigidBody body = good;
    spoil(body);
    EXPECT_EQ(kind_of([&] { engine->add(body); }), "bad_body") << name;
  }
  EXPECT_EQ(engine->states().size(), 1u);
  engine->add(good);
}

TEST_P(EveryEngineRefuses, NoPartThatIsThinAndTilted) {
  // 2e-5 of its length: flat on the grid on which an engine may compute hulls
  RigidBody thin = plate(2, {rectangle(0, 0, 0.2, 0.1)}, 4e-6);
  for (Vec3& p : std::get<ConvexShape>(thin.shape).parts[0]) p = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * p;
  EXPECT_NO_THROW(make()->add(thin));
}

TEST_P(EveryEngineRefuses, PredictedStatesLawsAndCachesThatDoNotMatch) {
  const auto engine = make();
  engine->add(sphere(1, 0.01, 1.0));
  engine->add(sphere(3, 0.01, 1.0));
  engine->add(half_space(2));
  BodyMotion there, bad;
  there.position = Vec3(1, 0, 0);
  bad.orientation.w() = 1.1;
  const std::vector<std::vector<PredictedState>> faults = {{},
                                                           {{1, there}},
                                                           {{3, there}},
                                                           {{1, there}, {2, there}, {3, there}},
                                                           {{3, there}, {1, there}},
                                                           {{1, there}, {3, there}, {3, there}},
                                                           {{1, there}, {4, there}},
                                                           {{1, there}, {3, bad}}};
  const std::string caches = engine->save();
  for (std::size_t i = 0; i < faults.size(); ++i) {
    EXPECT_EQ(kind_of([&] { engine->advance(1e-3, faults[i], {}); }), "bad_predicted_state") << i;
    EXPECT_EQ(kind_of([&] { engine->restore(caches, faults[i]); }), "bad_predicted_state") << i;
    EXPECT_EQ(kind_of([&] { engine->rows(1e-3, faults[i], {1}); }), "bad_predicted_state") << i;
  }
  const std::vector<PredictedState> good = {{1, there}, {3, there}};
  EXPECT_EQ(kind_of([&] { engine->advance(0.0, good, {}); }), "bad_predicted_state");
  EXPECT_EQ(engine->states()[0].motion.position, Vec3::Zero());  // nothing moved
  engine->advance(1e-3, {{1, {}}, {3, there}}, {});
  const std::string full = engine->save(), before = bits(*engine);
  EXPECT_NE(full, caches);
  for (const std::string& wrong : {std::string(), std::string("what"), full.substr(0, full.size() - 1), full + "x"})
    EXPECT_EQ(kind_of([&] { engine->restore(wrong, good); }), "bad_state");
  const auto smaller = make();
  smaller->add(sphere(1, 0.01, 1.0));
  EXPECT_EQ(kind_of([&] { smaller->restore(full, {{1, there}}); }), "bad_state");  // of bodies not held there
  EXPECT_EQ(bits(*engine), before);                                                // nothing moved
  EXPECT_EQ(kind_of([&] { engine->set_contact_laws({{0, 0, -0.1, 0.0}}); }), "bad_contact_law");
  EXPECT_EQ(kind_of([&] { engine->set_contact_laws({{0, 0, 0.1, 1.1}}); }), "bad_contact_law");
}

TEST_P(EveryEngineRefuses, JointsThatCannotBe) {
  const auto engine = make();
  engine->add(sphere(1, 0.01, 1.0)), engine->add(sphere(2, 0.01, 1.0));
  const Joint good{
      1, "joint", Joint::Kind::kBall, 1, 2, {Vec3::Zero(), Quat::Identity()}, {Vec3::Zero(), Quat::Identity()}};
  const std::vector<std::pair<std::string, std::function<void(Joint&)>>> faults = {
      {"id 0", [](Joint& j) { j.id = 0; }},
      {"first is the world", [](Joint& j) { j.first = 0; }},
      {"no such body", [](Joint& j) { j.second = 7; }},
      {"no such first", [](Joint& j) { j.first = 7; }},
      {"one body", [](Joint& j) { j.second = 1; }},
      {"kind", [](Joint& j) { j.kind = static_cast<Joint::Kind>(9); }},
      {"position", [](Joint& j) { j.first_frame.position.x() = std::numeric_limits<double>::quiet_NaN(); }},
      {"orientation", [](Joint& j) { j.second_frame.orientation.w() = 1.5; }},
  };
  for (const auto& [name, spoil] : faults) {
    Joint bad = good;
    spoil(bad);
    EXPECT_EQ(kind_of([&] { engine->add_joint(bad); }), "bad_joint") << name;
  }
  engine->add_joint(good);
  EXPECT_EQ(kind_of([&] { engine->add_joint(good); }), "bad_joint") << "id twice";
}

}  // namespace
}  // namespace sunder::rigid
