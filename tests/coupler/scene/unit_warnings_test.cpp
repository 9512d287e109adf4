// Values that look as if they were given in another unit.
#include "coupler/scene/unit_warnings.h"

#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace sunder::scene;
using small_scene::kScene;
using small_scene::own_file;
using small_scene::replaced;

namespace {

std::vector<std::string> warnings_of(const std::string& text) {
  const std::string path = own_file("unit_warnings_test.textproto");
  std::ofstream(path) << text;
  const LoadedScene scene = load(path, {});
  std::remove(path.c_str());
  return unit_warnings(scene.message);
}

void expect_one(const std::string& text, const std::string& says) { EXPECT_EQ(warnings_of(text), std::vector{says}); }

}  // namespace

TEST(UnitWarnings, ASoundSceneHasNone) { EXPECT_TRUE(warnings_of(kScene).empty()); }

TEST(UnitWarnings, NameTheFieldTheValueAndWhatItWouldBe) {
  expect_one(replaced("70e9", "70"), "materials[glass].youngs_modulus is 70 Pa, softer than a gel; 70 GPa are 7e+10");
  expect_one(replaced("70e9", "70e3 strength: 6e7 fracture_energy: 8"),
             "materials[glass].strength is 6e+07 Pa, and youngs_modulus 70000 Pa; 70000 MPa are 7e+10");
  expect_one(replaced("70e9", "70e9 strength: 60 fracture_energy: 8"),
             "materials[glass].strength is 60 Pa, 9e-10 of youngs_modulus; 60 MPa are 6e+07");
  expect_one(replaced("density: 2500", "density: 2.5"),
             "materials[glass].density is 2.5 kg/m^3, about that of air; 2.5 g/cm^3 are 2500");
  expect_one(replaced("density: 2500", "density: 2.5e6"),
             "materials[glass].density is 2.5e+06 kg/m^3, more than any metal has");
  expect_one(replaced("thickness_m: 0.004", "thickness_m: 4"),
             "shells[pane].thickness_m is 4 m, and the plate is 0.5 m wide; 4 mm are 0.004");
  expect_one(replaced("size_x_m: 0.5 size_y_m: 0.5", "size_x_m: 500 size_y_m: 500"),
             "shells[pane].plate is 500 m wide; 500 mm are 0.5");
  expect_one(
      replaced("sphere {", "twist { linear { z: -12e3 } } sphere {"),
      "bodies[ball].twist.linear is 12000 m/s; solids flow and melt in impacts that fast, which no model here does");
}

// What people do break is below the limits: rubber, cloth of the paper, foam, steel shot.
TEST(UnitWarnings, SoftAndStrongMaterialsAreNone) {
  for (const char* material :
       {"density: 1100 youngs_modulus: 1e6 poisson_ratio: 0.45 strength: 2e7 fracture_energy: 1e4",
        "density: 20 youngs_modulus: 3.2e3 poisson_ratio: 0.3 strength: 5e2 fracture_energy: 1",
        "density: 7800 youngs_modulus: 2.1e11 poisson_ratio: 0.3 strength: 2e9 fracture_energy: 1e5"})
    EXPECT_TRUE(warnings_of(replaced("density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22", material)).empty())
        << material;
}

TEST(UnitWarnings, BelongToARefusalThatUnitsDecide) {
  const auto refused = [](const std::string& field) {
    Error e(Exit::kBadInput, "bad_scene", "");
    e.field = field;
    return may_be_by_units(e);
  };
  for (const char* field : {"bodies[0].twist", "bodies[0].pose", "shells[pane].thickness_m", "materials[0].density",
                            "window_s", "time_step_s", "coupling.adaptive_window.shortest_window_s", "fracture.mode"})
    EXPECT_TRUE(refused(field)) << field;
  for (const char* field : {"", "shells[0].supports", "shells[0].supports[1].edges", "output.probes[0].at", "seams",
                            "end_time_s", "output.frame_interval_s", "materials[0].name"})
    EXPECT_FALSE(refused(field)) << field;
  for (const char* kind : {"unstable", "compression", "equilibrium"})
    EXPECT_TRUE(may_be_by_units(Error(Exit::kPhysics, kind, ""))) << kind;
  EXPECT_FALSE(may_be_by_units(Error(Exit::kPhysics, "ledger", "")));
  EXPECT_FALSE(may_be_by_units(Error(Exit::kPeerLost, "unstable", "")));
}
