// All faces of a file as shells that are joined.
#ifdef SUNDER_CAD

#include <array>
#include <cstring>
#include <map>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRep_Builder.hxx>
#include <GProp_GProps.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <gp_Pln.hxx>
#include <gp_Trsf.hxx>
#include <gp_Vec.hxx>

#include "shell/io/check.h"
#include "shell/solver/trimming.h"
#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

int edges_of(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  return edges.Extent();
}

struct Sheet {
  gp_Pln plane;
  std::vector<gp_Pnt> corners;  // [mm]
};

// Plane faces; corners in one place are one, and so are edges.
TopoDS_Shape sheets(const std::vector<Sheet>& faces) {
  using Place = std::array<double, 3>;
  std::map<Place, TopoDS_Vertex> corners;
  std::map<std::pair<Place, Place>, TopoDS_Edge> edges;
  const BRep_Builder build;
  TopoDS_Shell out;
  build.MakeShell(out);
  for (const Sheet& face : faces) {
    BRepBuilderAPI_MakeWire wire;
    for (std::size_t k = 0; k < face.corners.size(); ++k) {
      std::array<Place, 2> ends;
      for (const int end : {0, 1}) {
        const gp_Pnt& p = face.corners[(k + end) % face.corners.size()];
        ends[end] = {p.X(), p.Y(), p.Z()};
        if (!corners.count(ends[end])) corners[ends[end]] = BRepBuilderAPI_MakeVertex(p).Vertex();
      }
      std::sort(ends.begin(), ends.end());
      TopoDS_Edge& edge = edges[{ends[0], ends[1]}];
      if (edge.IsNull()) edge = BRepBuilderAPI_MakeEdge(corners[ends[0]], corners[ends[1]]).Edge();
      wire.Add(edge);
    }
    build.Add(out, BRepBuilderAPI_MakeFace(face.plane, wire.Wire()).Face());
  }
  return out;
}

class CadParts : public Cad {
 protected:
  // All faces are there with their area, and as many seams as the solid has edges; `smooth` of them are.
  RunSetup expect_joined(const TopoDS_Shape& solid, const std::string& cad, int smooth, double tolerance) {
    write_step(solid, file("a.stp"));
    RunSetup r = setup("path: 'a.stp' " + cad);
    GProp_GProps p;
    BRepGProp::SurfaceProperties(solid, p);
    double mass = 0.0;
    for (const ShellSetup& s : r.shells) {
      for (const double part : s.model.mass) mass += part;
      EXPECT_EQ(s.model.contact_group, 0u);
    }
    EXPECT_NEAR(mass / (2500 * 0.0001 * 1e-6 * p.Mass()), 1.0, tolerance);
    EXPECT_EQ(static_cast<int>(r.stitches.seams.size()), edges_of(solid));
    int found = 0;
    for (const Seam& s : r.stitches.seams) found += s.smooth;
    EXPECT_EQ(found, smooth);
    return r;
  }
};

TEST_F(CadParts, ABoxIsSixShellsWithTwelveCreases) {
  const RunSetup r = expect_joined(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), "element_m: 0.005", 0, 1e-12);
  ASSERT_EQ(r.shells.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(r.shells[k].model.name, fmt::format("pane.{}", k + 1));
  for (const Seam& s : r.stitches.seams) {
    EXPECT_FALSE(s.trimmed());
    EXPECT_NEAR(s.angle, 0.5 * M_PI, 1e-9);
  }
}

// Two sides are L-shaped: they are trimmed, and tied along the notch and the cut ends.
TEST_F(CadParts, ANotchedBlockIsTiedAlongItsTrimmedFaces) {
  const TopoDS_Shape block = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(40, 30, 20).Shape(),
                                             BRepPrimAPI_MakeBox(gp_Pnt(22, -5, 9), 30, 40, 30).Shape())
                                 .Shape();
  const RunSetup r = expect_joined(block, "element_m: 0.0031", 0, 1e-9);
  EXPECT_EQ(r.shells.size(), 8u);
  int ties = 0;
  for (const Seam& s : r.stitches.seams) ties += s.trimmed();
  EXPECT_EQ(ties, 8);  // four edges of each L; two are whole edges of its patch
}

// The fillet is a quarter of a cylinder; it meets two sides smoothly and two ends, which are trimmed, at right angles.
TEST_F(CadParts, AFilletIsSmooth) {
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(40, 30, 20).Shape();
  BRepFilletAPI_MakeFillet own(box);
  own.Add(6, TopoDS::Edge(TopExp_Explorer(box, TopAbs_EDGE).Current()));
  own.Build();
  const RunSetup r = expect_joined(own.Shape(), "element_m: 0.003", 2, 1e-6);
  EXPECT_EQ(r.shells.size(), 7u);
}

TEST_F(CadParts, FacesCanBeChosen) {
  write_step(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), file("a.stp"));
  const RunSetup r = setup("path: 'a.stp' faces: 4 faces: 0 element_m: 0.005");
  ASSERT_EQ(r.shells.size(), 2u);
  EXPECT_EQ(r.stitches.seams.size(), 1u);
  const Patch face = patch("path: 'a.stp' face: 4 element_m: 0.005");
  EXPECT_EQ((face.control_points[0] - r.shells[0].model.patch.control_points[0]).norm(), 0.0);
}

TEST_F(CadParts, NamesOfFacesCanBeUsedAndAreChecked) {
  write_step(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), file("a.stp"));
  const std::string cad = "path: 'a.stp' element_m: 0.005";
  const auto error_of = [&](const std::string& after) {
    try {
      setup(cad, after);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(error_of("seams { rules { first: 'pane.1' second: 'pane.3' kind: HINGE } }"), "accepted");
  EXPECT_SAYS(error_of("seams { rules { first: 'pane.1' second: 'pane.7' } }"),
              "seams.rules[0].second: is 'pane.7', but 'pane' is 6 shells, pane.1 to pane.6; name one of them");
  EXPECT_SAYS(error_of("seams { rules { first: 'pane.1' second: 'pane' } }"),
              "seams.rules[0].second: 'pane' is 6 shells, pane.1 to pane.6; name one");
  EXPECT_SAYS(error_of("seams { rules { first: 'pane.1' second: 'pane.x' } }"), "pane.x");
  EXPECT_SAYS(error_of("seams { rules { first: 'pane.0' second: 'pane.1' } }"), "pane.0");
  EXPECT_EQ(error_of("output { probes { name: 'p' shell: 'pane.2' at { u: 0.01 v: 0.01 } } }"), "accepted");
  EXPECT_SAYS(error_of("output { probes { name: 'p' shell: 'pane.9' at { u: 0.01 v: 0.01 } } }"),
              "output.probes[0].shell: is 'pane.9'");
  EXPECT_SAYS(error_of("output { probes { name: 'p' shell: 'pane' at { u: 0.01 v: 0.01 } } }"),
              "output.probes[0].shell: 'pane' is 6 shells, pane.1 to pane.6; name one");
  EXPECT_SAYS(error_of("contacts { first: 'pane.1' second: 'pane.2' }"), "all faces of a shell are one side of a pair");
  EXPECT_EQ(setup(cad, "seams { rules { first: 'pane.1' second: 'pane.3' kind: OPEN } }").stitches.seams.size(), 11u);
}

// One face of a cylinder is three shells, whose names are known once it is divided.
TEST_F(CadParts, PartsOfOneFaceHaveNamesToo) {
  write_step(BRepPrimAPI_MakeCylinder(25, 40).Shape(), file("a.stp"));
  const std::string cad = "path: 'a.stp' face: 0 element_m: 0.005";
  const auto probe = [&](const std::string& name) {
    return setup(cad, "output { probes { name: 'p' shell: '" + name + "' at { u: 0.01 v: 0.01 } } }").probes;
  };
  ASSERT_EQ(probe("pane.2").size(), 1u);
  EXPECT_EQ(probe("pane.2")[0].shell, 1);
  try {
    probe("pane");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_SAYS(e.what(), "output.probes[0].shell: 'pane' is 3 shells, pane.1 to pane.3; name one");
  }
}

// A closed shell has no normal, so the ball comes from above as at a body; one face has its own.
TEST_F(CadParts, ALaunchAimsAtTheMiddleOfAllFaces) {
  write_step(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), file("a.stp"));
  const std::string cad = "path: 'a.stp' element_m: 0.005 pose { position { x: 1 } }";
  const auto ball = [&](const std::string& target) {
    return setup(cad,
                 "bodies { name: 'ball' material: 'glass' sphere { radius_m: 0.01 } pose { position { z: 0.2 } } "
                 "launch { speed: 5 target: '" +
                     target + "' } }")
        .bodies[0];
  };
  const Vec3 middle(1.020, 0.015, 0.010);
  const RigidBody b = ball("pane");
  EXPECT_LT((b.motion.velocity - Vec3(0, 0, -5)).norm(), 1e-9);
  EXPECT_NEAR((b.motion.position - middle).cross(b.motion.velocity).norm(), 0.0, 1e-9);
  EXPECT_NEAR((b.motion.position - middle).norm(), (Vec3(0, 0, 0.2) - middle).norm(), 1e-9);
  const RigidBody side = ball("pane.1");
  const Vec3 from = side.motion.position - middle;
  EXPECT_NEAR(from.cross(side.motion.velocity).norm(), 0.0,
              1e-9);  // through the middle of the box, along a side's normal
  EXPECT_NEAR(std::abs(side.motion.velocity.z()), 0.0, 1e-9);
}

// The caps of a cylinder are trimmed. Seams between its faces are no reason.
TEST_F(CadParts, TrimmedFacesExcludeFibres) {
  write_step(BRepPrimAPI_MakeCylinder(25, 40).Shape(), file("a.stp"));
  const auto refused = [&](const std::string& cad, const std::string& more, const std::string& after) {
    try {
      setup("path: 'a.stp' element_m: 0.005 " + cad + "} " + more, after);  // which closes the brace
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  const std::string fibres = "fibres { compression_modulus: 1e5 shear_modulus: 1e5";
  const std::string contacts = "contacts { first: 'pane' second: 'pane' }";
  EXPECT_SAYS(refused("", fibres, contacts),
              "shells[0].cad.path: 'a.stp': the face is trimmed, which cannot go with fibres, whose stable step needs "
              "control points of whole mass, and a loop leaves some little; leave that out");
  EXPECT_EQ(refused("face: 0", fibres, contacts), "accepted");  // the wall alone, of several parts
  EXPECT_EQ(refused("face: 0", "equilibrium {", ""), "accepted");
}

// The second shell of the scene is the fourth of the run.
TEST_F(CadParts, ACheckNamesTheShellOfTheScene) {
  write_step(BRepPrimAPI_MakeCylinder(25, 40).Shape(), file("a.stp"));
  const RunSetup r =
      setup("path: 'a.stp' face: 0 element_m: 0.005",
            "shells { name: 'held' material: 'glass' thickness_m: 0.0001 plate { size_x_m: 0.1 size_y_m: "
            "0.1 elements_x: 2 elements_y: 2 pose { position { z: 1 } } } supports { edges: ALL kind: "
            "CLAMPED } }");
  try {
    check_report(scene::load(file("scene.textproto"), {}), r);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.field, "shells[1].supports");
  }
}

// Faces that close on themselves are divided: three parts round a cylinder, six of a sphere, nine of a torus.
TEST_F(CadParts, ClosedFacesAreDivided) {
  struct Solid {
    TopoDS_Shape shape;
    const char* element;
    std::size_t shells, seams;
    int smooth;
  };
  const TopoDS_Shape hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(11, 9, -1), gp::DZ()), 5, 6).Shape();
  for (const Solid& s :
       {Solid{BRepPrimAPI_MakeCylinder(25, 40).Shape(), "element_m: 0.004", 5, 9, 3},
        Solid{BRepPrimAPI_MakeSphere(25).Shape(), "element_m: 0.004", 6, 9, 9},
        Solid{BRepPrimAPI_MakeTorus(25, 8).Shape(), "element_m: 0.004", 9, 18, 18},
        Solid{BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(30, 20, 4).Shape(), hole).Shape(), "element_m: 0.001", 9, 21, 3}}) {
    write_step(s.shape, file("a.stp"));
    const RunSetup r = setup(std::string("path: 'a.stp' ") + s.element);
    EXPECT_EQ(r.shells.size(), s.shells);
    EXPECT_EQ(r.stitches.seams.size(), s.seams);
    double mass = 0.0;
    int smooth = 0;
    for (const ShellSetup& shell : r.shells)
      for (const double part : shell.model.mass) mass += part;
    for (const Seam& seam : r.stitches.seams) smooth += seam.smooth;
    EXPECT_EQ(smooth, s.smooth);
    GProp_GProps p;
    BRepGProp::SurfaceProperties(s.shape, p);
    EXPECT_NEAR(mass / (2500 * 0.0001 * 1e-6 * p.Mass()), 1.0, 2e-5);  // quadrature of coarse arcs
  }
}

TEST_F(CadParts, ThreeFacesAtAnEdgeAreRefusedAndTwoOfThemAreJoined) {
  const gp_Pln flat, up(gp_Pnt(), gp::DX());
  write_step(sheets({{flat, {{0, 0, 0}, {30, 0, 0}, {30, 20, 0}, {0, 20, 0}}},
                     {flat, {{0, 20, 0}, {-30, 20, 0}, {-30, 0, 0}, {0, 0, 0}}},
                     {up, {{0, 0, 0}, {0, 20, 0}, {0, 20, 15}, {0, 0, 15}}}}),
             file("a.stp"));
  const std::string told = refusal("path: 'a.stp' element_m: 0.0025");
  EXPECT_SAYS(told, "shells[0].cad.path: 'a.stp': faces 0, 1, 2 share an edge of 0.02 m about (0, 0.01, 0) m");
  EXPECT_SAYS(told, "leave faces out until two are left there, such as faces: [0, 1], or divide the part");
  for (const char* two : {"faces: [0, 1]", "faces: [1, 2]", "faces: [2, 0]"}) {
    const RunSetup r = setup(std::string("path: 'a.stp' element_m: 0.0025 ") + two);
    EXPECT_EQ(r.shells.size(), 2u) << two;
    EXPECT_EQ(r.stitches.seams.size(), 1u) << two;
  }
}

// Its neighbours have no edge in common, so they meet by their places.
TEST_F(CadParts, ASliverIsRefusedAndCanBeLeftOut) {
  const double w = 1e-4;  // [mm]
  write_step(sheets({{gp_Pln(), {{0, 0, 0}, {20, 0, 0}, {20, 20, 0}, {0, 20, 0}}},
                     {gp_Pln(), {{20, 0, 0}, {20 + w, 0, 0}, {20 + w, 20, 0}, {20, 20, 0}}},
                     {gp_Pln(), {{20 + w, 0, 0}, {40, 0, 0}, {40, 20, 0}, {20 + w, 20, 0}}}}),
             file("a.stp"));
  EXPECT_SAYS(refusal("path: 'a.stp' element_m: 0.002"),
              " has an area of 2e-09 m^2 within a border of 0.04 m: a sliver");
  std::string others;
  for (int k = 0; k < 3; ++k)
    if (refusal(fmt::format("path: 'a.stp' face: {} element_m: 0.002", k)) == "accepted")
      others += fmt::format("faces: {} ", k);
  EXPECT_EQ(others.size(), 2 * std::strlen("faces: 0 ")) << others;
  const std::string cad = "path: 'a.stp' element_m: 0.002 " + others;
  EXPECT_SAYS(error(cad), " nearly meet: they are ");
  EXPECT_EQ(setup(cad, "seams { tolerance_m: 4e-7 }").stitches.seams.size(), 1u);
}

// The faces of a box without an edge in common, each moved outwards [mm]; one of them, from 1, is turned over.
TopoDS_Shape loose_box(double outwards, int turned = 0) {
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(BRepPrimAPI_MakeBox(40, 30, 20).Shape(), TopAbs_FACE, faces);
  const BRep_Builder build;
  TopoDS_Compound out;
  build.MakeCompound(out);
  for (int i = 1; i <= faces.Extent(); ++i) {
    GProp_GProps p;
    BRepGProp::SurfaceProperties(faces(i), p);
    gp_Trsf moved;
    moved.SetTranslation(outwards * gp_Vec(gp_Pnt(20, 15, 10), p.CentreOfMass()).Normalized());
    build.Add(out, (i == turned ? faces(i).Reversed() : faces(i)).Moved(TopLoc_Location(moved)));
  }
  return out;
}

TEST_F(CadParts, LooseFacesAreJoinedUpToTheTolerance) {
  const std::string cad = "path: 'a.igs' element_m: 0.005";
  write_iges(loose_box(0.0), file("a.igs"));
  const RunSetup exact = setup(cad);
  EXPECT_EQ(exact.shells.size(), 6u);
  EXPECT_EQ(exact.stitches.seams.size(), 12u);
  write_iges(loose_box(0.005), file("a.igs"));
  EXPECT_SAYS(error(cad), " nearly meet: they are ");
  EXPECT_SAYS(error(cad), "seams.tolerance_m");
  EXPECT_EQ(setup(cad, "seams { tolerance_m: 2e-5 }").stitches.seams.size(), 12u);
}

// How many shells look away from the middle of the box.
int outwards(const RunSetup& r) {
  int out = 0;
  for (const ShellSetup& s : r.shells) {
    const Patch& p = s.model.patch;
    const SurfacePoint q = p.evaluate(0.5 * Vec2(p.knots_u.end(), p.knots_v.end()));
    out += q.u.cross(q.v).dot(q.x - Vec3(0.02, 0.015, 0.01)) > 0.0;
  }
  return out;
}

TEST_F(CadParts, ALooseFaceThatLooksTheOtherWayIsTurnedOver) {
  const std::string cad = "path: 'a.igs' element_m: 0.005";
  write_iges(loose_box(0.0), file("a.igs"));
  ASSERT_EQ(outwards(setup(cad)), 6);
  for (int turned = 1; turned <= 6; ++turned) {
    write_iges(loose_box(0.0, turned), file("a.igs"));
    const RunSetup r = setup(cad);
    EXPECT_EQ(r.stitches.seams.size(), 12u);
    EXPECT_EQ(outwards(r), 6) << turned;
    double area = 0.0;
    for (const ShellSetup& s : r.shells)
      for (const double part : s.model.mass) area += part / (2500 * 1e-4);
    EXPECT_NEAR(area, 2e-4 * (4 * 3 + 3 * 2 + 2 * 4), 1e-9);
    int single = 0;
    for (int face = 0; face < 6; ++face) single += outwards(setup(fmt::format("{} face: {}", cad, face)));
    EXPECT_EQ(single, 5) << turned;  // a face by itself is as the file has it
  }
}

// Two plates, one beside the other or turned over, that have no edge in common.
TopoDS_Shape loose_plates(bool turned) {
  const BRep_Builder build;
  TopoDS_Compound out;
  build.MakeCompound(out);
  build.Add(out, BRepBuilderAPI_MakeFace(gp_Pln(), 0, 40, 0, 20).Face());
  const TopoDS_Shape other = BRepBuilderAPI_MakeFace(gp_Pln(), -30, 0, 0, 20).Shape();
  build.Add(out, turned ? other.Reversed() : other);
  return out;
}

TEST_F(CadParts, SmoothLooseFacesAreTurnedToOneSideAndJoined) {
  for (const bool turned : {false, true}) {
    write_iges(loose_plates(turned), file("a.igs"));
    const RunSetup r = setup("path: 'a.igs' element_m: 0.005");
    ASSERT_EQ(r.stitches.seams.size(), 1u) << turned;
    EXPECT_TRUE(r.stitches.seams[0].smooth);
    for (const ShellSetup& s : r.shells) {
      const SurfacePoint q = s.model.patch.evaluate({0.001, 0.001});
      EXPECT_GT(q.u.cross(q.v).z(), 0.0) << turned;
    }
  }
}

// Two plates, one above the other by `apart` [mm], that the file joins at an edge all the same.
TopoDS_Shape sewn_plates(double apart) {
  BRepBuilderAPI_Sewing sew(2.0 * apart);
  sew.Add(BRepBuilderAPI_MakeFace(gp_Pln(), 0, 40, 0, 20).Face());
  sew.Add(BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, apart), gp::DZ()), -30, 0, 0, 20).Face());
  sew.Perform();
  return sew.SewedShape();
}

TEST_F(CadParts, FacesThatShareAnEdgeAndDoNotMeetAreRefused) {
  const std::string cad = "path: 'a.stp' element_m: 0.002";
  const auto told = [&](const std::string& after) {
    try {
      setup(cad, after);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  write_step(sewn_plates(0.01), file("a.stp"));
  EXPECT_EQ(setup(cad).stitches.seams.size(), 1u);  // by the tolerance of the file
  EXPECT_SAYS(told("seams { tolerance_m: 1e-6 }"), " nearly meet: they are ");
  write_step(sewn_plates(0.5), file("a.stp"));
  EXPECT_SAYS(told("seams { tolerance_m: 1e-6 }"),
              "shells[0].cad.path: 'a.stp': faces 0 and 1 share an edge of 0.02 m about (0, 0.01, ");
  EXPECT_SAYS(told("seams { tolerance_m: 1e-6 }"), "do not meet there; give a larger seams.tolerance_m");
  EXPECT_EQ(told("seams { tolerance_m: 1e-6 rules { first: 'pane.1' second: 'pane.2' kind: OPEN } }"), "accepted");
}

// The branch of a tee: its end runs along a curve on the other cylinder, which loses a window there.
TEST_F(CadParts, AWindowOverALineOfDivision) {
  const TopoDS_Shape tee =
      BRepAlgoAPI_Fuse(BRepPrimAPI_MakeCylinder(20, 50).Shape(),
                       BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 25), gp_Dir(-1, 0.1, 0)), 10, 40).Shape())
          .Shape();
  write_step(tee, file("a.stp"));
  const RunSetup r = setup("path: 'a.stp' element_m: 0.002");
  double mass = 0.0;
  for (const ShellSetup& shell : r.shells)
    for (const double part : shell.model.mass) mass += part;
  GProp_GProps p;
  BRepGProp::SurfaceProperties(tee, p);
  EXPECT_NEAR(mass / (2500 * 0.0001 * 1e-6 * p.Mass()), 1.0, 2e-5);
  // The branch and the window meet all round: at points c + s d of the branch's lines where x^2 + y^2 = 0.02^2.
  const Vec3 d = Vec3(-1.0, 0.1, 0.0).normalized(), across = Vec3::UnitZ().cross(d);
  constexpr int kPieces = 2000;
  std::vector<Vec3> curve;
  for (int k = 0; k <= kPieces; ++k) {
    const double a = 2.0 * M_PI * k / kPieces;
    const Vec3 c = Vec3(0.0, 0.0, 0.025) + 0.010 * (std::cos(a) * across + std::sin(a) * Vec3::UnitZ());
    const double b = c.x() * d.x() + c.y() * d.y(), flat = d.x() * d.x() + d.y() * d.y();
    const double left = c.x() * c.x() + c.y() * c.y() - 0.02 * 0.02;
    curve.push_back(c + (-b + std::sqrt(b * b - flat * left)) / flat * d);
  }
  double exact = 0.0, between = 0.0;
  for (int k = 0; k < kPieces; ++k) exact += (curve[k + 1] - curve[k]).norm();
  for (const Seam& seam : r.stitches.seams) {
    double off = 0.0;  // of its places from the curve
    for (const SeamPlace& place : seam.places) {
      const ShellModel& m = r.shells[seam.first].model;
      Vec3 at = Vec3::Zero();
      for (const GatheredFunction& f : shell_functions(m, place.first))
        for (int i = 0; i < 3; ++i) at[i] += f.n[0] * m.rest[i * m.tables.component_stride + f.slot];
      double nearest = 1.0;
      for (const Vec3& on : curve) nearest = std::min(nearest, (at - on).norm());
      off = std::max(off, nearest);
    }
    if (seam.trimmed() && off < 1e-4) between += seam.length;
  }
  EXPECT_NEAR(between / exact, 1.0, 1e-3);
}

}  // namespace

#endif
