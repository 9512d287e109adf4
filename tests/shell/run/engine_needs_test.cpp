// What a scene needs of an engine: said before the run, with the capability and who needs it.
#include <algorithm>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/run/coupler.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;
namespace capability = sunder::link::capability;

namespace {

link::EngineInfo engine_without(const std::string& what) {
  using namespace capability;
  link::EngineInfo info{"toy", "1", {}};
  for (const char* c : {kSpheres, kBoxes, kHalfSpaces, kConvexHulls, kCompound, kContact, kFriction, kRestitution,
                        kJoints, kReleaseJoints, kExportRows, kSaveRestore, kDoublePrecision, kDeterministic})
    if (c != what) info.capabilities.emplace_back(c);
  return info;
}

RigidBody body(const std::string& name, const Shape& shape) {
  RigidBody b;
  b.id = 1, b.name = name, b.mass = 1.0, b.shape = shape;
  return b;
}

}  // namespace

TEST(EngineNeeds, NameTheWordThatMayBeMisspelt) {
  RunSetup setup;
  setup.bodies = {body("b", SphereShape{1.0})};
  link::EngineInfo peer = engine_without(capability::kSpheres);
  peer.capabilities.emplace_back("spheers");
  try {
    check_engine(setup, peer);
    FAIL() << "taken";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "the engine 'toy' cannot do 'spheres' (it declares 'spheers', which is no capability: did you mean "
                 "'spheres'?), which body 'b' needs; take another engine, or change the scene");
  }
  peer.capabilities.back() = capability::kSpheres;  // the remedy
  EXPECT_NO_THROW(check_engine(setup, peer));
}

TEST(EngineNeeds, AreRefusedWithTheCapabilityAndWhoNeedsIt) {
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Joint hinge;
  hinge.name = "pin";
  JointBreak weak;
  weak.angle = 0.3;
  const std::vector<std::tuple<const char*, std::string, std::function<void(RunSetup&)>>> cases = {
      {capability::kSpheres, "'b'", [](RunSetup& s) { s.bodies = {body("b", SphereShape{1.0})}; }},
      {capability::kBoxes, "'b'", [](RunSetup& s) { s.bodies = {body("b", BoxShape{Vec3::Ones()})}; }},
      {capability::kHalfSpaces, "'b'", [](RunSetup& s) { s.bodies = {body("b", HalfSpaceShape{})}; }},
      {capability::kConvexHulls, "'b'", [&](RunSetup& s) { s.bodies = {body("b", ConvexShape{{corners}})}; }},
      {capability::kCompound, "'b'",
       [&](RunSetup& s) {
         s.bodies = {body("b", ConvexShape{{corners, corners}})};
       }},
      {capability::kJoints, "'pin'", [&](RunSetup& s) { s.joints = {hinge}, s.breaks = {JointBreak{}}; }},
      {capability::kReleaseJoints, "'pin'", [&](RunSetup& s) { s.joints = {hinge}, s.breaks = {weak}; }},
      {capability::kCompound, "shards need; take another engine, or leave 'strength' and 'cuts' out",
       [](RunSetup& s) { s.shells.push_back({brittle_sheet(4)}), s.shells[0].fracture.mode = FractureMode::kTips; }},
      {capability::kExportRows, "EXPORTED", [](RunSetup& s) { s.coupling.scheme = CouplingRules::Scheme::kExported; }},
      {capability::kSaveRestore, "ITERATED", [](RunSetup& s) { s.coupling.scheme = CouplingRules::Scheme::kIterated; }},
  };
  for (const auto& [what, who, ask] : cases) {
    RunSetup setup;
    ask(setup);
    check_engine(setup, engine_without(""));
    try {
      check_engine(setup, engine_without(what));
      ADD_FAILURE() << what;
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      for (const std::string& word : {std::string(what), who, std::string("'toy'")})
        EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  }
}

TEST(EngineNotes, AreGivenOnlyWhereTheSceneFeelsTheLack) {
  RunSetup setup;
  setup.bodies = {body("a", SphereShape{1.0})};
  setup.checkpoint_interval = 0.0;
  EXPECT_TRUE(engine_notes(setup, engine_without(capability::kContact)).empty());  // it meets nobody
  setup.bodies.push_back(body("b", SphereShape{1.0}));
  EXPECT_EQ(engine_notes(setup, engine_without(capability::kContact)).size(), 1u);
  EXPECT_TRUE(engine_notes(setup, engine_without(capability::kRestitution)).empty());
  setup.laws = {{0, 0, 0.0, 0.5}};
  EXPECT_EQ(engine_notes(setup, engine_without(capability::kRestitution)).size(), 1u);
  EXPECT_TRUE(engine_notes(setup, engine_without(capability::kFriction)).empty());  // the law has none
  setup.checkpoint_interval = 1.0;
  EXPECT_TRUE(engine_notes(setup, engine_without(capability::kSaveRestore)).empty());  // numbers are the same without
}
