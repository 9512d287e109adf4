// Bodies and layers of STEP and IGES files, by their names.
#ifdef SUNDER_CAD

#include <map>
#include <regex>
#include <sstream>

#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Builder.hxx>
#include <TopoDS_Compound.hxx>

#include "shell/io/inspect.h"
#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class CadNames : public Cad {
 protected:
  // Two boxes with the names 'lid' and 'box'; the second one is on the layer 'sheets'.
  void write_boxes(const std::string& name) const {
    TopoDS_Compound both;
    BRep_Builder builder;
    builder.MakeCompound(both);
    builder.Add(both, BRepPrimAPI_MakeBox(10, 20, 30).Shape());
    builder.Add(both, BRepPrimAPI_MakeBox(gp_Pnt(100, 0, 0), 40, 50, 60).Shape());
    write_step(both, file(name));
    std::ifstream in(file(name));
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const std::regex solid("#(\\d+) = MANIFOLD_SOLID_BREP\\(''");
    std::string numbers[2], out;
    int count = 0;
    auto begin = text.cbegin();
    for (std::sregex_iterator it(text.begin(), text.end(), solid), end; it != end; ++it, ++count) {
      out.append(begin, (*it)[0].first);
      numbers[std::min(count, 1)] = (*it)[1];
      out += fmt::format("#{} = MANIFOLD_SOLID_BREP('{}'", (*it)[1].str(), count == 0 ? "lid" : "box");
      begin = (*it)[0].second;
    }
    ASSERT_EQ(count, 2);
    out.append(begin, text.cend());
    const std::size_t last = out.rfind("ENDSEC;");
    out.insert(last, fmt::format("#99999 = PRESENTATION_LAYER_ASSIGNMENT('sheets','',(#{}));\n", numbers[1]));
    std::ofstream(file(name)) << out;
  }
};

double whole_area(const RunSetup& r) {
  double sum = 0.0;
  for (const ShellSetup& s : r.shells)
    for (const double part : s.model.mass) sum += part / s.model.material.density / s.model.thickness;
  return sum;
}

TEST_F(CadNames, ABodyOrALayerOfAStepFileGivesItsFaces) {
  write_boxes("a.step");
  const std::string more = "element_m: 0.005";
  const RunSetup lid = setup("path: 'a.step' body: 'lid' " + more);
  EXPECT_EQ(lid.shells.size(), 6u);
  EXPECT_NEAR(whole_area(lid), 2e-6 * (200 + 300 + 600), 1e-12);
  EXPECT_NEAR(whole_area(setup("path: 'a.step' body: 'box' " + more)), 2e-6 * (2000 + 2400 + 3000), 1e-12);
  EXPECT_NEAR(whole_area(setup("path: 'a.step' layer: 'sheets' " + more)), 2e-6 * (2000 + 2400 + 3000), 1e-12);
  const std::string told = inspect_report(file("a.step"), 0.005);
  for (const char* part : {"\"bodies\"", "\"lid\"", "\"box\"", "\"layers\"", "\"sheets\""}) EXPECT_SAYS(told, part);
}

TEST_F(CadNames, AWrongNameIsAnsweredWithTheRightOnes) {
  write_boxes("a.step");
  EXPECT_SAYS(refusal("path: 'a.step' body: 'lit' element_m: 0.005"), "did you mean 'lid'?");
  EXPECT_SAYS(refusal("path: 'a.step' layer: 'roof' element_m: 0.005"), "sheets");
  EXPECT_SAYS(refusal("path: 'a.step' body: 'lid' face: 1"), "and so are faces");
  EXPECT_SAYS(refusal("path: 'a.step' body: 'lid' layer: 'sheets'"), "and so is body");
  EXPECT_SAYS(refusal("path: 'a.step' layer: 'x' faces: [0, 1]"), "and so are faces");
  write_step(sector(40), file("b.step"));
  EXPECT_SAYS(refusal("path: 'b.step' layer: 'x'"), "no layer of 'b.step' with a face has a name");
}

// Label and number are the last fields of the second line of a directory entry; programs put a label at either end.
TEST_F(CadNames, LabelsOfAnIgesFileAreBodies) {
  const std::map<std::string, std::string> names = {{"     LID        ", "LID"},
                                                    {"LID            0", "LID"},
                                                    {"  LID          0", "LID"},
                                                    {"LID            2", "LID(2)"},
                                                    {"     LID       2", "LID(2)"}};
  for (const auto& [label, name] : names) {
    write_iges(sector(40), file("a.igs"));
    std::ifstream in(file("a.igs"));
    std::string out;
    for (std::string line; std::getline(in, line); out += line + "\n") {
      const bool second = line.size() >= 73 && line[72] == 'D' && std::stoi(line.substr(73)) % 2 == 0;
      if (second && line.substr(0, 8) == "     144") line.replace(56, 16, label);
    }
    in.close();
    std::ofstream(file("a.igs")) << out;
    EXPECT_EQ(setup(fmt::format("path: 'a.igs' body: '{}'", name)).shells.size(), 1u) << label;
    EXPECT_SAYS(inspect_report(file("a.igs"), 0.005), fmt::format("\"{}\"", name));
  }
}

TEST_F(CadNames, LevelsOfAnIgesFileAreLayers) {
  write_iges(sector(40), file("a.igs"));
  std::ifstream in(file("a.igs"));
  std::string out;
  for (std::string line, before; std::getline(in, line); out += line + "\n") {
    // the level is the fifth field of the first line of a directory entry
    const bool first = line.size() >= 73 && line[72] == 'D' && std::stoi(line.substr(73)) % 2 == 1;
    if (first && line.substr(0, 8) == "     144") line.replace(32, 8, "       7");
  }
  std::ofstream(file("a.igs")) << out;
  EXPECT_EQ(setup("path: 'a.igs' layer: '7'").shells.size(), 1u);
  EXPECT_SAYS(refusal("path: 'a.igs' layer: '8'"), "7");
}

}  // namespace

#endif
