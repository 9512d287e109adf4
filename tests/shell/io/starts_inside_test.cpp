// Bodies that start inside a shell are refused, and the remedy takes them out.
#include <cmath>
#include <regex>
#include <string>

#include "tests/coupler/small_scene.h"

using namespace small_scene;

namespace {

struct Way {
  double length = 0.0, x = 0.0, y = 0.0, z = 0.0;
};

// What the message tells to move, by which vector [m].
Way told_way(const std::string& said, const std::string& what) {
  std::smatch found;
  const std::regex words("move " + what + " (\\S+) m along \\((\\S+), (\\S+), (\\S+)\\)$");
  if (!std::regex_search(said, found, words)) return {};
  const double l = std::stod(found[1]);
  return {l, l * std::stod(found[2]), l * std::stod(found[3]), l * std::stod(found[4])};
}

}  // namespace

// The ball of 20 mm overlaps a Gauss point 7 mm beside its centre, 15 mm below it; faces are 2 mm from the middle.
TEST(StartsInside, ABallIsMovedOutByTheWayThatIsTold) {
  const std::string said = refusal(replaced("z: 0.1", "x: 0.01 z: 0.015")).what();
  EXPECT_NE(said.find("'ball' starts 0.00"), std::string::npos) << said;
  EXPECT_NE(said.find("inside shell 'pane', whose faces are 0.002 m from its middle; "), std::string::npos) << said;
  const Way way = told_way(said, "it");
  ASSERT_GT(way.length, 0.0) << said;
  EXPECT_GT(way.z, 0.0);
  const std::string there = fmt::format("x: {:.9g} y: {:.9g} z: {:.9g}", 0.01 + way.x, way.y, 0.015 + way.z);
  EXPECT_EQ(refusal(replaced("z: 0.1", there)).kind, "accepted") << said;
}

// A pane that stands on the floor: its lowest Gauss points are nearer than half its thickness. No floor is moved.
TEST(StartsInside, AShellIsMovedOffTheFloor) {
  const auto standing = [](double z) {
    std::string text = replaced(
        "elements_y: 16 }",
        fmt::format(
            "elements_y: 16 pose {{ position {{ z: {:.9g} }} rotation {{ axis {{ x: 1 }} angle_deg: 90 }} }} }}", z));
    text.replace(text.find("z: 0.1"), 6, "y: 0.3 z: 0.1");
    return text + "bodies { name: \"floor\" half_space {} }\n";
  };
  // Element of 31.25 mm: points at 0.2113 of it, 6.6 mm above the edge; the pane is sunk by 5 mm.
  const std::string said = refusal(standing(0.245)).what();
  EXPECT_NE(said.find("'floor' starts 0.0003"), std::string::npos) << said;
  const Way way = told_way(said, "the shell");
  ASSERT_GT(way.length, 0.0) << said;
  EXPECT_NEAR(way.z, way.length, 1e-12);
  EXPECT_EQ(refusal(standing(0.245 + way.z)).kind, "accepted") << said;
  EXPECT_NE(refusal(standing(0.245 + 0.95 * way.z)).kind, "accepted");
}

namespace {

const std::string kRubber = "materials { name: \"rubber\" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.45 }\n";

std::string soft_ball(const std::string& name, double x, double y, double z) {
  return fmt::format(
      "soft_bodies {{ name: \"{}\" material: \"rubber\" sphere {{ radius_m: 0.05 }} spacing_m: 0.01 "
      "pose {{ position {{ x: {:.9g} y: {:.9g} z: {:.9g} }} }} }}\n",
      name, x, y, z);
}

// The scene with `others` and a soft ball at (x, y, z) is refused there, and accepted where the message sends it.
void expect_a_way_out(const std::string& others, const std::string& inside, double x, double y, double z) {
  const auto placed = [&](const Way& w, double share) {
    return refusal(kScene + kRubber + others + soft_ball("soft", x + share * w.x, y + share * w.y, z + share * w.z));
  };
  const std::string said = placed({}, 0.0).what();
  EXPECT_NE(said.find("m inside " + inside + ";"), std::string::npos) << said;
  const Way way = told_way(said, "it");
  ASSERT_GT(way.length, 0.0) << said;
  EXPECT_EQ(placed(way, 1.0).kind, "accepted") << said;
  EXPECT_NE(placed(way, 0.95).kind, "accepted") << said;
}

}  // namespace

// The ball of 20 mm is at z = 0.1 m, so it is deep in the first of these and holds no particle of the third's surface.
TEST(StartsInside, ASoftBodyIsMovedOutOfABody) {
  expect_a_way_out("", "body 'ball'", 0.06, 0.0, 0.1);
  expect_a_way_out("", "body 'ball'", 0.03, 0.02, 0.12);
  expect_a_way_out("", "body 'ball'", 0.0, 0.001, 0.1);
  const std::string floor = "bodies { name: \"floor\" half_space {} pose { position { z: -1 } } }\n";
  expect_a_way_out(floor, "body 'floor'", 0.4, 0.0, -0.96);
}

TEST(StartsInside, ASoftBodyIsMovedOutOfAnother) {
  expect_a_way_out(soft_ball("other", 0.3, 0.0, 0.1), "soft body 'other'", 0.38, 0.0, 0.1);
  expect_a_way_out(soft_ball("other", 0.3, 0.0, 0.1), "soft body 'other'", 0.31, 0.02, 0.12);
}
