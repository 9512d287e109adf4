// An engine that gives states which no contact leads to: the run ends, and names the engine and the body.
#include <gtest/gtest.h>

#include "tests/coupler/altered_engine.h"
#include "tests/validation/coupled.h"

using namespace sunder;

namespace {

const std::string kFalling = R"(name: "wrong" end_time_s: 2e-3 window_s: 2e-4
materials { name: "sheet" density: 1000 youngs_modulus: 1e8 poisson_ratio: 0.3 }
materials { name: "steel" density: 7800 }
shells { name: "plate" material: "sheet" thickness_m: 0.002 plate { size_x_m: 0.2 size_y_m: 0.2 elements_x: 8 elements_y: 8 }
  supports { edges: ALL kind: CLAMPED } }
bodies { name: "ball" material: "steel" sphere { radius_m: 0.02 } pose { position { z: 0.3 } } twist { linear { x: 1 } } }
)";

std::string ending(std::function<void(std::vector<link::State>&)> by) {
  AlteredEngine engine(std::move(by));
  return validation::run_text(kFalling, engine, [](double, double, const auto&) {});
}

}  // namespace

TEST(WrongStatesRun, AnEngineThatTellsTheTruthIsBelieved) {
  EXPECT_EQ(ending([](auto&) {}), "");
}

TEST(WrongStatesRun, APlaceThatNoSpeedLeadsToIsRefused) {
  const std::string said = ending([](auto& states) { states[0].motion.position.x() += 1.0; });
  EXPECT_NE(said.find("window 0, body 1 'ball': states[id 1].position: the body has moved by 1 m in the window"),
            std::string::npos)
      << said;
}

TEST(WrongStatesRun, EnergyFromTheEngineIsNotTheShells) {
  const std::string said = ending([](auto& states) { states[0].motion.angular_momentum.z() += 1e3; });
  EXPECT_NE(said.find(": window 0: the rigid engine has added"), std::string::npos) << said;
  EXPECT_NE(said.find("'ball' has most of the energy now"), std::string::npos) << said;
  EXPECT_EQ(said.find("time_step_safety"), std::string::npos) << said;
}
