// Supports that are released: refusals, and the built model.
#include <cstring>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

std::string kept_until(const char* time, const char* edge = "U_MIN") {
  return fmt::format("supports {{ edges: {} kind: CLAMPED until_s: {} }}", edge, time);
}

}  // namespace

TEST(SupportsUntilATime, AreBuilt) {
  const auto setup = built(strong(kept_until("0.5") + kept_until("0.25", "V_MAX") + kept_until("0.5", "U_MAX")));
  const auto& releases = setup.shells[0].model.releases;
  ASSERT_EQ(releases.size(), 2u);
  EXPECT_EQ(releases[0].from, 0.25);
  EXPECT_EQ(releases[1].from, 0.5);
  EXPECT_TRUE(releases[1].constraints.anchors.empty());
  EXPECT_EQ(setup.last_change, 0.5);  // cracking does not end before
}

TEST(SupportsUntilATime, AreRefusedWhereTheTimeIsWrong) {
  expect_refusal(strong(kept_until("0")), "shells[0].supports[0].until_s", {"must be positive"});
  expect_refusal(strong(kept_until("nan")), "shells[0].supports[0].until_s", {"must be positive and finite"});
  expect_refusal(strong(kept_until("1")), "shells[0].supports[0].until_s", {"the run ends at 1 s", "leave it out"});
  expect_refusal(strong(kept_until("0.5"), "fracture { latest_freeze_s: 0.4 }"), "shells[0].supports[0].until_s",
                 {"frozen at 0.4 s", "a later fracture.latest_freeze_s"});
  EXPECT_EQ(refusal(strong(kept_until("0.5"), "fracture { latest_freeze_s: 0.6 }")).kind, "accepted");
  // windows last 1e-4 s, and a support is released at the one that begins nearest
  expect_refusal(strong(kept_until("4e-5")), "shells[0].supports[0].until_s",
                 {"it would never hold", "give 5e-05 s or more"});
  expect_refusal(strong(kept_until("0.99996")), "shells[0].supports[0].until_s",
                 {"it would never be released", "leave it out"});
  EXPECT_EQ(refusal(strong(kept_until("5e-5"))).kind, "accepted");
  EXPECT_EQ(refusal(strong(kept_until("0.9999"))).kind, "accepted");
}

TEST(SupportsUntilATime, AreRefusedWhereNothingMoves) {
  std::string text = strong(kept_until("0.5") + " equilibrium {}");
  text.erase(text.find("bodies {"));
  for (const char* moving : {"end_time_s: 1\n", "window_s: 1e-4\n"}) text.erase(text.find(moving), strlen(moving));
  expect_refusal(text, "shells[0].supports[0].until_s", {"in this scene nothing moves", "leave it out"});
}

TEST(SupportsUntilATime, MayBeReleasedBesideATrimmedSeamAndOnIt) {
  const auto trimmed = [](const std::string& support) {
    std::string text = small_scene::kScene;
    const std::string plate = "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }\n";
    const std::size_t at = text.find(plate) + plate.size();
    const std::string rest =
        R"(  trims { points {} points { u: 0.3 } points { u: 0.35 v: 0.5 } points { v: 0.5 } points {} }
)" + support +
        R"(
}
shells {
  name: "rest" material: "glass" thickness_m: 0.004
  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 14 elements_y: 15 }
  trims { points { u: 0.3 } points { u: 0.5 } points { u: 0.5 v: 0.5 } points { u: 0.35 v: 0.5 } points { u: 0.3 } }
)";
    return text.insert(at, rest) + "seams {}\n";
  };
  const std::string far = trimmed("supports { edges: U_MIN kind: CLAMPED until_s: 0.5 }");
  EXPECT_EQ(refusal(far).kind, "accepted") << refusal(far).what();
  const std::string on =  // ties follow the supports
      trimmed("supports { regions { low { u: 0.25 } high { u: 0.4 v: 0.5 } } kind: CLAMPED until_s: 0.5 }");
  EXPECT_EQ(refusal(on).kind, "accepted") << refusal(on).what();
}
