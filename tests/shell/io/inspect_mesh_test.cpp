// What is said of a mesh file before there is a scene.
#include "shell/io/inspect_mesh.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using MeshReport = nlohmann::json;

const char* kSheetOfTwo = "OFF\n4 1 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n";
// Two squares of 1 m that are 0.1 mm apart.
const char* kSquaresApart =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1.0001 0 0\nv 2 0 0\nv 2 1 0\nv 1.0001 1 0\n"
    "g left\nusemtl red\nf 1 2 3 4\ng right\nf 5 6 7 8\n";

class InspectMesh : public MeshScene {
 protected:
  MeshReport told(const std::string& name, const MeshQuestion& asked = {}) const {
    return MeshReport::parse(inspect_mesh_report(folder.path + "/" + name, asked));
  }
  void refused(const std::string& name, const std::string& content, const std::string& says) const {
    const std::string path = folder.path + "/" + name;
    if (!content.empty()) write(name, content);
    try {
      inspect_mesh_report(path, {0.1});
      ADD_FAILURE() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.kind, "bad_input");
      EXPECT_EQ(e.file, path);
      EXPECT_EQ(e.what(), path + ": " + says);
    }
  }
};

TEST(IsMeshFile, GoesByTheEndOfTheName) {
  for (const char* name : {"a.obj", "a.off", "a.ply", "a.stl", "a.glb", "a.gltf", "x/Y.STL", "a.step.obj", "../b.Ply"})
    EXPECT_TRUE(is_mesh_file(name)) << name;
  for (const char* name : {"x/y.step", "", "obj", "a.obj.gz", "a.objx", "a.obj/b", "a.obj "})
    EXPECT_FALSE(is_mesh_file(name)) << name;
}

TEST_F(InspectMesh, CountsSizesAndBordersAreExact) {
  write("a.off", std::string(kSheetOfTwo));
  const MeshReport told = this->told("a.off");
  EXPECT_EQ(told["file"], folder.path + "/a.off");
  EXPECT_EQ(told["low_m"], MeshReport({0.0, 0.0, 0.0}));
  EXPECT_EQ(told["size_m"], MeshReport({2.0, 1.0, 0.0}));
  EXPECT_DOUBLE_EQ(told["element_m"].get<double>(), std::sqrt(5.0) / 40.0);  // a fortieth of the diagonal
  EXPECT_DOUBLE_EQ(told["thickness_m"].get<double>(), std::sqrt(5.0) / 200.0);
  EXPECT_EQ(told["unit_m"], 1.0);
  EXPECT_EQ(told["warning"], nullptr);
  EXPECT_EQ(told["faces"], 1);
  EXPECT_EQ(told["points"], 4);
  EXPECT_EQ(told["triangles"], 2);
  EXPECT_EQ(told["components"], 1);
  EXPECT_EQ(told["edges"], MeshReport({{"all", 5}, {"on_borders", 4}, {"borders", 1}}));
  EXPECT_EQ(told["area_m2"], 2.0);
  EXPECT_EQ(told["coloured"], false);
  EXPECT_EQ(told["groups"], MeshReport::array());
  EXPECT_EQ(told["refused"], nullptr);
  double around = 0.0;
  ASSERT_EQ(told["borders_m"].size(), 4u);
  for (const MeshReport& edge : told["borders_m"])
    around += std::hypot(edge[1][0].get<double>() - edge[0][0].get<double>(),
                         edge[1][1].get<double>() - edge[0][1].get<double>());
  EXPECT_EQ(around, 6.0);
}

// One chart, flat, whose shorter side is u or v. Parameters are lengths to the accuracy of the fit.
TEST_F(InspectMesh, AChartHasElementsOfTheLengthThatIsAsked) {
  write("a.off", std::string(kSheetOfTwo));
  const MeshReport told = this->told("a.off", {0.1});
  EXPECT_EQ(told["element_m"], 0.1);
  ASSERT_EQ(told["charts"].size(), 1u);
  const MeshReport& chart = told["charts"][0];
  EXPECT_EQ(chart["shell"], "part");
  EXPECT_EQ(chart["triangles"], 2);
  EXPECT_EQ(chart["elements"][0].get<int>() * chart["elements"][1].get<int>(), 200);
  EXPECT_EQ(chart["area_m2"], 2.0);
  EXPECT_NEAR(chart["area_of_shell_m2"].get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(chart["width_m"][0].get<double>() * chart["width_m"][1].get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(chart["stretch"].get<double>(), 1.0, 1e-9);
  EXPECT_LT(chart["error_m"].get<double>(), 1e-9);
  EXPECT_EQ(chart["trimmed"], false);
  EXPECT_EQ(chart["holes"], 0);
  EXPECT_EQ(chart["warning"], nullptr);
  EXPECT_EQ(told["seams"], MeshReport({{"joined", 0}, {"smooth", 0}}));
}

TEST_F(InspectMesh, LengthsAreInTheUnitThatIsAsked) {
  write("a.off", std::string(kSheetOfTwo));
  const MeshReport told = this->told("a.off", {0.0, 0.001, 0.0, true});
  EXPECT_EQ(told["unit_m"], 0.001);
  EXPECT_EQ(told["size_m"], MeshReport({0.002, 0.001, 0.0}));
  EXPECT_DOUBLE_EQ(told["element_m"].get<double>(), std::sqrt(5e-6) / 40.0);
  EXPECT_DOUBLE_EQ(told["area_m2"].get<double>(), 2e-6);
  // A wave takes a thousandth of the time through an element of a thousandth. The step is that of a fixed number of
  // Lanczos steps, which the fit's round-off changes in the ninth digit.
  const double metres = this->told("a.off")["charts"][0]["stable_step_s"];
  EXPECT_NEAR(told["charts"][0]["stable_step_s"].get<double>() / metres, 1e-3, 1e-3 * 1e-7);
}

TEST_F(InspectMesh, AUnitThatMayBeForgottenHasAWarning) {
  write("a.off", "OFF\n4 1 0\n0 0 0\n12 0 0\n12 6 0\n0 6 0\n4 0 1 2 3\n");
  EXPECT_EQ(told("a.off", {0.5})["warning"],
            "'a.off' is taken in metres, 12 m long, as no --unit is given; give 0.001 for millimetres, or 1");
  EXPECT_EQ(told("a.off", {0.5, 1.0, 0.0, true})["warning"], nullptr);
}

TEST_F(InspectMesh, WeldingJoinsWhatIsApart) {
  write("a.obj", std::string(kSquaresApart));
  const MeshReport apart = told("a.obj", {0.1});
  EXPECT_EQ(apart["components"], 2);
  EXPECT_EQ(apart["points"], 8);
  EXPECT_EQ(apart["points_merged"], 0);
  EXPECT_EQ(apart["edges"], MeshReport({{"all", 10}, {"on_borders", 8}, {"borders", 2}}));
  ASSERT_EQ(apart["charts"].size(), 2u);
  EXPECT_EQ(apart["charts"][0]["shell"], "part.1");
  EXPECT_EQ(apart["charts"][1]["shell"], "part.2");
  const MeshReport welded = told("a.obj", {0.1, 1.0, 1e-3, true});
  EXPECT_EQ(welded["weld_m"], 1e-3);
  EXPECT_EQ(welded["components"], 1);
  EXPECT_EQ(welded["points"], 6);
  EXPECT_EQ(welded["points_merged"], 2);
  EXPECT_EQ(welded["edges"], MeshReport({{"all", 9}, {"on_borders", 6}, {"borders", 1}}));
  ASSERT_EQ(welded["charts"].size(), 1u);
  EXPECT_EQ(welded["charts"][0]["shell"], "part");
  EXPECT_EQ(welded["area_m2"], 2.0);
  for (const MeshReport& told : {apart, welded}) {
    EXPECT_EQ(told["groups"],
              MeshReport({{{"name", "left"}, {"triangles", 2}}, {{"name", "right"}, {"triangles", 2}}}));
    EXPECT_EQ(told["usemtl"], MeshReport::array({{{"name", "red"}, {"triangles", 4}}}));
  }
}

TEST_F(InspectMesh, TellsChartsAndTheirSeams) {
  write("a.obj", ball(0.5, 8));
  const MeshReport told = this->told("a.obj", {0.08});
  EXPECT_EQ(told["components"], 1);
  EXPECT_EQ(told["edges"], MeshReport({{"all", 1920}, {"on_borders", 0}, {"borders", 0}}));  // 30 * 8^2
  EXPECT_EQ(told["triangles"], 1280);                                                        // 20 * 8^2
  ASSERT_GE(told["charts"].size(), 2u);
  EXPECT_EQ(told["charts"][1]["shell"], "part.2");
  int triangles = 0;
  for (const MeshReport& chart : told["charts"]) triangles += chart["triangles"].get<int>();
  EXPECT_EQ(triangles, 1280);
  EXPECT_EQ(told["seams"]["smooth"], 1);
  EXPECT_EQ(told["refused"], nullptr);
}

// A mesh that no scene could have is reported all the same, with the reason.
TEST_F(InspectMesh, WhatASceneWouldBeRefusedForIsPartOfTheReport) {
  write("a.obj", ball(0.5, 8));
  const MeshReport shorter = told("a.obj", {1e-5});
  EXPECT_EQ(shorter["refused"].get<std::string>().rfind("element_m is 1e-05 m", 0), 0u) << shorter["refused"];
  EXPECT_EQ(shorter["charts"], MeshReport::array());
  EXPECT_EQ(shorter["seams"], nullptr);
  EXPECT_EQ(shorter["triangles"], 1280);
  write("a.off", std::string(kSheetOfTwo));
  const std::string longer = told("a.off", {5.0})["refused"];
  EXPECT_EQ(longer.rfind("element_m is 5 m, and 1 of 1 parts", 0), 0u) << longer;
  EXPECT_NE(longer.find("give one below 1 m"), std::string::npos) << longer;
  EXPECT_EQ(told("a.off", {0.99})["refused"], nullptr);  // the remedy helps
}

// A user has no scene, so none is named.
TEST_F(InspectMesh, AFileThatIsNoMeshIsNamedItself) {
  refused("none.off", "", "cannot be read; is the name right?");
  refused("a.txt", "x",
          "ends in '.txt'; files that end in .off, .obj, .ply, .stl, .glb or .gltf are read: export one of them");
  refused("a.off", "OFF\n4 1 0\n0 0 0\n", "ends after 1 of its 4 points");
  refused("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n", "line 5: 'nan 1 0' is no point of three numbers");
  refused("c.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "line 6: the face names point 7, and there are 3");
  refused("a.obj", "v 0 0 0\n", "has points and no faces, so there is no surface; export faces as well");
}

TEST_F(InspectMesh, AFrameOfTheChartsIsDrawnWhereItIsAsked) {
  write("a.off", std::string(kSheetOfTwo));
  const std::string frame = folder.path + "/drawn";
  inspect_mesh_report(folder.path + "/a.off", {0.5}, frame);
  EXPECT_TRUE(std::filesystem::exists(frame + "/frames/shell_000000.vtp"));
}

}  // namespace
