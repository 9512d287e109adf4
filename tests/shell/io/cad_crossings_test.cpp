// Faces of a CAD file whose border meets itself: the entry, the place and the remedy.
#ifdef SUNDER_CAD

#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRep_Builder.hxx>
#include <TopoDS_Compound.hxx>
#include <gp_Pln.hxx>

#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A flat face between corners [mm].
TopoDS_Face face_with_corners(const std::vector<gp_Pnt>& points) {
  BRepBuilderAPI_MakePolygon out;
  for (const gp_Pnt& p : points) out.Add(p);
  out.Close();
  return BRepBuilderAPI_MakeFace(gp_Pln(), out.Wire()).Face();
}

class CadCrossings : public Cad {
 protected:
  // A bow tie whose sides cross at x + 10, 6.667 [mm].
  static TopoDS_Face bow_tie(double x) {
    return face_with_corners({{x, 0, 0}, {x + 30, 20, 0}, {x + 30, 0, 0}, {x, 10, 0}});
  }
};

// OpenCASCADE divides such a face where its border meets itself.
TEST_F(CadCrossings, ABorderThatCrossesOrTouchesItselfIsRefused) {
  const std::vector<std::pair<TopoDS_Face, const char*>> faces{
      {face_with_corners({{0, 0, 0}, {30, 20, 0}, {30, 0, 0}, {0, 10, 0}}), "(0.01, 0.006667, "},
      {face_with_corners({{0, 0, 0}, {10, 5, 0}, {20, 0, 0}, {20, 10, 0}, {10, 5, 0}, {0, 10, 0}}), "(0.01, 0.005, "}};
  for (const auto& [face, at] : faces) {
    write_step(face, file("a.stp")), write_iges(face, file("a.igs"));
    for (const char* name : {"a.stp", "a.igs"})
      for (const char* taken : {"", "face: 0", "face: 1"}) {
        const std::string told = refusal(fmt::format("path: '{}' {} element_m: 0.002", name, taken));
        EXPECT_SAYS(told, fmt::format("cad.path: '{}': face {} is a part of entry ", name,
                                      taken == std::string("face: 1") ? 1 : 0));
        EXPECT_SAYS(told, std::string("whose border crosses or touches itself at ") + at);
        EXPECT_SAYS(told, "mend it in the CAD program, or leave its 2 faces out by `faces`");
      }
  }
}

// A compound of three faces becomes four: the bow tie is divided.
TEST_F(CadCrossings, SoundFacesBesideItAreTakenByTheirNumbers) {
  const BRep_Builder build;
  TopoDS_Compound sheet;
  build.MakeCompound(sheet);
  build.Add(sheet, face_with_corners({{0, 50, 0}, {30, 50, 0}, {30, 70, 0}, {0, 70, 0}}));
  build.Add(sheet, bow_tie(0.0));
  build.Add(sheet, face_with_corners({{50, 0, 0}, {80, 0, 0}, {80, 20, 0}, {50, 20, 0}}));
  for (const char* name : {"a.stp", "a.igs"}) {
    std::string(name) == "a.stp" ? write_step(sheet, file(name)) : write_iges(sheet, file(name));
    const std::string path = fmt::format("path: '{}' element_m: 0.002 ", name);
    const std::string told = refusal(path);
    EXPECT_SAYS(told, fmt::format("'{}': face 1 is a part of entry ", name));
    EXPECT_SAYS(told, "at (0.01, 0.006667, ");
    EXPECT_SAYS(refusal(path + "face: 2"), fmt::format("'{}': face 2 is a part of entry ", name));
    EXPECT_EQ(setup(path + "faces: [0, 3]").shells.size(), 2u) << name;  // the bow tie is faces 1 and 2
  }
}

// Places are in metres, whatever the file's unit.
TEST_F(CadCrossings, PlacesAreInMetres) {
  for (const char* unit : {"MM", "M", "INCH"}) {
    write_step(bow_tie(0.0), file("a.stp"), unit);  // the same size in each unit
    EXPECT_SAYS(refusal("path: 'a.stp' element_m: 0.002"), "at (0.01, 0.006667, ");
  }
}

TEST_F(CadCrossings, ABorderThatComesNearItselfIsAccepted) {
  // a notch that ends 0.1 mm before the other side
  write_step(face_with_corners({{0, 0, 0}, {20, 0, 0}, {20, 10, 0}, {10, 0.1, 0}, {0, 10, 0}}), file("a.stp"));
  EXPECT_EQ(error("path: 'a.stp' element_m: 0.0005"), "accepted");
}

}  // namespace

#endif
