// Shells from STEP and IGES files; the files are written here. Without OpenCASCADE: what is said then.
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "coupler/scene/load.h"
#include "shell/io/build.h"

#ifdef SUNDER_CAD
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>
#endif

using namespace sunder;
using namespace sunder::shell;

namespace {

/// A folder of this test's own, gone afterwards.
class Cad : public testing::Test {
 protected:
  Cad() { std::filesystem::create_directories(folder_); }
  ~Cad() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name) const { return folder_ + "/" + name; }

  Patch patch(const std::string& cad) const {
    std::ofstream(file("scene.textproto")) << R"(name: "cad"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.0001
  cad { )" << cad << " }\n}\n";
    return build(scene::load(file("scene.textproto"), {})).shells[0].model.patch;
  }
  std::string refusal(const std::string& cad) const {
    try {
      patch(cad);
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      EXPECT_EQ(e.line, 9) << e.what();
      EXPECT_EQ(e.field.rfind("shells[0].cad", 0), 0u) << e.field;
      return e.what();
    }
    return "accepted";
  }

  std::string folder_ = fmt::format("{}cad_test_{}", testing::TempDir(), getpid());
};

#define EXPECT_SAYS(text, part) EXPECT_PRED2(says, text, part)
bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(Cad, NumbersAreCheckedBeforeTheFileIsRead) {
  EXPECT_SAYS(refusal(""), "cad.path: is missing");
  EXPECT_SAYS(refusal("path: 'a.stp' face: -1"), "cad.face: is -1");
  EXPECT_SAYS(refusal("path: 'a.stp' scale: 0"), "cad.scale: is 0; must be positive");
  EXPECT_SAYS(refusal("path: 'a.stp' elements_v: 0"), "cad.elements_v: is 0; 1 to 4096");
  EXPECT_SAYS(refusal("path: 'a.stp' elements_u: 4096 elements_v: 4096"), "has 16777216 elements; at most");
  EXPECT_SAYS(refusal("path: 'a.stp' pose { orientation { w: 2 } }"), "cad.pose.orientation: has length 2");
}

#ifndef SUNDER_CAD

TEST_F(Cad, WithoutOpenCascadeTheBuildIsNamedAsTheRemedy) {
  EXPECT_SAYS(refusal("path: 'a.stp'"),
              "shells[0].cad: this build has no OpenCASCADE, which reads STEP and IGES; run `coupler/sunder build "
              "--cad`");
}

#else

constexpr double kRadius = 25.0, kLength = 40.0;  // [mm]

/// OpenCASCADE's writers speak too; the test's output is not theirs.
void hush() { Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream)); }

void write_step(const TopoDS_Shape& shape, const std::string& file, const char* unit = "MM") {
  hush();
  const STEPControl_Writer first;  // makes the table of settings
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;
  ASSERT_EQ(writer.Transfer(shape, STEPControl_AsIs), IFSelect_RetDone);
  ASSERT_EQ(writer.Write(file.c_str()), IFSelect_RetDone);
  Interface_Static::SetCVal("write.step.unit", "MM");
}

void write_iges(const TopoDS_Shape& shape, const std::string& file, const char* unit = "MM", int as_brep = 0) {
  hush();
  IGESControl_Writer writer(unit, as_brep);
  ASSERT_TRUE(writer.AddShape(shape));
  writer.ComputeModel();
  ASSERT_TRUE(writer.Write(file.c_str()));
}

TopoDS_Face on(const Handle(Geom_Surface) & surface, double u0, double u1, double v0, double v1) {
  return BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, 1e-7).Face();
}
TopoDS_Face whole(const Handle(Geom_Surface) & surface) { return BRepBuilderAPI_MakeFace(surface, 1e-7).Face(); }

TopoDS_Face sector(double degrees, bool reversed = false) {
  const double half = 0.5 * degrees * M_PI / 180.0;
  TopoDS_Face face = on(new Geom_CylindricalSurface(gp_Ax3(), kRadius), -half, half, 0, kLength);
  if (reversed) face.Reverse();
  return face;
}

TopoDS_Wire circle(double radius) {
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(), radius)));
}

// Degree, x in [mm], y over all, z: a sheet with the given columns of poles along u.
Handle(Geom_BSplineSurface)
    sheet(int degree, const std::vector<double>& x, const std::vector<double>& z, const std::vector<double>& knots,
          const std::vector<int>& multiplicities, double width = 30.0) {
  TColgp_Array2OfPnt poles(1, static_cast<int>(x.size()), 1, 2);
  for (int i = 0; i < static_cast<int>(x.size()); ++i)
    for (int j = 0; j < 2; ++j) poles(i + 1, j + 1) = gp_Pnt(x[i], j * width, z[i]);
  TColStd_Array1OfReal ku(1, static_cast<int>(knots.size())), kv(1, 2);
  TColStd_Array1OfInteger mu(1, static_cast<int>(knots.size())), mv(1, 2);
  for (std::size_t k = 0; k < knots.size(); ++k) ku(k + 1) = knots[k], mu(k + 1) = multiplicities[k];
  kv(1) = 0, kv(2) = 1, mv(1) = mv(2) = 2;
  return new Geom_BSplineSurface(poles, ku, kv, mu, mv, degree, 1);
}

template <class F>
void over(const Patch& p, F&& f) {
  for (double a = 0.0; a <= 1.0; a += 0.125)
    for (double b = 0.0; b <= 1.0; b += 0.25)
      f(p.evaluate({p.knots_u.begin() + a * (p.knots_u.end() - p.knots_u.begin()),
                    p.knots_v.begin() + b * (p.knots_v.end() - p.knots_v.begin())}));
}

// All points on the cylinder [m]; corners where a sector of `degrees` has them.
void expect_cylinder(const Patch& p, double degrees, double tolerance) {
  const double r = 1e-3 * kRadius, length = 1e-3 * kLength, half = 0.5 * degrees * M_PI / 180.0;
  Eigen::AlignedBox3d box;
  over(p, [&](const SurfacePoint& q) {
    EXPECT_NEAR(q.x.head<2>().norm(), r, tolerance * r);
    EXPECT_GT(q.u.cross(q.v).dot(Vec3(q.x.x(), q.x.y(), 0.0)), 0.0);  // outwards
    box.extend(q.x);
  });
  EXPECT_NEAR(box.min().z(), 0.0, tolerance * r);
  EXPECT_NEAR(box.max().z(), length, tolerance * r);
  EXPECT_NEAR(box.min().y(), -r * std::sin(half), tolerance * r);
  EXPECT_NEAR(box.max().y(), r * std::sin(half), tolerance * r);
  EXPECT_NEAR(box.min().x(), r * std::cos(half), tolerance * r);
}

TEST_F(Cad, ACylinderOfAStepFileIsExactInWhateverUnit) {
  for (const char* unit : {"MM", "M", "INCH"}) {
    write_step(sector(90), file("a.STEP"), unit);
    expect_cylinder(patch("path: 'a.STEP'"), 90, 1e-12);  // sixteen digits in the file, a few operations
  }
}

TEST_F(Cad, ACylinderOfAnIgesFileToItsDigits) {
  for (const char* unit : {"MM", "M"})
    for (const int as_brep : {0, 1}) {
      write_iges(sector(90), file("a.igs"), unit, as_brep);
      expect_cylinder(patch("path: 'a.igs'"), 90, 1e-6);  // IGES writes as many digits as its tolerance asks for
    }
}

TEST_F(Cad, APlaneIsARectangleWithTheNormalOfTheFace) {
  const TopoDS_Face plane = BRepBuilderAPI_MakeFace(gp_Pln(), -20, 30, 0, 10).Face();
  for (const bool reversed : {false, true}) {
    const TopoDS_Shape face = reversed ? plane.Reversed() : TopoDS_Shape(plane);
    write_step(face, file("a.stp"));
    const Patch p = patch("path: 'a.stp'");
    EXPECT_FALSE(p.rational());
    Eigen::AlignedBox3d box;
    over(p, [&](const SurfacePoint& q) {
      box.extend(q.x);
      EXPECT_GT((reversed ? -1.0 : 1.0) * q.u.cross(q.v).z(), 0.0);
    });
    EXPECT_LT((box.min() - Vec3(-0.02, 0, 0)).norm(), 1e-15);
    EXPECT_LT((box.max() - Vec3(0.03, 0.01, 0)).norm(), 1e-15);
  }
}

TEST_F(Cad, AReversedCylinderHasItsNormalInwards) {
  write_step(sector(90, true), file("a.stp"));
  over(patch("path: 'a.stp'"),
       [](const SurfacePoint& q) { EXPECT_LT(q.u.cross(q.v).dot(Vec3(q.x.x(), q.x.y(), 0.0)), 0.0); });
}

TEST_F(Cad, EachFaceOfABoxLooksOutwards) {
  const Vec3 size(0.01, 0.02, 0.03);
  write_step(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), file("a.stp"));
  write_iges(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), file("a.iges"), "MM", 1);
  for (const char* name : {"a.stp", "a.iges"}) {
    Vec3 normals = Vec3::Zero(), squares = Vec3::Zero();
    for (int face = 0; face < 6; ++face) {
      const SurfacePoint q =
          patch(fmt::format("path: '{}' face: {} elements_u: 3 elements_v: 2", name, face)).evaluate({1e-3, 1e-3});
      const Vec3 n = q.u.cross(q.v).normalized();
      EXPECT_NEAR(n.dot(q.x - 0.5 * size), 0.5 * size.dot(n.cwiseAbs()), 1e-9) << name << " face " << face;
      normals += n, squares += n.cwiseAbs2();
    }
    EXPECT_LT(normals.norm(), 1e-12);
    EXPECT_LT((squares - Vec3(2, 2, 2)).norm(), 1e-12);  // all six
  }
}

TEST_F(Cad, ScaleElementsAndPoseComeAfterTheFile) {
  gp_Trsf moved;
  moved.SetTranslation(gp_Vec(0, 0, 5));  // a location in the file
  write_step(sector(90).Moved(TopLoc_Location(moved)), file("a.stp"));
  const Patch p =
      patch("path: 'a.stp' scale: 2 elements_u: 3 elements_v: 4 pose { position { x: 1 } orientation { w: 0 x: 1 } }");
  EXPECT_EQ(p.knots_u.spans(), 3);
  EXPECT_EQ(p.knots_v.spans(), 4);
  const double r = 2e-3 * kRadius;
  over(p, [&](const SurfacePoint& q) {
    EXPECT_NEAR((q.x - Vec3(1, 0, 0)).head<2>().norm(), r, 1e-12);
    EXPECT_GE(-q.x.z(), 2e-3 * 5.0 - 1e-12);  // turned by half a turn about x
    EXPECT_LE(-q.x.z(), 2e-3 * (5.0 + kLength) + 1e-12);
  });
}

TEST_F(Cad, APieceOfASphereUpToThePole) {
  write_step(on(new Geom_SphericalSurface(gp_Ax3(), kRadius), 0.2, 1.2, 0.3, 0.5 * M_PI), file("a.stp"));
  over(patch("path: 'a.stp'"), [](const SurfacePoint& q) { EXPECT_NEAR(q.x.norm(), 1e-3 * kRadius, 1e-14); });
}

TEST_F(Cad, PartOfASplineAlongItsParametersIsTaken) {
  // z = x^2 / 100 [mm] over three spans, and a part of it that ends on no knot
  const auto arch = sheet(2, {0, 10, 30, 50, 60}, {0, 0, 8, 24, 36}, {0, 1, 2, 3}, {3, 1, 1, 3});
  write_step(on(arch, 0.5, 3, 0, 0.5), file("a.stp"));
  const Patch p = patch("path: 'a.stp'");
  EXPECT_EQ(p.knots_u.spans(), 3);
  double first = 1.0;
  over(p, [&](const SurfacePoint& q) {
    EXPECT_NEAR(q.x.z(), 10.0 * q.x.x() * q.x.x(), 1e-15);  // in metres
    EXPECT_LE(q.x.y(), 0.015 + 1e-15);
    first = std::min(first, q.x.x());
  });
  EXPECT_NEAR(first, 0.01, 1e-15);
}

TEST_F(Cad, NeedlessKnotsGoAndCreasesAreRefused) {
  write_step(whole(sheet(1, {0, 20, 40, 60}, {0, 10, 20, 30}, {0, 1, 2, 3}, {2, 1, 1, 2})), file("flat.stp"));
  const Patch p = patch("path: 'flat.stp'");
  EXPECT_EQ(p.knots_u.spans(), 3);
  over(p, [](const SurfacePoint& q) { EXPECT_NEAR(q.x.z(), 0.5 * q.x.x(), 1e-15); });
  write_step(whole(sheet(1, {0, 20, 40}, {0, 10, 0}, {0, 1, 2}, {2, 1, 2})), file("fold.stp"));
  EXPECT_SAYS(refusal("path: 'fold.stp'"), "face 0 has a crease");
  EXPECT_SAYS(refusal("path: 'fold.stp'"), "across u at 0.5 of its range");
  write_step(sector(200), file("wide.stp"));
  EXPECT_SAYS(refusal("path: 'wide.stp'"), "an arc of 150 degrees or more");
}

TEST_F(Cad, KnotsThatAreNotOpenAreMadeOpen) {
  const auto even = sheet(2, {-5, 5, 15, 25}, {0, 0, 0, 0}, {0, 1, 2, 3, 4, 5, 6}, {1, 1, 1, 1, 1, 1, 1});
  write_step(whole(even), file("a.stp"));
  Eigen::AlignedBox3d box;
  over(patch("path: 'a.stp'"), [&](const SurfacePoint& q) { box.extend(q.x); });
  EXPECT_LT((box.max() - Vec3(0.02, 0.03, 0)).norm(), 1e-15);
  EXPECT_LT(box.min().norm(), 1e-15);
}

// A cubic along u, a straight line along v: both are cubic then, and the points are the file's.
TEST_F(Cad, CubicFacesAreTakenAsTheyAre) {
  const Handle(Geom_BSplineSurface) cubic = sheet(3, {0, 5, 11, 15, 20}, {0, 3, -2, 1, 0}, {0, 0.4, 1}, {4, 1, 4});
  write_step(whole(cubic), file("cubic.stp"));
  const Patch p = patch("path: 'cubic.stp' elements_u: 6 elements_v: 4");
  EXPECT_EQ(p.degree(), 3);
  EXPECT_GE(p.knots_u.spans(), 6);
  for (double a = 0.05; a < 1.0; a += 0.1)
    for (double b = 0.1; b < 1.0; b += 0.2) {
      const gp_Pnt q = cubic->Value(a, b);
      const auto at = [](const KnotVector& k, double share) { return k.begin() + share * (k.end() - k.begin()); };
      const Vec3 x = p.evaluate({at(p.knots_u, a), at(p.knots_v, b)}).x;
      EXPECT_LT((x - 1e-3 * Vec3(q.X(), q.Y(), q.Z())).norm(), 1e-14);  // of 0.03 m: round-off
    }
}

// Degree 2 along u with three spans, 3 along v with two: raised to 3 along u, and the points are the file's.
TEST_F(Cad, FacesOfTwoDegreesAreRaisedToTheHigherOne) {
  for (const bool rational : {false, true}) {
    TColgp_Array2OfPnt poles(1, 5, 1, 5);
    TColStd_Array2OfReal weights(1, 5, 1, 5);
    for (int i = 1; i <= 5; ++i)
      for (int j = 1; j <= 5; ++j) {
        poles(i, j) = gp_Pnt(10.0 * i, 8.0 * j, ((i * 7 + j * 3) % 5) * 1.5);
        weights(i, j) = rational ? 1.0 + 0.1 * ((i + 2 * j) % 4) : 1.0;
      }
    TColStd_Array1OfReal ku(1, 4), kv(1, 3);
    TColStd_Array1OfInteger mu(1, 4), mv(1, 3);
    ku(1) = 0, ku(2) = 1, ku(3) = 2, ku(4) = 3, mu(1) = mu(4) = 3, mu(2) = mu(3) = 1;
    kv(1) = 0, kv(2) = 0.4, kv(3) = 1, mv(1) = mv(3) = 4, mv(2) = 1;
    const Handle(Geom_BSplineSurface) mixed = new Geom_BSplineSurface(poles, weights, ku, kv, mu, mv, 2, 3);
    write_step(whole(mixed), file("mixed.stp"));
    const Patch p = patch("path: 'mixed.stp'");
    EXPECT_EQ(p.degree(), 3);
    for (double a = 0.05; a < 1.0; a += 0.1)
      for (double b = 0.1; b < 1.0; b += 0.2) {
        const gp_Pnt q = mixed->Value(3.0 * a, b);
        const auto at = [](const KnotVector& k, double share) { return k.begin() + share * (k.end() - k.begin()); };
        const Vec3 x = p.evaluate({at(p.knots_u, a), at(p.knots_v, b)}).x;
        EXPECT_LT((x - 1e-3 * Vec3(q.X(), q.Y(), q.Z())).norm(), 1e-14) << a << " " << b;  // of 0.06 m: round-off
      }
  }
}

TEST_F(Cad, WhatIsNoPatchIsRefused) {
  write_step(whole(sheet(5, {0, 1, 2, 3, 4, 5}, {0, 0, 1, 1, 0, 0}, {0, 1}, {6, 6})), file("quintic.stp"));
  EXPECT_SAYS(refusal("path: 'quintic.stp'"), "face 0 has degree 5 along u and 1 along v; at most 3 can be used");
  write_step(sector(360), file("tube.stp"));
  EXPECT_SAYS(refusal("path: 'tube.stp'"), "closes on itself along u");
  write_step(BRepBuilderAPI_MakeFace(gp_Pln(), circle(10)).Face(), file("disc.stp"));
  // the corners of the square around a circle of 10 mm are 7.07 mm from its sides in x or y, of a size of 28.3 mm
  EXPECT_SAYS(refusal("path: 'disc.stp'"),
              "face 0 is trimmed: its border leaves the parameter lines by up to 0.0029 m");
  BRepBuilderAPI_MakeFace holed(BRepBuilderAPI_MakeFace(gp_Pln(), -20, 20, -20, 20).Face());
  holed.Add(TopoDS::Wire(circle(10).Reversed()));
  write_step(holed.Face(), file("holed.stp"));
  EXPECT_SAYS(refusal("path: 'holed.stp'"), "face 0 has a hole, the first one at (0, 0, 0) m, 0.02 m wide");
  // what the message advises: the face without its hole, and a closed cut in its place
  write_step(BRepBuilderAPI_MakeFace(gp_Pln(), -20, 20, -20, 20).Face(), file("whole.stp"));
  EXPECT_EQ(refusal("path: 'whole.stp' elements_u: 20 elements_v: 20 } cuts { circle { center { u: 0.02 v: 0.02 } "
                    "radius_m: 0.01 } } velocity { "),
            "accepted");
  BRepBuilderAPI_MakePolygon corner(gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0), gp_Pnt(10, 9.9, 0), gp_Pnt(0, 10, 0), true);
  for (const char* name : {"slanted.stp", "slanted.igs"}) {
    const TopoDS_Face face = BRepBuilderAPI_MakeFace(gp_Pln(), corner.Wire()).Face();
    std::string(name).ends_with("stp") ? write_step(face, file(name)) : write_iges(face, file(name));
    EXPECT_SAYS(refusal(fmt::format("path: '{}'", name)), "face 0 is trimmed: its border leaves");
  }
}

TEST_F(Cad, AFaceIsChosenWhereThereAreSeveral) {
  write_step(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), file("a.stp"));
  EXPECT_SAYS(refusal("path: 'a.stp'"), "'a.stp' has 6 faces; choose one with `face`: 0 at (0, 0.01, 0.015) m, 1 at");
  EXPECT_SAYS(refusal("path: 'a.stp'"), "5 at (");
  TopoDS_Compound boxes;
  BRep_Builder build;
  build.MakeCompound(boxes);
  for (int k = 0; k < 9; ++k) build.Add(boxes, BRepPrimAPI_MakeBox(gp_Pnt(20.0 * k, 0, 0), 10, 20, 30).Shape());
  write_step(boxes, file("boxes.stp"));
  EXPECT_SAYS(refusal("path: 'boxes.stp'"), "has 54 faces");
  EXPECT_SAYS(refusal("path: 'boxes.stp'"), ", 53 at (0.165, 0.01, 0.03) m");
  EXPECT_SAYS(refusal("path: 'a.stp' face: 6"), "cad.face: is 6, but 'a.stp' has 6 faces, counted from 0");
  write_step(sector(90), file("b.stp"));
  EXPECT_SAYS(refusal("path: 'b.stp' face: 1"), "is 1, but 'b.stp' has one face");
}

TEST_F(Cad, FilesThatCannotBeReadAreRefusedWithoutAWordOfTheLibrary) {
  write_step(sector(90), file("whole.stp"));
  write_iges(sector(90), file("whole.igs"));
  write_step(BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(), 3)).Edge(), file("curve.stp"));
  const auto half = [&](const char* from, const char* to) {
    std::ifstream in(file(from));
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::ofstream(file(to)) << text.substr(0, text.size() / 2);
  };
  half("whole.stp", "half.stp"), half("whole.igs", "half.igs");
  std::ifstream in(file("whole.stp"));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = text.find("CARTESIAN_POINT");  // one point becomes a direction
  std::ofstream(file("damaged.stp")) << text.replace(at, std::strlen("CARTESIAN_POINT"), "DIRECTION");
  for (const char* name : {"empty.stp", "empty.igs"}) std::ofstream(file(name)).close();
  for (const char* name : {"noise.stp", "noise.igs"}) std::ofstream(file(name)) << "no such thing\n\x01\x02 (((;;;'\n";
  Message::DefaultMessenger()->AddPrinter(new Message_PrinterOStream());  // as it is before hush()
  testing::internal::CaptureStdout();
  EXPECT_EQ(refusal("path: 'whole.stp'"), "accepted");
  EXPECT_EQ(refusal("path: 'whole.igs'"), "accepted");
  EXPECT_SAYS(refusal("path: 'none.stp'"), "'none.stp' cannot be read; is the name right?");
  EXPECT_SAYS(refusal("path: '../none.stp'"), "outside the scene's folder");
  EXPECT_SAYS(refusal("path: 'scene.textproto'"), "neither STEP (.step, .stp) nor IGES (.igs, .iges)");
  EXPECT_SAYS(refusal("path: 'damaged.stp'"), "'damaged.stp' is damaged: ");
  EXPECT_SAYS(refusal("path: 'curve.stp'"), "'curve.stp' has no face");
  for (const char* name : {"empty.stp", "noise.stp", "half.stp"})
    EXPECT_SAYS(refusal(fmt::format("path: '{}'", name)), "is no STEP file that can be read");
  for (const char* name : {"empty.igs", "noise.igs", "half.igs"})
    EXPECT_SAYS(refusal(fmt::format("path: '{}'", name)), "ends without the T line of an IGES file");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

#endif

}  // namespace
