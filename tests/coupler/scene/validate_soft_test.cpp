// Soft bodies of a scene: refusals with field and remedy.
#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

const std::string kBall = R"(soft_bodies {
  name: "soft"
  material: "rubber"
  sphere { radius_m: 0.05 }
  pose { position { x: 0.3 z: 0.1 } }
  spacing_m: 0.01
}
)";
const std::string kRubber = "materials { name: \"rubber\" density: 1000 youngs_modulus: 1e6 poisson_ratio: 0.45 }\n";

std::string soft_scene(const std::string& from = "", const std::string& to = "", const std::string& more = "") {
  std::string text = kScene + kRubber + kBall + more;
  if (from.empty()) return text;
  const std::size_t at = text.rfind(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST(SoftScene, IsAcceptedAndReportsItsCost) {
  EXPECT_EQ(refusal(soft_scene()).kind, "accepted") << refusal(soft_scene()).what();
  EXPECT_EQ(refusal(soft_scene("sphere { radius_m: 0.05 }", "box { size_m { x: 0.1 y: 0.05 z: 0.04 } }")).kind,
            "accepted");
  const std::string said = report(soft_scene());
  for (const char* part : {"soft body      soft", "particles", "grid spacing   0.02 m", "stable step"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST(SoftScene, RefusesFieldsThatAreMissingOrOutOfRange) {
  const std::string f = "soft_bodies[0]";
  expect_refusal(soft_scene("name: \"soft\"", "name: \"pane\""), f + ".name", {"used twice"});
  expect_refusal(soft_scene("material: \"rubber\"", "material: \"ruber\""), f + ".material", {"is no material"});
  expect_refusal(soft_scene("  sphere { radius_m: 0.05 }\n", ""), f, {"give sphere, box or mesh"});
  expect_refusal(soft_scene("radius_m: 0.05", "radius_m: -1"), f + ".sphere.radius_m", {"must be positive"});
  expect_refusal(soft_scene("  spacing_m: 0.01\n", ""), f + ".spacing_m", {"is missing"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: nan"), f + ".spacing_m", {"must be positive"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: 0.06"), f + ".spacing_m", {"at most half of that"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: 1e-4"), f + ".spacing_m", {"particles; at most"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: 0.01 grid_spacing_m: 0.005"), f + ".grid_spacing_m",
                 {"0.5 times spacing_m"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: 0.01 twist { linear { z: inf } }"), f + ".twist.linear",
                 {"must be finite"});
  expect_refusal(soft_scene("spacing_m: 0.01", "spacing_m: 0.01 twist { linear { z: -1e7 } }"), f + ".twist",
                 {"times its waves; at most 10"});
}

TEST(SoftScene, RefusesMaterialsThatSoftBodiesCannotHave) {
  const std::string f = "soft_bodies[0].material";
  expect_refusal(soft_scene("poisson_ratio: 0.45 }", "}"), f, {"a soft body needs both"});
  expect_refusal(soft_scene("poisson_ratio: 0.45", "poisson_ratio: -0.2"), f, {"is 0 or more"});
  expect_refusal(soft_scene("poisson_ratio: 0.45", "poisson_ratio: 0.45 strength: 1e6 fracture_energy: 10"), f,
                 {"has a strength", "name a material without"});
  expect_refusal(soft_scene("poisson_ratio: 0.45", "poisson_ratio: 0.45 mass_damping_per_s: 1"), f,
                 {"has a mass_damping_per_s"});
}

TEST(SoftScene, RefusesBodiesThatOverlapAtTheStart) {
  const std::string f = "soft_bodies[0].pose";
  expect_refusal(soft_scene("x: 0.3 z: 0.1", "x: 0.06 z: 0.1"), f, {"inside body 'ball'"});
  expect_refusal(soft_scene("x: 0.3 z: 0.1", "x: 0.2 z: 0.04"), f, {"inside shell 'pane'"});
  std::string second = kBall;
  second.replace(second.find("\"soft\""), 6, "\"other\"");
  second.replace(second.find("x: 0.3"), 6, "x: 0.38");
  expect_refusal(soft_scene("", "", second), "soft_bodies[1].pose", {"inside soft body 'soft'"});
  std::string coarse = soft_scene("spacing_m: 0.01", "spacing_m: 0.02");
  coarse.replace(coarse.find("radius_m: 0.02"), 14, "radius_m: 0.016");
  expect_refusal(coarse, "soft_bodies[0].spacing_m", {"could pass between the particles"});
  std::string thin = soft_scene("spacing_m: 0.01", "spacing_m: 0.02");  // a rod, which may hit with its end
  thin.replace(thin.find("sphere { radius_m: 0.02 }"), 25, "box { size_m { x: 0.06 y: 0.034 z: 0.034 } }");
  expect_refusal(thin, "soft_bodies[0].spacing_m", {"could pass between the particles"});
  expect_refusal(soft_scene("x: 0.3 z: 0.1", "x: 3e6 z: 0.1"), f, {"3e+06 m off", "grid spacings, 2e+06 m"});
}

TEST(SoftScene, RefusesFieldsThatExcludeSoftBodies) {
  expect_refusal(soft_scene("", "", "contacts { first: \"soft\" second: \"pane\" restitution: 0.5 }\n"),
                 "contacts[0].restitution", {"bounce by their elasticity"});
  expect_refusal(soft_scene("", "", "contacts { first: \"soft\" second: \"soft\" friction: 0.5 }\n"),
                 "contacts[0].second", {"touches itself by its own grid"});
  expect_refusal(soft_scene("", "", "contacts { first: \"soft\" second: \"ball\" hertz {} }\n"), "contacts[0].hertz",
                 {"a body that is a sphere"});
  expect_refusal(soft_scene("", "", "fracture { latest_freeze_s: 0.1 }\n"), "fracture.latest_freeze_s",
                 {"leave it out"});
  for (const char* scheme : {"ITERATED", "STAGGERED", "LAGGED"})
    expect_refusal(soft_scene("", "", fmt::format("coupling {{ scheme: {} }}\n", scheme)), "coupling.scheme",
                   {scheme, "take PROXY or EXPORTED"});
  expect_refusal(
      soft_scene("  sphere { radius_m: 0.02 }\n", "  sphere { radius_m: 0.02 } launch { speed: 1 target: \"soft\" }\n"),
      "bodies[0].launch.target", {"is a soft body"});
}
