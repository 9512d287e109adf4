// Thickness that varies by a scene: law, map and paint, and what is refused.
#include <cmath>
#include <fstream>

#include "coupler/core/error.h"
#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class VaryingScene : public MeshScene {
 protected:
  std::string plate_scene(const std::string& in_shell, const std::string& patch = "") const {
    return R"(name: "plate"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
materials { name: "film" density: 1100 youngs_modulus: 50e6 poisson_ratio: 0.45 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.01
)" + (patch.empty() ? std::string("  plate { size_x_m: 0.4 size_y_m: 0.2 elements_x: 16 elements_y: 8 }") : patch) +
           "\n  " + in_shell + "\n}\n";
  }
  RunSetup plate(const std::string& in_shell, const std::string& patch = "") const {
    write("plate.textproto", plate_scene(in_shell, patch));
    return build(scene::load(folder.path + "/plate.textproto", {}));
  }
  void refused(const std::string& in_shell, const std::string& field, const std::vector<std::string>& says,
               const std::string& patch = "") const {
    try {
      plate(in_shell, patch);
      ADD_FAILURE() << in_shell;
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.field, "shells[0]." + field) << e.what();
      EXPECT_GT(e.line, 0) << e.what();
      for (const std::string& part : says) expect_part(e.what(), part);
    }
  }
  static double mass(const RunSetup& r) {
    double sum = 0.0;
    for (const ShellSetup& s : r.shells)
      for (const double part : s.model.mass) sum += part;
    return sum;
  }
};

constexpr double kWhole = 2500 * 0.01 * 0.4 * 0.2;
const char* kLaw = "thickness_law { along: X points { at_m: -0.2 factor: 1 } points { at_m: 0.2 factor: 0.5 } }";

TEST_F(VaryingScene, ALawAlongAnAxisOrAParameterGivesTheMass) {
  EXPECT_NEAR(mass(plate(kLaw)) / kWhole, 0.75, 1e-12);
  EXPECT_NEAR(mass(plate("thickness_law { along: V points { factor: 2 } points { at_m: 0.2 factor: 1 } }")) / kWhole,
              1.5, 1e-12);
  const ShellModel m = plate(kLaw).shells[0].model;
  EXPECT_NEAR(m.thickness_at(Vec2(0.1, 0.1)), 0.00875, 1e-12);
  EXPECT_NEAR(m.thickness_at(Vec2(0.5, 0.1)), 0.005, 1e-12);  // beyond the border: that of the border
  // constant beyond its ends
  EXPECT_NEAR(mass(plate("thickness_law { along: U points { at_m: 0.1 factor: 1 } points { at_m: 0.2 factor: 0.5 } }")),
              kWhole * (0.1 + 0.075 + 0.1) / 0.4, 1e-4 * kWhole);  // kinks within elements
}

TEST_F(VaryingScene, AMapAndALawMultiply) {
  write("map.pgm", std::string("P2 2 2 255\n0 255 0 255\n"));
  const std::string map = "thickness_map { path: 'map.pgm' low_factor: 0.5 } ";
  const std::string square = "  plate { size_x_m: 0.2 size_y_m: 0.2 elements_x: 8 elements_y: 8 }";
  // linear between the centres of two pixels, constant beyond: 0.5 to 1
  EXPECT_NEAR(mass(plate(map, square)) / (2500 * 0.01 * 0.04), 0.75, 1e-3);
  EXPECT_NEAR(
      mass(plate(map + "thickness_law { along: Y points { at_m: -0.1 factor: 2 } points { at_m: 0.1 factor: 2 } }",
                 square)) /
          (2500 * 0.01 * 0.04),
      1.5, 2e-3);
  refused("thickness_map { path: 'none.pgm' low_factor: 0.5 }", "thickness_map.path", {"cannot be read"});
  refused(map, "thickness_map.path", {"0.4 m x 0.2 m", "would do"});
  refused("thickness_map { path: 'map.pgm' }", "thickness_map.low_factor", {"is missing"}, square);
}

TEST_F(VaryingScene, AWrongLawIsRefused) {
  const auto law = [](const std::string& text) { return "thickness_law { " + text + " }"; };
  refused(law("points { factor: 1 } points { at_m: 1 factor: 1 }"), "thickness_law.along", {"is missing", "U, V, X"});
  refused(law("along: X points { factor: 1 }"), "thickness_law.points", {"has 1", "two or more"});
  refused(law("along: X points { factor: 1 } points { factor: 2 }"), "thickness_law.points[1].at_m", {"rise"});
  refused(law("along: X points { factor: 1 } points { at_m: 1 }"), "thickness_law.points[1].factor", {"is missing"});
  refused(law("along: X points { factor: 1 } points { at_m: 1 factor: 0.001 }"), "thickness_law.points[1].factor",
          {"0.01 to 100"});
  refused(law("along: Z points { at_m: 1 factor: 1 } points { at_m: 2 factor: 2 }"), "thickness_law.points",
          {"from 1 to 2 m", "from 0 to 0 m along Z", "move them"});
  write("map.pgm", std::string("P2 4 2 255\n0 0 0 0 0 0 0 0\n"));
  refused("thickness_map { path: 'map.pgm' low_factor: 0.02 } " +
              law("along: X points { factor: 0.02 } points { at_m: 1 factor: 0.02 }"),
          "thickness_m", {"0.0004", "0.01 to 100"});
}

// Each sector of a ring is within 90 degrees, and a law in space is that of all.
TEST_F(VaryingScene, ALawGoesOverTheSectorsOfARing) {
  const auto ring = [](const std::string& more) {
    return "  annulus { inner_m: 0.1 outer_m: 0.2 element_m: 0.02 " + more + " }";
  };
  const auto law = [](const std::string& along, double from, double to) {
    return fmt::format(
        "thickness_law {{ along: {} points {{ at_m: {} factor: 1 }} points {{ at_m: {} factor: 0.5 }} }}", along, from,
        to);
  };
  const double even = mass(plate("", ring("")));
  EXPECT_NEAR(mass(plate(law("X", -0.2, 0.2), ring(""))) / even, 0.75, 1e-6);
  const RunSetup r = plate(law("X", 0.05, 0.2), ring(""));  // two sectors lie beyond it
  EXPECT_EQ(r.shells.size(), 4u);
  EXPECT_NEAR(r.shells[1].model.largest_thickness(), 0.01, 1e-15);
  EXPECT_NEAR(r.shells[1].model.least_thickness(), 0.01, 1e-15);
  EXPECT_LT(r.shells[0].model.least_thickness(), 0.006);
  refused(law("X", 0.25, 0.5), "thickness_law.points", {"from -0.2 to 0.2 m along X", "move them"}, ring(""));
  EXPECT_LT(mass(plate(law("V", 0, 0.1), ring(""))), 0.9 * even);
  refused(law("U", 0, 0.1), "thickness_law.along", {"each sector", "take X, Y or Z"}, ring(""));
  refused(law("U", 0, 0.1), "thickness_law.along", {"each sector", "at most 90"}, ring("angle_deg: 91"));
  EXPECT_LT(mass(plate(law("U", 0, 0.1), ring("angle_deg: 90"))), 0.9 * 0.25 * even);
}

// A bent patch of which a face is given: the image has the shape of the middle.
TEST_F(VaryingScene, AMapFitsTheMiddle) {
  const std::string patch = "  cylinder { radius_m: 0.1 length_m: 0.1 angle_deg: 90 elements_u: 12 elements_v: 8 }";
  std::string map = "P2 150 100 255\n";  // the face's arc is 0.157 m, the middle's 0.149 m or 0.165 m
  for (int k = 0; k < 150 * 100; ++k) map += "0\n";
  write("map.pgm", map);
  const std::string in_shell = "thickness_map { path: 'map.pgm' low_factor: 1 } reference: ";
  const Patch found = plate(in_shell + "OUTSIDE", patch).shells[0].model.patch;
  EXPECT_NEAR(found.knots_u.end() - found.knots_u.begin(), 0.095 * 0.5 * std::numbers::pi, 1e-4);
  refused(in_shell + "MIDDLE", "thickness_map.path", {"would do"}, patch);
  refused(in_shell + "INSIDE", "thickness_map.path", {"0.1649 m", "would do"}, patch);
}

TEST_F(VaryingScene, IsRefusedWithAnInterlayerAndWithFibres) {
  const std::string law = kLaw;
  refused(law + " interlayer { material: 'film' thickness_m: 0.001 }", "thickness_law", {"an interlayer", "leave one"});
  refused(law + " fibres { compression_modulus: 1e6 shear_modulus: 1e6 }", "thickness_law", {"fibres", "leave one"});
}

TEST_F(VaryingScene, ColoursOfAMeshAreItsThickness) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 0 0 0\n2 0 0 255 0 0\n2 1 0 255 0 0\n0 1 0 0 0 0\n4 0 1 2 3\n";
  write("a.ply", text);
  const RunSetup r = setup("path: 'a.ply' element_m: 0.1 thickness_paint { channel: RED low_factor: 0.5 }");
  EXPECT_NEAR(mass(r) / (2500 * 0.01 * 2.0), 0.75, 1e-9);
  expect_part(refusal("path: 'a.ply' element_m: 0.1 thickness_paint { low_factor: 0.5 }"), "channel");
  expect_part(refusal("path: 'a.ply' element_m: 0.1 thickness_paint { channel: RED low_factor: 1e-9 }"), "0.01 to 100");
  write("b.off", std::string("OFF\n4 1 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n"));
  expect_part(refusal("path: 'b.off' element_m: 0.1 thickness_paint { channel: RED low_factor: 0.5 }"),
              "have no colours");
}

// Points of a mesh are moved before they have parameters, so a law along U would have one factor for all.
TEST_F(VaryingScene, OfAMeshWhoseFaceIsGivenIsInSpace) {
  write("a.obj", lattice(20, 10, false, [](double u, double v) { return Vec3(u, 0.5 * v, 0.0); }));
  write(
      "map.pgm", std::string("P2 20 10 255\n") + [] {
        std::string out;
        for (int k = 0; k < 200; ++k) out += "0 ";
        return out;
      }());
  const std::string mesh = "path: 'a.obj' element_m: 0.05";
  const auto law = [](const std::string& along) {
    return "thickness_law { along: " + along + " points { factor: 1 } points { at_m: 1 factor: 0.5 } } ";
  };
  for (const std::string along : {"U", "V"}) {
    EXPECT_EQ(setup(mesh, law(along)).shells.size(), 1u);
    for (const std::string face : {"OUTSIDE", "INSIDE"}) {
      const std::string said = refusal(mesh, law(along) + "reference: " + face);
      expect_part(said, "shells[0].thickness_law.along: is " + along);
      expect_part(said, "take X, Y or Z");
    }
  }
  const Patch p = setup(mesh, law("X") + "reference: OUTSIDE").shells[0].model.patch;
  for (const Vec3& x : p.control_points)
    EXPECT_NEAR(std::abs(x.z()), 0.005 * (1.0 - 0.5 * x.x()), 1e-4) << x.transpose();
  expect_part(refusal(mesh, "thickness_map { path: 'map.pgm' low_factor: 1 } reference: INSIDE"), "thickness_paint");
}

// A closed tube becomes several charts: a law in space is that of all, one along U is of none.
TEST_F(VaryingScene, ALawInSpaceGoesOverCharts) {
  Triangles tube = lattice(48, 16, true, [](double u, double v) {
    const double angle = 2.0 * std::numbers::pi * u;
    return Vec3(std::cos(angle), std::sin(angle), v);
  });
  write("tube.obj", tube);
  const std::string mesh = "path: 'tube.obj' element_m: 0.15";
  const RunSetup even = setup(mesh);
  ASSERT_GT(even.shells.size(), 1u);
  const RunSetup r = setup(mesh, "thickness_law { along: Z points { factor: 1 } points { at_m: 1 factor: 0.5 } }");
  EXPECT_NEAR(mass(r) / mass(even), 0.75, 2e-3);
  expect_part(refusal(mesh, "thickness_law { along: U points { factor: 1 } points { at_m: 1 factor: 0.5 } }"),
              "take X, Y or Z");
  write("map.pgm", std::string("P2 2 2 255\n0 0 0 0\n"));
  expect_part(refusal(mesh, "thickness_map { path: 'map.pgm' low_factor: 1 }"), "thickness_paint");
}

}  // namespace
