// What is said of a CAD file before there is a scene.
#include "shell/io/inspect.h"

#include <nlohmann/json.hpp>

#include "tests/shell/io/cad_fixture.h"

#ifdef SUNDER_CAD
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRep_Builder.hxx>
#include <TopoDS_Compound.hxx>
#include <gp_Pln.hxx>
#endif

using namespace sunder;
using namespace sunder::shell;

namespace {

class Inspect : public Cad {
 protected:
  std::string refused(const std::string& name) const {
    try {
      inspect_report(file(name), 0.0);
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.file, file(name));
      return e.what();
    }
    return "accepted";
  }
};

// A user has no scene, so none is named.
TEST_F(Inspect, AFileThatIsNoneIsNamedItself) {
  std::ofstream(file("broken.step")) << "ISO-10303-21;\nHEADER;\n";
#ifdef SUNDER_CAD
  EXPECT_EQ(refused("broken.step"), file("broken.step") + ": is no STEP file that can be read; export it again");
  std::ofstream(file("empty.igs")) << "";
  EXPECT_SAYS(refused("empty.igs"), "empty.igs: ends without the T line of an IGES file");
  std::ofstream(file("a.txt")) << "";
  EXPECT_SAYS(refused("a.txt"), "a.txt: is neither STEP (.step, .stp) nor IGES (.igs, .iges); export one of them");
#else
  EXPECT_SAYS(refused("broken.step"), file("broken.step") + ": this build has no OpenCASCADE");
#endif
}

#ifdef SUNDER_CAD

using Json = nlohmann::json;

TEST_F(Inspect, NamesAreThoseOfTheSceneThatIsBuilt) {
  write_step(BRepPrimAPI_MakeCylinder(25, 40).Shape(), file("can.step"));
  const Json told = Json::parse(inspect_report(file("can.step"), 0.005));
  ASSERT_EQ(told["faces"].size(), 3u);
  EXPECT_EQ(told["faces"][0]["shells"], Json({"part.1", "part.2", "part.3"}));
  EXPECT_EQ(told["faces"][2]["shells"], Json({"part.5"}));
  EXPECT_EQ(told["taken"], Json({0, 1, 2}));
  EXPECT_EQ(told["seams"]["joined"], 9);
  EXPECT_EQ(told["seams_refused"], nullptr);
  for (const Json& face : told["faces"]) {
    EXPECT_EQ(face["warning"], nullptr);
    EXPECT_NEAR(face["stable_step_s"].get<double>() / 1e-6, 1.0, 0.5);  // 5 mm at 5.3 km/s
  }
  const RunSetup r = setup("path: 'can.step' element_m: 0.005");
  ASSERT_EQ(r.shells.size(), 5u);
  EXPECT_EQ(r.shells[4].model.name, "pane.5");
}

TEST_F(Inspect, AFaceThatStaysWholeAloneHasNoNumber) {
  write_step(sector(90), file("a.step"));
  const Json told = Json::parse(inspect_report(file("a.step"), 0.0));
  EXPECT_EQ(told["faces"][0]["shells"], Json({"part"}));
  EXPECT_EQ(told["seams"], nullptr);
}

TEST_F(Inspect, PolesHaveAWarning) {
  write_step(BRepPrimAPI_MakeSphere(25).Shape(), file("ball.step"));
  const Json face = Json::parse(inspect_report(file("ball.step"), 0.0))["faces"][0];
  EXPECT_SAYS(face["warning"].get<std::string>(), "a side shrinks to a pole: take longer elements");
  EXPECT_EQ(face["unfit"], false);
  const Json longer = Json::parse(inspect_report(file("ball.step"), 0.008))["faces"][0];
  EXPECT_GT(longer["stable_step_s"].get<double>(), 8.0 * face["stable_step_s"].get<double>());
}

TEST_F(Inspect, TooShortElementsAreTheSubjectOfTheirRefusal) {
  write_step(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), file("box.step"));
  const Json told = Json::parse(inspect_report(file("box.step"), 1e-6));
  EXPECT_SAYS(told["faces"][0]["refused"].get<std::string>(),
              "--element is 1e-06 m, and the face would have 30000 x 20000 elements");
  EXPECT_EQ(told["taken"].size(), 0u);
}

TEST_F(Inspect, AFileOfTooManyFacesIsListedAndSomeCanBeTaken) {
  const BRep_Builder build;
  TopoDS_Compound stack;
  build.MakeCompound(stack);
  for (int k = 0; k <= 2000; ++k)
    build.Add(stack, BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, k), gp::DZ()), 0, 10, 0, 10).Face());
  write_iges(stack, file("stack.igs"));
  const Json told = Json::parse(inspect_report(file("stack.igs"), 0.002));
  ASSERT_EQ(told["faces"].size(), 2001u);
  EXPECT_EQ(told["faces"][2000]["kind"], "plane");
  EXPECT_SAYS(told["faces"][2000]["refused"].get<std::string>(),
              "is not tried, as the file has 2001 faces, and at most");
  EXPECT_EQ(told["taken"].size(), 0u);
  EXPECT_SAYS(
      refusal("path: 'stack.igs' element_m: 0.002"),
      "cad.path: 'stack.igs': 2001 faces would be as many shells, and at most 2000 are taken; choose by `faces:");
  EXPECT_EQ(setup("path: 'stack.igs' element_m: 0.002 faces: [2000, 7]").shells.size(), 2u);
}

#endif

}  // namespace
