// Faces of STEP and IGES files with borders off their parameter lines, and with holes.
#ifdef SUNDER_CAD

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRep_Builder.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <gp_Elips.hxx>
#include <gp_Pln.hxx>

#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Area of the part that is left [m^2], and its centre [m].
struct Left {
  double area = 0.0;
  Vec3 centre = Vec3::Zero();
};

Left left_of(const ShellModel& m) {
  Left out;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const double area = m.tables.metric[m.tables.at(q, kMetricFields, kArea, e)];
      if (area == 0.0) continue;
      out.area += area;
      out.centre += area * m.patch.evaluate(gauss_point(m.patch, m.tables, q, e).parameter).x;
    }
  out.centre /= out.area;
  return out;
}

// What OpenCASCADE says of it.
Left left_of(const TopoDS_Shape& face) {
  GProp_GProps p;
  BRepGProp::SurfaceProperties(face, p);
  const gp_Pnt c = p.CentreOfMass();
  return {1e-6 * std::abs(p.Mass()), 1e-3 * Vec3(c.X(), c.Y(), c.Z())};
}

std::vector<TopoDS_Face> faces_of(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  std::vector<TopoDS_Face> out;
  for (int i = 1; i <= faces.Extent(); ++i) out.push_back(TopoDS::Face(faces(i)));
  return out;
}

TopoDS_Face flat_face(const std::vector<gp_Pnt>& points) {
  BRepBuilderAPI_MakePolygon out;
  for (const gp_Pnt& p : points) out.Add(p);
  out.Close();
  return BRepBuilderAPI_MakeFace(gp_Pln(), out.Wire()).Face();
}

TopoDS_Face with_hole(const TopoDS_Face& face, const TopoDS_Wire& hole) {
  BRepBuilderAPI_MakeFace out(face);
  out.Add(TopoDS::Wire(hole.Reversed()));
  return out.Face();
}

TopoDS_Wire circle_at(double x, double y, double radius) {
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(gp_Pnt(x, y, 0), gp::DZ()), radius)));
}

class CadFace : public Cad {
 protected:
  ShellModel shell(const std::string& cad) const { return setup(cad).shells[0].model; }

  // Writes a face, reads it, and compares area and centre with OpenCASCADE's. A centre is a hundred times as sensitive
  // to where the border is than the area, which the polygon keeps.
  void expect_face(const TopoDS_Face& face, const std::string& cad, double tolerance = 1e-6) {
    for (const char* name : {"a.stp", "a.igs"}) {
      std::string(name).ends_with("stp") ? write_step(face, file(name)) : write_iges(face, file(name));
      for (const bool iges : {std::string(name).ends_with("igs")}) {
        const ShellModel m = shell(fmt::format("path: '{}' {}", name, cad));
        EXPECT_FALSE(m.trim.empty()) << name;
        const Left found = left_of(m), wanted = left_of(face);
        // IGES writes as many digits as its tolerance asks for
        EXPECT_NEAR(found.area / wanted.area, 1.0, std::max(tolerance, iges ? 2e-6 : 0.0)) << name;
        EXPECT_LT((found.centre - wanted.centre).norm(), 1e-4 * std::sqrt(wanted.area)) << name;
        double mass = 0.0;
        for (const double part : m.mass) mass += part;
        EXPECT_NEAR(mass, found.area * m.material.density * m.thickness, 1e-9 * mass) << name;
      }
    }
  }
};

TEST_F(CadFace, ADiscIsTheOutlineOfItsSquare) {
  expect_face(BRepBuilderAPI_MakeFace(gp_Pln(), circle(10)).Face(), "elements_u: 16 elements_v: 16");
}

TEST_F(CadFace, AnEllipseTurnedOnItsPlane) {
  const gp_Ax2 turned(gp_Pnt(3, 4, 0), gp::DZ(), gp_Dir(1, 0.4, 0));
  const TopoDS_Wire wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Elips(turned, 20, 12)));
  expect_face(BRepBuilderAPI_MakeFace(gp_Pln(), wire).Face(), "element_m: 0.0015");
}

TEST_F(CadFace, ASlantedPolygonKeepsItsCorners) {
  const TopoDS_Face face = flat_face({{0, 0, 0}, {10, 1, 0}, {12, 9.9, 0}, {5, 7, 0}, {-1, 10, 0}});
  expect_face(face, "elements_u: 20 elements_v: 20", 1e-9);
  const ShellModel m = shell("path: 'a.stp' elements_u: 20 elements_v: 20");
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(0.01, 0.001, 0), Vec3(0.005, 0.007, 0)}) {
    double nearest = 1.0;
    for (const Vec2& p : m.trim.loops.loops()[0].points)
      nearest = std::min(nearest, (m.patch.evaluate(p).x - corner).norm());
    EXPECT_LT(nearest, 1e-12);
  }
}

TEST_F(CadFace, HolesAreCutFromAPlateThatStaysWhole) {
  TopoDS_Face plate = BRepBuilderAPI_MakeFace(gp_Pln(), -20, 20, -20, 20).Face();
  plate = with_hole(with_hole(plate, circle_at(-8, 5, 6)), circle_at(9, -7, 4.5));
  expect_face(plate, "elements_u: 24 elements_v: 24");
  const ShellModel m = shell("path: 'a.stp' elements_u: 24 elements_v: 24");
  ASSERT_EQ(m.trim.loops.loops().size(), 2u);
  for (const TrimLoop& loop : m.trim.loops.loops()) EXPECT_TRUE(loop.hole);
}

TEST_F(CadFace, HolesUpToAWidthAreFilled) {
  TopoDS_Face plate = BRepBuilderAPI_MakeFace(gp_Pln(), -20, 20, -20, 20).Face();
  plate = with_hole(with_hole(plate, circle_at(-8, 5, 6)), circle_at(9, -7, 0.4));
  write_step(plate, file("a.stp"));
  EXPECT_SAYS(refusal("path: 'a.stp' elements_u: 20 elements_v: 20"),
              "cad.path: 'a.stp': hole 1 of the face encloses 5.03e-07 m^2, less than a quarter of an element");
  const ShellModel m = shell("path: 'a.stp' elements_u: 20 elements_v: 20 fill_holes_m: 0.001");
  EXPECT_EQ(m.trim.loops.loops().size(), 1u);
  EXPECT_NEAR(left_of(m).area, 1e-6 * (1600.0 - M_PI * 36.0), 1e-9);
}

TEST_F(CadFace, ABoxWithAHoleThroughItHasTwoTrimmedFaces) {
  const TopoDS_Shape part = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(30, 20, 4).Shape(),
                                            BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(11, 9, -1), gp::DZ()), 5, 6).Shape())
                                .Shape();
  write_step(part, file("part.stp"));
  const std::vector<TopoDS_Face> faces = faces_of(part);
  ASSERT_EQ(faces.size(), 7u);
  int trimmed = 0, divided = 0;
  for (int i = 0; i < 7; ++i) {
    const std::string cad = fmt::format("path: 'part.stp' face: {} element_m: 0.001", i);
    const RunSetup r = setup(cad);
    if (r.shells.size() > 1) {
      ++divided;
      continue;
    }
    const ShellModel& m = r.shells[0].model;
    trimmed += !m.trim.empty();
    EXPECT_NEAR(left_of(m).area / left_of(faces[i]).area, 1.0, 1e-6) << i;
    const SurfacePoint at = m.patch.evaluate({1e-3, 1e-3});  // outwards
    const Vec3 n = at.u.cross(at.v).normalized(), size(0.03, 0.02, 0.004);
    EXPECT_NEAR(n.dot(at.x - 0.5 * size), 0.5 * size.dot(n.cwiseAbs()), 1e-9) << i;
  }
  EXPECT_EQ(trimmed, 2);
  EXPECT_EQ(divided, 1);  // the wall of the hole
}

// Arcs have another parameter in a spline than in the file: the border is looked for on the surface.
TEST_F(CadFace, AWindowInACylinderIsWhereTheFileHasIt) {
  const gp_Ax2 across(gp_Pnt(0, 3, 20), gp::DX());
  for (const bool reversed : {false, true}) {
    const TopoDS_Shape cut =
        BRepAlgoAPI_Cut(sector(100, reversed), BRepPrimAPI_MakeCylinder(across, 9, 60).Shape()).Shape();
    const std::vector<TopoDS_Face> faces = faces_of(cut);
    ASSERT_EQ(faces.size(), 1u);
    expect_face(faces[0], "elements_u: 24 elements_v: 24", 2e-6);  // the window's edge is known to 1e-7 mm
    const CadSurface read = surface("path: 'a.stp' elements_u: 24 elements_v: 24");
    ASSERT_EQ(read.loops.size(), 1u);
    EXPECT_TRUE(read.loops[0].hole);
    EXPECT_NEAR(read.area / left_of(faces[0]).area, 1.0, 1e-9);
    for (const CadBorder& border : read.loops[0].borders)
      for (double t = 0.0; t <= 1.0; t += 0.05) {
        const Vec3 x = read.patch.evaluate(border.curve.at(t)).x;  // on both cylinders
        EXPECT_NEAR(x.head<2>().norm(), 0.025, 1e-12);
        EXPECT_NEAR(std::hypot(x.y() - 0.003, x.z() - 0.02), 0.009, 1e-9);
      }
    const SurfacePoint q = read.patch.evaluate(read.loops[0].borders[0].curve.at(0.0));
    EXPECT_LT((reversed ? -1.0 : 1.0) * -q.u.cross(q.v).dot(Vec3(q.x.x(), q.x.y(), 0.0)), 0.0);
  }
}

TEST_F(CadFace, SlantedCutsOfAConeAndASphere) {
  const TopoDS_Face cone = on(new Geom_ConicalSurface(gp_Ax3(), 0.3, 15), 0.2, 1.8, 0, 30);
  const TopoDS_Face sphere = on(new Geom_SphericalSurface(gp_Ax3(), kRadius), 0.2, 1.4, -0.6, 0.7);
  for (const TopoDS_Face& whole : {cone, sphere}) {
    const TopoDS_Shape tool = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 8), gp_Dir(0.2, 0.3, 1)), 200, 200).Shape();
    const std::vector<TopoDS_Face> faces = faces_of(BRepAlgoAPI_Cut(whole, tool).Shape());
    ASSERT_EQ(faces.size(), 1u);
    expect_face(faces[0], "elements_u: 30 elements_v: 30", 5e-6);  // four places an element are exact to degree 2
  }
}

TEST_F(CadFace, AFreeFormSheetWithASplineAsItsBorder) {
  TColgp_Array2OfPnt poles(1, 5, 1, 5);
  for (int i = 1; i <= 5; ++i)
    for (int j = 1; j <= 5; ++j) poles(i, j) = gp_Pnt(10.0 * i, 10.0 * j, ((i * 7 + j * 3) % 5) * 1.5);
  TColStd_Array1OfReal knots(1, 3);
  TColStd_Array1OfInteger times(1, 3);
  knots(1) = 0, knots(2) = 0.5, knots(3) = 1, times(1) = times(3) = 4, times(2) = 1;
  const Handle(Geom_BSplineSurface) sheet = new Geom_BSplineSurface(poles, knots, knots, times, times, 3, 3);
  const TopoDS_Shape tool = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(28, 33, -50), gp_Dir(0.1, 0.2, 1)), 8, 100).Shape();
  const std::vector<TopoDS_Face> faces = faces_of(BRepAlgoAPI_Cut(whole(sheet), tool).Shape());
  ASSERT_EQ(faces.size(), 1u);
  expect_face(faces[0], "elements_u: 32 elements_v: 32", 1e-5);
}

// Below a cubic spline y(x) over uneven knots t: its control points stand over the Greville abscissae, so x is the
// parameter, and the area is the sum of y_i (t_(i+4) - t_i)/4.
TEST_F(CadFace, TheAreaWithinASplineIsExact) {
  const std::vector<double> knots{0, 2, 5, 30, 100, 110, 200}, y{0, 90, 10, 100, 20, 110, 30, 80, 0};
  std::vector<double> t(3, knots.front());
  t.insert(t.end(), knots.begin(), knots.end()), t.insert(t.end(), 3, knots.back());
  const int n = static_cast<int>(y.size());
  TColgp_Array1OfPnt points(1, n);
  double exact = 0.0;
  for (int i = 0; i < n; ++i) {
    points(i + 1) = gp_Pnt((t[i + 1] + t[i + 2] + t[i + 3]) / 3.0, y[i], 0.0);
    exact += 1e-6 * y[i] * (t[i + 4] - t[i]) / 4.0;
  }
  const int count = static_cast<int>(knots.size());
  TColStd_Array1OfReal at(1, count);
  TColStd_Array1OfInteger times(1, count);
  for (int i = 0; i < count; ++i) at(i + 1) = knots[i], times(i + 1) = i == 0 || i + 1 == count ? 4 : 1;
  const Handle(Geom_BSplineCurve) above = new Geom_BSplineCurve(points, at, times, 3);
  BRepBuilderAPI_MakeWire wire(BRepBuilderAPI_MakeEdge(above).Edge(),
                               BRepBuilderAPI_MakeEdge(points(n), points(1)).Edge());
  write_step(BRepBuilderAPI_MakeFace(gp_Pln(), wire.Wire()).Face(), file("a.step"));
  EXPECT_NEAR(surface("path: 'a.step' element_m: 0.005").area / exact, 1.0, 1e-9);
}

TEST_F(CadFace, HolesThatCrossAreRefused) {
  TopoDS_Face plate = BRepBuilderAPI_MakeFace(gp_Pln(), -20, 20, -20, 20).Face();
  for (const double x : {0.0, 5.0}) {
    BRepBuilderAPI_MakePolygon square;
    for (const gp_Pnt& p : {gp_Pnt(x, x, 0), gp_Pnt(x + 8, x, 0), gp_Pnt(x + 8, x + 8, 0), gp_Pnt(x, x + 8, 0)})
      square.Add(p);
    square.Close();
    plate = with_hole(plate, square.Wire());
  }
  write_step(plate, file("a.stp"));
  EXPECT_SAYS(refusal("path: 'a.stp' element_m: 0.002"), "'a.stp': hole 1 of the face meets hole 0 of the face at (");
}

// A rectangle of 40 mm by 20 mm whose last side ends `gap` [mm] short of the first one.
TopoDS_Face open_rectangle(double gap) {
  const gp_Pnt corners[5] = {{0, 0, 0}, {40, 0, 0}, {40, 20, 0}, {0, 20, 0}, {0, gap, 0}};
  const BRep_Builder build;
  TopoDS_Wire wire;
  build.MakeWire(wire);
  for (int k = 0; k < 4; ++k) build.Add(wire, BRepBuilderAPI_MakeEdge(corners[k], corners[k + 1]).Edge());
  TopoDS_Face face;
  build.MakeFace(face, new Geom_Plane(gp_Pln()), 1e-7);
  build.Add(face, wire);
  return face;
}

// OpenCASCADE gives the corner a tolerance of half the gap, up to a millimetre.
TEST_F(CadFace, ABorderWithAGapIsRefusedWithItsPlace) {
  for (const double gap : {0.5, 3.0}) {
    write_step(open_rectangle(gap), file("a.stp"));
    const std::string told = refusal("path: 'a.stp' element_m: 0.002");
    EXPECT_SAYS(told, fmt::format("'a.stp': face 0 has a border with a gap of {:.3g} m at (", 1e-3 * gap));
    EXPECT_SAYS(told, fmt::format(", {:.4g}, ", 1e-3 * gap));
    EXPECT_SAYS(told, " m are allowed; sew it in the CAD program");
  }
  write_step(open_rectangle(0.01), file("a.stp"));
  EXPECT_NEAR(left_of(shell("path: 'a.stp' element_m: 0.002")).area, 8e-4, 1e-6);
  write_iges(open_rectangle(0.5), file("a.igs"));
  EXPECT_SAYS(refusal("path: 'a.igs' element_m: 0.002"), "face 0 has a border with a gap of 0.0005 m at (");
}

TEST_F(CadFace, SliversAndFacesWithoutAreaAreRefused) {
  for (const TopoDS_Face& face :
       {BRepBuilderAPI_MakeFace(gp_Pln(), 0, 10, 0, 1e-5).Face(), flat_face({{0, 0, 0}, {10, 0, 0}, {5, 1e-4, 0}}),
        flat_face({{0, 0, 0}, {10, 0, 0}, {5, 0, 0}})}) {
    write_step(face, file("a.stp")), write_iges(face, file("a.igs"));
    for (const char* name : {"a.stp", "a.igs"}) {
      const std::string told = refusal(fmt::format("path: '{}' element_m: 0.001", name));
      EXPECT_SAYS(told, fmt::format("cad.path: '{}': face 0 has an area of ", name));
      EXPECT_SAYS(told, ": a sliver; remove it in the CAD program, or leave it out by `faces`");
    }
  }
  write_step(BRepBuilderAPI_MakeFace(gp_Pln(), 0, 10, 0, 0.1).Face(), file("strip.stp"));
  EXPECT_EQ(refusal("path: 'strip.stp' element_m: 0.001"), "accepted");
}

TEST_F(CadFace, WhatAFaceCannotHaveIsRefused) {
  write_step(BRepBuilderAPI_MakeFace(gp_Pln(), circle(10)).Face(), file("disc.stp"));
  EXPECT_SAYS(refusal("path: 'disc.stp' element_m: 1e-6"),
              "element_m: is 1e-06 m, and the face would have 20000 x 20000");
  EXPECT_EQ(refusal("path: 'disc.stp' elements_u: 8 elements_v: 8"), "accepted");
  const std::string ring = "path: 'disc.stp' elements_u: 20 elements_v: 20 } trims { ";
  EXPECT_SAYS(error(ring + "circle { center { u: 0.01 v: 0.01 } radius_m: 0.005 } } velocity { "),
              "trims[0]: is a second outline, and the face's border is one");
  EXPECT_SAYS(error(ring + "hole: true circle { center { u: 0.015 v: 0.015 } radius_m: 0.004 } } velocity { "),
              "trims[0]: meets the face's border at (");
  EXPECT_EQ(error(ring + "hole: true circle { center { u: 0.011 v: 0.01 } radius_m: 0.005 } } velocity { "),
            "accepted");
  EXPECT_EQ(error("path: 'disc.stp' elements_u: 9 elements_v: 9 } interlayer { material: 'glass' thickness_m: 1e-5 "),
            "accepted");
}

}  // namespace

#endif
