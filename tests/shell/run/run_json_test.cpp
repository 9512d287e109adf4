// run.json by its keys, of a small run whose numbers are known.
#include <cmath>

#include <gtest/gtest.h>

#include "coupler/core/version.h"
#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

TEST(RunJson, TellsTheSceneTheEngineAndTheCounts) {
  FreeRun run;
  run.execute();
  const auto j = run.summary();
  EXPECT_EQ(j["schema"], 2);
  EXPECT_EQ(j["version"], version());
  EXPECT_EQ(j["scene"], "free_run");
  EXPECT_EQ(j["scene_hash"], run.options.scene_hash);
  EXPECT_EQ(j["engine"], (nlohmann::json{{"name", "free"}, {"version", "3.1"}}));
  EXPECT_EQ(j["counts"]["patches"], 1);
  EXPECT_EQ(j["counts"]["control_points"], 8 * 8);  // six elements of degree 2
  EXPECT_EQ(j["counts"]["gauss_points"].get<int>() % 36, 0);
  EXPECT_EQ(j["counts"]["handed_off"], 0);
  EXPECT_EQ(j["shells"], nlohmann::json::array({"pane"}));
  EXPECT_EQ(j["shell_materials"], nlohmann::json::array({"glass"}));
  EXPECT_EQ(j["shell_thickness_m"][0], 0.004);
  EXPECT_FALSE(j.contains("error"));
  EXPECT_FALSE(j.contains("joints"));
  EXPECT_FALSE(j.contains("equilibrium"));
}

TEST(RunJson, TellsTimeEnergyAndSurface) {
  FreeRun run;
  run.execute();
  const auto j = run.summary();
  EXPECT_DOUBLE_EQ(j["time"]["simulated_s"].get<double>(), 1e-3);
  EXPECT_EQ(j["time"]["windows"], 10);
  EXPECT_TRUE(j["time"]["frozen_at_s"].is_null());
  EXPECT_LT(std::abs(j["energy"]["residual_relative"].get<double>()), 1e-2);  // of first order in the step
  EXPECT_GT(j["energy"]["elastic"].get<double>(), 0.0);                       // the plate bends at its clamp
  for (const char* key :
       {"dissipated_fracture", "dissipated_plastic", "contact", "handoff_lost", "crack_injected", "frozen"})
    EXPECT_EQ(j["energy"][key], 0.0) << key;
  EXPECT_NEAR(j["surface"]["rest_m2"].get<double>(), 0.04, 1e-15);
  EXPECT_EQ(j["surface"]["torn_m2"], 0.0);
  EXPECT_EQ(j["cracks"]["length_m"], 0.0);
  EXPECT_TRUE(j["cracks"]["taken_relative"].is_null());
  EXPECT_EQ(j["state_hash"].get<std::string>().size(), 64u);
}

TEST(RunJson, ListsTheModelsThatAreActiveWithTheirShares) {
  FreeRun run;
  run.execute();
  std::vector<std::string> names;
  const auto summary = run.summary();  // outlives the loop
  for (const auto& model : summary["models"]) {
    names.push_back(model["name"]);
    EXPECT_GE(model["share"].get<double>(), 0.0);
    EXPECT_LE(model["share"].get<double>(), 1.0);
    EXPECT_FALSE(model["why"].get<std::string>().empty());
  }
  EXPECT_EQ(names, (std::vector<std::string>{"kirchhoff_love_plane_stress", "shell_contact", "rigid_engine"}));
}

TEST(RunJson, WarnsOfAWordThatIsNoCapability) {
  FreeRun run;
  run.asked.declares = {"conact"};
  run.execute();
  std::string all;
  const auto summary = run.summary();  // outlives the loop
  for (const std::string told : summary["warnings"]) all += told + "\n";
  EXPECT_NE(all.find("the engine 'free' declares 'conact', which is no capability and counts for nothing: did you mean "
                     "'contact'?\n"),
            std::string::npos)
      << all;
}

TEST(RunJson, ATextThatIsNoUtf8IsReplaced) {
  FreeRun run;
  run.options.scene_hash = "\xff";
  run.options.until = 1e-4;
  run.execute();
  EXPECT_EQ(run.summary()["scene_hash"], "\xEF\xBF\xBD");
}
