// Wrong scenes are refused with line, field and remedy.
#include <fstream>

#include <gtest/gtest.h>

#include "tests/coupler/small_scene.h"

namespace {

using namespace small_scene;

struct Cleanup {
  ~Cleanup() {
    for (const char* name : {"scene_test.textproto", "mesh_test.textproto", "cube.off"})
      std::remove(own_file(name).c_str());
  }
} const cleanup;

struct Case {
  const char *name, *from, *to;
  int line;
  const char* says;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class BrokenScene : public testing::TestWithParam<Case> {};

TEST_P(BrokenScene, IsRefusedWithLineFieldAndRemedy) {
  const Case& c = GetParam();
  const sunder::Error e = refusal(replaced(c.from, c.to));
  EXPECT_EQ(e.status, sunder::Exit::kBadInput);
  EXPECT_EQ(e.line, c.line) << e.what();
  EXPECT_NE(std::string(e.what()).find(c.says), std::string::npos) << e.what();
}

INSTANTIATE_TEST_SUITE_P(
    All, BrokenScene,
    testing::Values(
        Case{"UnknownField", "thickness_m", "thicknes_m", 8,
             ":8:3: 'thicknes_m' is no field of Shell; did you mean 'thickness_m'? It has: name, "},
        Case{"FieldWithoutItsUnit", "size_x_m: 0.5", "size_x: 0.5", 9, "did you mean 'size_x_m'? It has: size_x_m, "},
        Case{"FieldLikeNoOther", "thickness_m", "weight", 8, "'weight' is no field of Shell; it has: name, "},
        Case{"WrongType", "thickness_m: 0.004", "thickness_m: \"thin\"", 8, "Expected double"},
        Case{"MissingPatch", "  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }", "", 5,
             "has no patch"},
        Case{"NotANumber", "density: 2500", "density: nan", 4, "must be positive"},
        Case{"NegativeThickness", "0.004", "-0.004", 8, "must be positive"},
        Case{"KnotsOutOfOrder", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { knots_u: [0,0,0,2,1,3,3,3] knots_v: [0,0,0,1,1,1] }", 9, "knots never fall"},
        Case{"ControlNetOfTheWrongSize", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { knots_u: [0,0,0,1,1,1] knots_v: [0,0,0,1,1,1] control_points { x: 1 } }", 9, "3 x 3 = 9"},
        Case{"DegreeOfFour", "elements_y: 16 }", "elements_y: 16 degree: 4 }", 9, "2 (quadratic) or 3 (cubic)"},
        Case{"CubicPatchOfTwoGaussPoints", "elements_y: 16 }", "elements_y: 16 degree: 3 } gauss_points: 2", 9,
             "which fewer under-integrate"},
        Case{"QuadraticPatchOfFourGaussPoints", "elements_y: 16 }", "elements_y: 16 } gauss_points: 4", 9,
             "is 4; 2 or 3"},
        Case{"CubicKnotsThatFold", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { degree: 3 knots_u: [0,0,0,0,1,1,1,2,2,2,2] knots_v: [0,0,0,0,1,1,1,1] }", 9, "would fold there"},
        Case{"CubicPatchOfQuadraticKnots", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { degree: 3 knots_u: [0,0,0,1,1,1] knots_v: [0,0,0,1,1,1] }", 9, "set degree 2 where both have it"},
        Case{"NurbsOfTwoDegrees", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { knots_u: [0,0,0,1,1,1] knots_v: [0,0,0,0,1,1,1,1] }", 9,
             "knots_v: the first and the last knot stand 4 times, as those of degree 3 do"},
        Case{"NurbsOfTwoDegreesToo", "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "nurbs { degree: 3 knots_u: [0,0,0,0.5,1,1,1] knots_v: [0,0,0,0,1,1,1,1] }", 9,
             "knots_u: the first and the last knot stand 3 times, as those of degree 2 do"},
        Case{"UnknownLaunchTarget", "pose { position { z: 0.1 } }", "launch { speed: 3 target: \"nobody\" }", 15,
             "'nobody' is no other"},
        Case{"DuplicateName", "name: \"ball\"", "name: \"pane\"", 12, "used twice"},
        Case{"QuaternionOffUnitLength", "pose { position { z: 0.1 } }", "pose { orientation { w: 1 x: 0.5 } }", 15,
             "quaternion"},
        Case{"TurnAboutNoAxis", "pose { position { z: 0.1 } }", "pose { rotation { axis { x: 0 } angle_deg: 30 } }", 15,
             "bodies[0].pose.rotation.axis: has no direction; give one"},
        Case{"TurnWithoutEnd", "pose { position { z: 0.1 } }", "pose { rotation { angle_deg: inf } }", 15,
             "must be finite"},
        Case{"TurnedTwice", "pose { position { z: 0.1 } }", "pose { orientation { w: 1 } rotation { angle_deg: 30 } }",
             15, "rotation"},
        Case{"MeshOutsideTheFolder", "sphere { radius_m: 0.02 }", "mesh { path: \"../../x.off\" }", 14,
             "outside the scene's folder"},
        Case{"LaunchAndTwist", "pose { position { z: 0.1 } }",
             "pose { position { z: 0.1 } } twist { linear { z: -1 } } launch { speed: 3 target: \"pane\" }", 15,
             "give one of them"},
        Case{"StaticWithATwist", "pose { position { z: 0.1 } }",
             "pose { position { z: 0.1 } } is_static: true twist { linear { z: -1 } }", 15, "never moves"},
        Case{"TooFastForASubstep", "pose { position { z: 0.1 } }",
             "pose { position { z: 0.1 } } twist { linear { z: -1e6 } }", 15, "in a substep"},
        Case{"BodyTooSmallForTheGrid", "radius_m: 0.02", "radius_m: 0.01", 11, "take more elements"},
        Case{"EndBeforeTheFirstWindow", "end_time_s: 1", "end_time_s: 1e-5", 2, "less than one window"},
        Case{"WindowBelowTheStableStep", "window_s: 1e-4", "window_s: 1e-8", 3, "shorter than the stable step"},
        Case{"BodyInsideTheShell", "z: 0.1", "z: 0.01", 15, "inside shell"},
        Case{"DamageThatTheGridDoesNotResolve", "poisson_ratio: 0.22 }",
             "poisson_ratio: 0.22 strength: 6e7 fracture_energy: 8 }\nfracture { mode: DAMAGE }", 5,
             "take more elements"},
        Case{"DamageInLessThanACell", "poisson_ratio: 0.22 }",
             "poisson_ratio: 0.22 strength: 6e7 fracture_energy: 8 }\nfracture { mode: DAMAGE damage_width_m: 1e-9 }",
             5, "cannot localise"},
        Case{"DamageWithAFieldOfTips", "poisson_ratio: 0.22 }",
             "poisson_ratio: 0.22 strength: 6e6 fracture_energy: 8 }\nfracture { mode: DAMAGE branch_ratio: 2 }", 5,
             "is for mode TIPS"},
        Case{"LoadOutsideThePatch", "elements_y: 16 }\n", "elements_y: 16 }\n  loads { point { at { u: 9 } } }\n", 10,
             "outside the patch"},
        Case{"LoadThatSaysNothing", "elements_y: 16 }\n", "elements_y: 16 }\n  loads {}\n", 10, "says nothing"},
        Case{"FactorWithTimesThatFall", "elements_y: 16 }\n",
             "elements_y: 16 }\n  loads { pressure: 1 factor { time_s: 1 } factor { time_s: 0 } }\n", 10, "must rise"},
        Case{"SupportOfNothing", "elements_y: 16 }\n", "elements_y: 16 }\n  supports { kind: CLAMPED }\n", 10,
             "corners, regions or boxes"},
        Case{"SymmetryOffItsPlane", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { edges: U_MIN kind: SYMMETRY_Y }\n", 10, "must lie in a plane across y"},
        Case{"RegionWithoutControlPoints", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { kind: CLAMPED regions { low { u: 8 v: 8 } high { u: 9 v: 9 } } }\n", 10,
             "no control point"},
        Case{"MotionThatBeginsWithAJump", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { edges: ALL kind: CLAMPED motion { displacement { z: 0.1 } } }\n", 10,
             "begins with a jump"},
        Case{"SphereThatFalls", "  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "  sphere { radius_m: 1 angle_deg: 60 from_deg: 40 to_deg: 20 elements_u: 4 elements_v: 4 }", 9,
             "must rise"},
        Case{"SectorWithoutElements", "  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "  cylinder { radius_m: 1 length_m: 1 angle_deg: 60 elements_u: 4 }", 9, "elements along a side"},
        Case{"ConeBelowZero", "  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "  cone { bottom_m: 1 top_m: -1 height_m: 1 angle_deg: 60 elements_u: 4 elements_v: 4 }", 9, "cone.top_m"},
        Case{"AxesOfAClampedEdge", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { edges: ALL kind: CLAMPED axes: X }\n", 10, "SIMPLY_SUPPORTED only"},
        Case{"SymmetryOfACorner", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { corners: U_MIN_V_MIN kind: SYMMETRY_X }\n", 10,
             "no corners, regions, boxes or motion"},
        Case{"RegionUpsideDown", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { kind: CLAMPED regions { low { u: 0.4 } high { u: 0.1 } } }\n", 10,
             "above its high one"},
        Case{"MotionThatGoesBack", "elements_y: 16 }\n",
             "elements_y: 16 }\n  supports { edges: ALL kind: CLAMPED motion { time_s: 1 } motion { time_s: 0 } }\n",
             10, "must rise"},
        Case{"MomentThatIsNotFinite", "elements_y: 16 }\n",
             "elements_y: 16 }\n  loads { edge_moment { edge: U_MIN moment_per_length: inf } }\n", 10,
             "moment_per_length"},
        Case{"LoadOfNoEdge", "elements_y: 16 }\n",
             "elements_y: 16 }\n  loads { edge_force { force_per_length { x: 1 } } }\n", 10, "name ALL, U_MIN"},
        Case{"EquilibriumWithoutATolerance", "elements_y: 16 }\n", "elements_y: 16 }\n  equilibrium { tolerance: 0 }\n",
             10, "1e-12 to 0.1"},
        Case{"EquilibriumThatMoves", "elements_y: 16 }\n", "elements_y: 16 }\n  velocity { x: 1 } equilibrium {}\n", 10,
             "starts at rest"},
        Case{"YieldingBeyondSmallStrain", "poisson_ratio: 0.22 }", "poisson_ratio: 0.22 yield_stress: 7e9 }", 4,
             "must stay small"},
        Case{"HardeningWithoutYield", "poisson_ratio: 0.22 }", "poisson_ratio: 0.22 hardening_modulus: 1e9 }", 4,
             "needs a yield_stress"},
        Case{"ProbeOutsideThePatch", "end_time_s: 1\n",
             "end_time_s: 1 output { probes { name: \"a\" shell: \"pane\" at { u: 7 } } }\n", 2, "outside the patch"},
        Case{"ProbesWithoutAnInterval", "end_time_s: 1\n", "end_time_s: 1 output { probe_interval_s: 0 }\n", 2,
             "must be positive"},
        Case{"DamageThatNeverCompletes", "poisson_ratio: 0.22 }",
             "poisson_ratio: 0.22 strength: 1 fracture_energy: 1e9 }\nfracture { mode: DAMAGE }", 5,
             "not belong together"},
        Case{"ArcTooWide", "  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }",
             "  cylinder { radius_m: 1 length_m: 1 angle_deg: 380 elements_u: 4 elements_v: 4 }", 9,
             "at most 360 degrees"},
        Case{"ProbeOfNoShell", "end_time_s: 1\n", "end_time_s: 1 output { probes { name: \"a\" shell: \"b\" } }\n", 2,
             "no shell of this scene"},
        Case{"DamageWithoutAStrength", "end_time_s: 1\n", "end_time_s: 1 fracture { mode: DAMAGE }\n", 2,
             "needs a strength"},
        Case{"SoftPiecesThatAreFrozen", "elements_y: 16 }\n}\n",
             "elements_y: 16 }\n  pieces: SOFT\n}\nfracture { latest_freeze_s: 0.5 }\n", 10,
             "is SOFT, but fracture.latest_freeze_s makes all pieces rigid at 0.5 s; leave latest_freeze_s out"},
        Case{"DamageWidthOfAnotherMode", "end_time_s: 1\n", "end_time_s: 1 fracture { damage_width_m: 0.1 }\n", 2,
             "leave it out"},
        Case{"TimeStepAboveTheStableOne", "end_time_s: 1\n", "end_time_s: 1 time_step_s: 1e-5\n", 2, "at most 4.5"},
        Case{"TimeStepAndSafety", "end_time_s: 1\n", "end_time_s: 1 time_step_s: 1e-7 time_step_safety: 0.5\n", 2,
             "leave one of them out"},
        Case{"LocalTimeStepsThroughTheGrid", "end_time_s: 1\n",
             "end_time_s: 1 transfer { kind: APIC } local_time_steps: true\n", 2, "leave one of them out"},
        Case{"TransferOfNoKind", "end_time_s: 1\n", "end_time_s: 1 transfer { kind: 7 }\n", 2,
             "DIRECT, FLIP, APIC or PIC"},
        Case{"TransferThroughAGridTooFine", "end_time_s: 1\n",
             "end_time_s: 1 transfer { kind: APIC grid_spacing_m: 1e-6 }\n", 2, "from a tenth to a hundred"},
        Case{"HertzOfNoSphere", "  sphere { radius_m: 0.02 }\n  pose { position { z: 0.1 } }\n}\n",
             "  box { size_m { x: 0.1 y: 0.1 z: 0.1 } }\n  pose { position { z: 0.1 } }\n}\ncontacts { first: \"pane\" "
             "second: \"ball\" hertz {} }\n",
             17, "a body that is a sphere"},
        Case{
            "HertzWithFriction", "  pose { position { z: 0.1 } }\n}\n",
            "  pose { position { z: 0.1 } }\n}\ncontacts { first: \"pane\" second: \"ball\" hertz {} friction: 0.1 }\n",
            17, "without friction"},
        Case{"HertzThatSinksIn", "  pose { position { z: 0.1 } }\n}\n",
             "  pose { position { z: 0.1 } }\n  twist { linear { z: -30 } }\n}\ncontacts { first: \"pane\" second: "
             "\"ball\" hertz { stiffness: 1e6 } }\n",
             18, "a fifth of its radius"},
        Case{"ProbeOfNoBody", "end_time_s: 1\n", "end_time_s: 1 output { probes { name: \"a\" body: \"b\" } }\n", 2,
             "no body of this scene"},
        Case{"ProbeOfBoth", "end_time_s: 1\n",
             "end_time_s: 1 output { probes { name: \"a\" body: \"ball\" shell: \"pane\" at { u: 0.1 } } }\n", 2,
             "is a point of a shell, and a body is given"},
        Case{"LinearBendingInLayers", "elements_y: 16 }\n", "elements_y: 16 }\n  bending: LINEAR layers: 4\n", 10,
             "leave one of them out"},
        Case{"StressAtRestInTwoLayers", "elements_y: 16 }\n", "elements_y: 16 }\n  surface_compression: 1e8\n", 10,
             "3 or more"},
        Case{"StressAtRestBeyondSmallStrain", "elements_y: 16 }\n",
             "elements_y: 16 }\n  layers: 5 surface_compression: 1e10\n", 10, "at most 0.02"},
        Case{"OneLayer", "elements_y: 16 }\n", "elements_y: 16 }\n  layers: 1\n", 10, "no bending stiffness"},
        Case{"StressAtRestThatYields", "poisson_ratio: 0.22 }\nshells {",
             "poisson_ratio: 0.22 yield_stress: 5e7 }\nshells { layers: 5 surface_compression: 6e7", 5, "yields at"},
        Case{"StressAtRestThatCracks", "poisson_ratio: 0.22 }\nshells {",
             "poisson_ratio: 0.22 strength: 5e7 fracture_energy: 8 }\nshells { layers: 5 surface_compression: 1.1e8", 5,
             "crack by itself"},
        Case{"DensityBeyondMatter", "density: 2500", "density: 1e300", 4, "1e-6 to 1e12"},
        Case{"StiffnessBeyondMatter", "youngs_modulus: 70e9", "youngs_modulus: 1e-300", 4, "1e-3 to 1e15"},
        Case{"PoissonRatioAtTheLimit", "poisson_ratio: 0.22", "poisson_ratio: -0.999999", 4, "-0.99 to 0.4999"},
        Case{"GridSpacingWithoutAGrid", "end_time_s: 1\n", "end_time_s: 1 transfer { grid_spacing_m: 0.01 }\n", 2,
             "name one of them"},
        Case{"ContactSaidTwice", "end_time_s: 1\n",
             "end_time_s: 1 contacts { first: \"pane\" second: \"ball\" hertz {} } contacts { first: \"ball\" second: "
             "\"pane\" friction: 0.1 }\n",
             2, "says again what contacts[0] says"},
        Case{"TimeStepOfNothing", "end_time_s: 1\n", "end_time_s: 1 time_step_s: 1e-300\n", 2, "substeps a window"},
        Case{"HertzBeyondReason", "end_time_s: 1\n",
             "end_time_s: 1 contacts { first: \"pane\" second: \"ball\" hertz { stiffness: 1e40 } }\n", 2,
             "take a softer one"},
        Case{"SpanOfABillionElements", "elements_x: 16", "elements_x: 1000000000", 9, "1 to 4096"}),
    [](const testing::TestParamInfo<Case>& i) { return std::string(i.param.name); });

TEST(Loads, TellTheTimeOfTheirLastChange) {
  std::string text = kScene;
  text.insert(
      text.find("elements_y: 16 }\n") + 17,
      "  loads { pressure: 1 factor { time_s: 1e-3 } factor { time_s: 0.25 value: 1 } }\n"
      "  supports { edges: ALL kind: CLAMPED motion { time_s: 0 } motion { time_s: 0.5 displacement { z: 1e-3 } } }\n");
  const std::string path = own_file("loads_test.textproto");
  std::ofstream(path) << text;
  EXPECT_EQ(sunder::shell::build(sunder::scene::load(path, {})).last_change, 0.5);
  std::remove(path.c_str());
}

TEST(TimeStep, ThatTheRefusalNamesIsAccepted) {
  EXPECT_EQ(refusal(replaced("end_time_s: 1\n", "end_time_s: 1 time_step_s: 4.5e-6\n")).kind, "accepted");
}

TEST(LinearBending, IsRefusedWhereLayersAreNeeded) {
  const auto text = [](const std::string& material, const std::string& more) {
    std::string t = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + " }" + more);
    return t.insert(t.find("elements_y: 16 }\n") + 17, "  bending: LINEAR\n");
  };
  EXPECT_EQ(refusal(text("", "")).kind, "accepted");
  for (const auto& broken :
       {text("yield_stress: 1e8", ""), text("strength: 6e6 fracture_energy: 80", " fracture { mode: DAMAGE }")}) {
    const sunder::Error e = refusal(broken);
    EXPECT_EQ(e.line, 10) << e.what();
    EXPECT_NE(std::string(e.what()).find("LINEAR has no layers"), std::string::npos) << e.what();
  }
}

TEST(Yielding, AllowsCutsAndExcludesOtherStressModels) {
  const std::string steel = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 yield_stress: 1e8 }");
  const auto with = [&](const std::string& more) {
    std::string text = steel;
    return refusal(text.insert(text.find("elements_y: 16 }\n") + 17, more + "\n"));
  };
  EXPECT_EQ(with("  cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.2 } }").kind, "accepted");
  for (const char* model : {"PAPER_PROJECTION", "JGT17", "GHF18"})
    EXPECT_NE(std::string(with(std::string("  stress_model: ") + model).what()).find("yields in plane stress"),
              std::string::npos);
}

TEST(Yielding, GoesWithDamageAndWithAnInterlayer) {
  EXPECT_EQ(refusal(replaced("poisson_ratio: 0.22 }",
                             "poisson_ratio: 0.22 strength: 6e6 fracture_energy: 80 yield_stress: 1e6 "
                             "hardening_modulus: 1e9 }\nfracture { mode: DAMAGE }"))
                .kind,
            "accepted");
  std::string text = replaced("poisson_ratio: 0.22 }",
                              "poisson_ratio: 0.22 yield_stress: 1e8 }\nmaterials { name: \"film\" density: 1000 "
                              "youngs_modulus: 1e8 poisson_ratio: 0.4 }");
  text.insert(text.find("elements_y: 16 }\n") + 17, "  interlayer { material: \"film\" thickness_m: 0.001 }\n");
  EXPECT_EQ(refusal(text).kind, "accepted");
  text.insert(text.find("  interlayer"), "  layers: 9\n");  // of each ply
  expect_refusal(text, "shells[0].layers", {"is 9 in each of two plies", "at most 8"});
}

TEST(Tempering, AllowsYieldingOrCrackingButNotBoth) {
  const auto tempered = [](const std::string& material) {
    std::string text = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + " }");
    text.insert(text.find("elements_y: 16 }\n") + 17, "  layers: 5\n  surface_compression: 1e7\n");
    return refusal(text);
  };
  EXPECT_EQ(tempered("yield_stress: 1e8").kind, "accepted");
  const std::string cracks = "strength: 5e7 fracture_energy: 100";
  EXPECT_EQ(tempered(cracks).kind, "accepted");
  const sunder::Error e = tempered("yield_stress: 1e8 " + cracks);
  EXPECT_EQ(e.status, sunder::Exit::kBadInput) << e.what();
  EXPECT_EQ(e.line, 11) << e.what();
  EXPECT_EQ(e.field, "shells[0].surface_compression") << e.what();
  EXPECT_NE(std::string(tempered("yield_stress: 5e6").what()).find("take less"), std::string::npos);
}

TEST(Scene, IsAcceptedAsItStands) { EXPECT_EQ(refusal(kScene).kind, "accepted"); }

TEST(Degree, OfPlatesAndSectorsIsThree) {
  for (const char* patch :
       {"plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 degree: 3 }",
        "cylinder { radius_m: 1 length_m: 1 angle_deg: 60 elements_u: 16 elements_v: 16 degree: 3 }",
        "sphere { radius_m: 1 angle_deg: 60 to_deg: 40 elements_u: 16 elements_v: 16 degree: 3 }",
        "cone { bottom_m: 1 height_m: 1 angle_deg: 60 elements_u: 16 elements_v: 16 degree: 3 }"}) {
    const std::string path = own_file("degree_test.textproto");
    std::ofstream(path) << replaced("plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }", patch);
    const auto setup = sunder::shell::build(
        sunder::scene::load(path, {"bodies[ball].sphere.radius_m=0.05", "bodies[ball].pose.position.z=9"}));
    EXPECT_EQ(setup.shells[0].model.tables.degree, 3) << patch;
    EXPECT_EQ(setup.shells[0].model.tables.gauss, 3) << patch;
    EXPECT_EQ(setup.shells[0].model.control_points(), 19 * 19) << patch;
    std::remove(path.c_str());
  }
}

TEST(MeshBody, WeighsAndTurnsAsTheBoxOfTheSameShape) {
  std::ofstream off(own_file("cube.off"));
  off << "OFF\n9 0 0\n0 0 0\n";  // a point inside, which is no corner
  for (int k = 0; k < 8; ++k)
    off << (k & 1 ? 0.05 : -0.05) << ' ' << (k & 2 ? 0.04 : -0.04) << ' ' << (k & 4 ? 0.06 : -0.06) << '\n';
  off.close();
  const auto body = [&](const std::string& shape) {
    std::string text = replaced("sphere { radius_m: 0.02 }", shape);
    std::ofstream(own_file("mesh_test.textproto")) << text;
    return sunder::shell::build(sunder::scene::load(own_file("mesh_test.textproto"), {})).bodies[0];
  };
  const sunder::RigidBody mesh = body(fmt::format("mesh {{ path: \"{}_cube.off\" }}", getpid())),
                          box = body("box { size_m { x: 0.1 y: 0.08 z: 0.12 } }");
  EXPECT_NEAR(mesh.mass, box.mass, 1e-12 * box.mass);
  std::array<double, 3> a{mesh.principal_inertia[0], mesh.principal_inertia[1], mesh.principal_inertia[2]},
      b{box.principal_inertia[0], box.principal_inertia[1], box.principal_inertia[2]};
  std::sort(a.begin(), a.end()), std::sort(b.begin(), b.end());
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(a[d], b[d], 1e-12 * b[d]);
  EXPECT_EQ(std::get<sunder::ConvexShape>(mesh.shape).parts[0].size(), 8u);
}

TEST(MeshBody, IsRefusedWhereItsHullIsFlatOrFarAway) {
  const auto refused = [](const std::string& points) {
    std::ofstream(own_file("cube.off")) << points;
    std::ofstream(own_file("mesh_test.textproto"))
        << replaced("sphere { radius_m: 0.02 }", fmt::format("mesh {{ path: \"{}_cube.off\" }}", getpid()));
    try {
      sunder::scene::load(own_file("mesh_test.textproto"), {});
    } catch (const sunder::Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(refused("OFF\n4 0 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n").find("flat"), std::string::npos);
  EXPECT_NE(refused("OFF\n4 0 0\n0 0 0\n1e300 0 0\n0 1 0\n0 0 1\n").find("m away"), std::string::npos);
}

TEST(Setting, ChangesOneFieldByNameAndRefusesUnknownOnes) {
  const std::string path = own_file("scene_test.textproto");
  std::ofstream(path) << kScene;
  const auto scene = sunder::scene::load(path, {"bodies[ball].twist.linear.z=-20"});
  EXPECT_EQ(scene.message.bodies(0).twist().linear().z(), -20.0);
  EXPECT_NE(std::string(refusal(kScene, {"bodies[bal].twist.linear.z=1"}).what()).find("did you mean 'ball'?"),
            std::string::npos);
  EXPECT_NE(std::string(refusal(kScene, {"end_time=1"}).what())
                .find("'end_time' is no field of Scene; did you mean 'end_time_s'? It has: "),
            std::string::npos);
  EXPECT_EQ(refusal(kScene, {"end_time_s=soon"}).kind, "bad_setting");
  EXPECT_NE(std::string(refusal(kScene, {"shells[pane].thickness_m=-1"}).what()).find("set by --set shells[pane]"),
            std::string::npos);
}

// With shear a simply supported square plate of thickness a tenth of its width deflects by 5 % more (Mindlin's plate:
// coefficient 4.27 instead of 4.06).
TEST(Thickness, OfAThickShellIsReported) {
  const auto fine = [](std::string scene) {  // so that the ball is felt wherever it hits
    const std::string coarse = "elements_x: 16 elements_y: 16";
    return scene.replace(scene.find(coarse), coarse.size(), "elements_x: 64 elements_y: 64");
  };
  EXPECT_EQ(report(fine(kScene)).find("warning"), std::string::npos);
  EXPECT_EQ(report(fine(replaced("thickness_m: 0.004", "thickness_m: 0.02"))).find("warning"), std::string::npos);
  const std::string said = report(replaced("thickness_m: 0.004", "thickness_m: 0.05"));
  EXPECT_NE(said.find("warning        shell 'pane' is 0.1 times as thick as it is wide"), std::string::npos) << said;
  EXPECT_NE(said.find("too small by about 5 %"), std::string::npos) << said;
  // a narrow shell is thick by itself, but not as a part of a wide stitched one
  std::string narrow =
      replaced("size_x_m: 0.5 size_y_m: 0.5 elements_x: 16", "size_x_m: 0.05 size_y_m: 0.5 elements_x: 2");
  narrow.replace(narrow.find("thickness_m: 0.004"), 18, "thickness_m: 0.01");
  const std::string wide =
      "shells { name: \"wide\" material: \"glass\" thickness_m: 0.01 plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: "
      "16 "
      "elements_y: 16 pose { position { x: 0.275 } } } }\n";
  EXPECT_NE(report(narrow + wide).find("'pane' is 0.063 times as thick"), std::string::npos) << report(narrow + wide);
  EXPECT_EQ(report(narrow + wide + "seams {}\n").find("warning"), std::string::npos);
}

}  // namespace

// The last knot of a plate of 1.1 m and 24 elements is below 1.1.
TEST(Places, ByAnEdgeAreOnItAndOthersAreRefusedWithTheRange) {
  const auto with = [](const std::string& end, const std::string& load, const std::string& probe,
                       const std::string& cut, const std::string& region) {
    std::string text = replaced("size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }\n",
                                "size_x_m: 1.1 size_y_m: 1.1 elements_x: 24 elements_y: 24 }\n" + load + cut + region);
    const std::size_t line = text.find("radius_m: 0.02");
    return text.replace(line, 14, "radius_m: 0.05") + probe + end;
  };
  const auto at = [](const std::string& u) { return fmt::format("{{ u: {0} v: {0} }}", u); };
  const auto load = [&](const std::string& u) { return "loads { point { at " + at(u) + " force { z: 1 } } }\n"; };
  const auto probe = [&](const std::string& u) {
    return "output { probes { name: \"a\" shell: \"pane\" at " + at(u) + " } }\n";
  };
  const auto cut = [&](const std::string& u) { return "cuts { points { u: 0.3 v: 0.4 } points " + at(u) + " }\n"; };
  const auto region = [&](const std::string& u) {
    return "supports { kind: CLAMPED regions { low " + at(u) + " high { u: 2 v: 2 } } }\n";
  };
  for (const std::string u : {"1.1", "1.1000005", "1.0999995"})
    EXPECT_EQ(refusal(with("", load(u), probe(u), cut(u), region(u))).kind, "accepted")
        << u << ": " << refusal(with("", load(u), probe(u), cut(u), region(u))).what();
  for (const auto& [text, field] : {std::pair(with("", load("1.10001"), "", "", ""), "shells[0].loads[0]"),
                                    std::pair(with("", "", probe("1.10001"), "", ""), "output.probes[0].at"),
                                    std::pair(with("", "", "", cut("1.10001"), ""), "shells[0].cuts[0].points[1]"),
                                    std::pair(with("", "", "", "", region("1.10001")), "shells[0].supports[0]")})
    expect_refusal(text, field, {"1.10001", "from 0 to 1.1 along u and from 0 to 1.1 along v"});
}

TEST(Pieces, ThatStaySoftAreAcceptedAsTheRefusalSays) {
  EXPECT_EQ(refusal(with_fields("pieces: SOFT")).kind, "accepted");
  EXPECT_EQ(refusal(with_fields("pieces: BY_STIFFNESS", "", "fracture { latest_freeze_s: 0.5 }\n")).kind, "accepted");
}

TEST(Window, ThatTheRefusalNamesIsAccepted) {
  const std::string says = refusal(replaced("window_s: 1e-4", "window_s: 1e-8")).what();
  const std::size_t found = says.find("give at least ");
  ASSERT_NE(found, std::string::npos) << says;
  const std::string named = says.substr(found + 14, says.find(" s", found + 14) - found - 14);
  EXPECT_EQ(refusal(replaced("window_s: 1e-4", "window_s: " + named)).kind, "accepted") << named;
}

// A body may move by its radius and the least thickness in a substep: 20 mm and 1 mm, not 4 mm.
TEST(SmallScene, ABodyIsAsFastAsTheThinnestPlaceAllows) {
  const std::string law = "thickness_law { along: U points { at_m: 0 factor: 1 } points { at_m: 0.5 factor: 0.25 } }";
  const auto told = [&](double speed) {
    std::string text = with_fields(law);
    const std::string pose = "pose { position { z: 0.1 } }";
    text.replace(text.find(pose), pose.size(), pose + fmt::format(" twist {{ linear {{ z: {} }} }}", -speed));
    return std::string(refusal(text).what());
  };
  const std::string says = told(1e6);
  const std::size_t at = says.find("moves 'ball' ");
  ASSERT_NE(at, std::string::npos) << says;
  const double step = std::stod(says.substr(at + 13)) / 1e6;  // with the safety factor
  EXPECT_EQ(told(0.98 * 0.021 / step).find("in a substep"), std::string::npos);
  EXPECT_NE(told(1.02 * 0.021 / step).find("in a substep"), std::string::npos);
}
