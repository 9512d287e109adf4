// Shells from STEP and IGES files; the files are written here. Without OpenCASCADE: what is said then.
#include <cstring>
#include <fstream>

#include "shell/geometry/edges.h"
#include "tests/shell/io/cad_fixture.h"

#ifdef SUNDER_CAD
#include <BRepPrimAPI_MakeBox.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Message.hxx>
#include <Message_PrinterOStream.hxx>
#include <TopoDS.hxx>
#include <gp_Pln.hxx>
#endif

using namespace sunder;
using namespace sunder::shell;

namespace {

TEST_F(Cad, NumbersAreCheckedBeforeTheFileIsRead) {
  EXPECT_SAYS(refusal(""), "cad.path: is missing");
  EXPECT_SAYS(refusal("path: 'a.stp' face: -1"), "cad.face: is -1");
  EXPECT_SAYS(refusal("path: 'a.stp' scale: 0"), "cad.scale: is 0; must be positive");
  EXPECT_SAYS(refusal("path: 'a.stp' elements_v: 0"), "cad.elements_v: is 0; 1 to 4096");
  EXPECT_SAYS(refusal("path: 'a.stp' elements_u: 4096 elements_v: 4096"), "has 16777216 elements; at most");
  EXPECT_SAYS(refusal("path: 'a.stp' element_m: 0"), "cad.element_m: is 0; must be positive");
  EXPECT_SAYS(refusal("path: 'a.stp' element_m: 1 elements_u: 2"), "cad.element_m: is given, and so are elements_u");
  EXPECT_SAYS(refusal("path: 'a.stp' fill_holes_m: -1"), "cad.fill_holes_m: is -1");
  EXPECT_SAYS(refusal("path: 'a.stp' face: 1 faces: 2"), "cad.faces: are given, and so is face");
  EXPECT_SAYS(refusal("path: 'a.stp' faces: 2 faces: -1"), "cad.faces[1]: is -1; faces are counted from 0");
  EXPECT_SAYS(refusal("path: 'a.stp' faces: 2 faces: 2"), "cad.faces[1]: is 2, as faces[0] is");
  EXPECT_SAYS(refusal("path: 'a.stp' pose { orientation { w: 2 } }"), "cad.pose.orientation: has length 2");
}

#ifndef SUNDER_CAD

TEST_F(Cad, WithoutOpenCascadeTheBuildIsNamedAsTheRemedy) {
  EXPECT_SAYS(refusal("path: 'a.stp'"),
              "shells[0].cad: this build has no OpenCASCADE, which reads STEP and IGES; `coupler/sunder` of a "
              "checkout builds with it where SUNDER_BUILD_DIR is unset");
}

#else

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

// Takes the unit of length out of a file of write_step or write_iges.
void forget_unit(const std::string& file) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (file.ends_with(".stp")) {
    std::size_t at = text.find("GLOBAL_UNIT_ASSIGNED_CONTEXT");
    ASSERT_NE(at, std::string::npos);
    at = text.find("(#", at) + 1;
    text.erase(at, text.find(',', at) + 1 - at);  // the first of the units
  } else {
    const std::string said = ",2,2HMM,", left = ",,,";
    const std::size_t at = text.find(said);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, said.size(), left);
    text.insert(text.find('G', at), said.size() - left.size(), ' ');  // the letter is in column 73
  }
  std::ofstream(file) << text;
}

TEST_F(Cad, AFileWithoutAUnitNeedsOne) {
  write_step(sector(90), file("a.stp")), write_iges(sector(90), file("a.igs"));
  for (const char* name : {"a.stp", "a.igs"}) {
    EXPECT_SAYS(refusal(fmt::format("path: '{}' unit_m: 0.001", name)),
                fmt::format("cad.unit_m: is 0.001 m, and '{}' says its unit, ", name));
    forget_unit(file(name));
    EXPECT_SAYS(
        refusal(fmt::format("path: '{}'", name)),
        fmt::format("cad.unit_m: is missing, and '{}' says no unit of length; give 0.001 for millimetres", name));
    expect_cylinder(patch(fmt::format("path: '{}' unit_m: 0.001", name)), 90, 1e-6);
    expect_cylinder(patch(fmt::format("path: '{}' unit_m: 0.0254 scale: {:.17g}", name, 1.0 / 25.4)), 90, 1e-6);
    Eigen::AlignedBox3d box;
    for (const Vec3& x : patch(fmt::format("path: '{}' unit_m: 1", name)).control_points) box.extend(x);
    EXPECT_NEAR(box.sizes().z(), kLength, 1e-4);
  }
  EXPECT_SAYS(refusal("path: 'a.stp' unit_m: 0"), "cad.unit_m: is 0");
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

TEST_F(Cad, NeedlessKnotsGoAndCreasesDivideAFace) {
  write_step(whole(sheet(1, {0, 20, 40, 60}, {0, 10, 20, 30}, {0, 1, 2, 3}, {2, 1, 1, 2})), file("flat.stp"));
  const Patch p = patch("path: 'flat.stp'");
  EXPECT_EQ(p.knots_u.spans(), 3);
  over(p, [](const SurfacePoint& q) { EXPECT_NEAR(q.x.z(), 0.5 * q.x.x(), 1e-15); });
  write_step(whole(sheet(1, {0, 20, 40}, {0, 10, 0}, {0, 1, 2}, {2, 1, 2})), file("fold.stp"));
  const RunSetup folded = setup("path: 'fold.stp' elements_u: 4 elements_v: 4");
  ASSERT_EQ(folded.shells.size(), 2u);
  ASSERT_EQ(folded.stitches.seams.size(), 1u);
  EXPECT_NEAR(folded.stitches.seams[0].angle, 2.0 * std::atan(0.5), 1e-9);
  write_step(sector(200), file("wide.stp"));
  const RunSetup wide = setup("path: 'wide.stp' elements_u: 4 elements_v: 4");
  ASSERT_EQ(wide.shells.size(), 2u);
  ASSERT_EQ(wide.stitches.seams.size(), 1u);
  EXPECT_TRUE(wide.stitches.seams[0].smooth);
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

TEST_F(Cad, FacesOfAHigherDegreeAreApproximated) {
  const Handle(Geom_BSplineSurface) quintic = sheet(5, {0, 10, 20, 30, 40, 50}, {0, 0, 20, -20, 10, 0}, {0, 1}, {6, 6});
  write_step(whole(quintic), file("quintic.stp"));
  const CadSurface read = surface("path: 'quintic.stp' elements_u: 8 elements_v: 8");
  EXPECT_EQ(read.patch.degree(), 3);
  EXPECT_GT(read.error, 0.0);
  EXPECT_LE(read.error, 1e-5 * 0.06);  // of the size that the README states
  double most = 0.0;
  for (double a = 0.0; a <= 1.0; a += 0.05) {
    const gp_Pnt q = quintic->Value(a, 0.4);
    double nearest = 1.0;
    for (double b = 0.0; b <= 1.0; b += 1e-4)
      nearest = std::min(nearest, (read.patch.evaluate(edge_point(read.patch, kVMin, b)).x + 0.4 * Vec3(0, 0.03, 0) -
                                   1e-3 * Vec3(q.X(), q.Y(), q.Z()))
                                      .norm());
    most = std::max(most, nearest);
  }
  EXPECT_LE(most, 5e-6);  // between places that are 5e-6 m apart
}

TEST_F(Cad, AFaceOfAHigherDegreeIsDividedAtItsCrease) {
  write_step(whole(sheet(4, {0, 10, 20, 30, 40, 50, 60, 70, 80}, {0, 0, 0, 0, 30, 0, 0, 0, 0}, {0, 0.5, 1}, {5, 4, 5})),
             file("crease.stp"));
  const RunSetup folded = setup("path: 'crease.stp' elements_u: 8 elements_v: 8");
  ASSERT_EQ(folded.shells.size(), 2u);
  ASSERT_EQ(folded.stitches.seams.size(), 1u);
  EXPECT_NEAR(folded.stitches.seams[0].angle, 2.0 * std::atan(3.0), 1e-6);
}

// Folds that are finer than the pieces of an approximation.
TEST_F(Cad, AFaceOfAHigherDegreeThatNoSplineFollowsIsRefused) {
  std::vector<double> x, z, knots;
  std::vector<int> multiplicities;
  for (int i = 0; i < 304; ++i) x.push_back(i), z.push_back(i % 2 ? 10.0 : -10.0);
  for (int k = 0; k <= 300; ++k) knots.push_back(k), multiplicities.push_back(k % 300 ? 1 : 5);
  write_step(whole(sheet(4, x, z, knots, multiplicities)), file("pleats.stp"));
  const std::string said = refusal("path: 'pleats.stp' elements_u: 8 elements_v: 8");
  EXPECT_SAYS(said, "has degree 4 along u and 1 along v; no spline of degree 3 is within");
  EXPECT_SAYS(said, "m of it: rebuild the surface in the CAD program");
}

TEST_F(Cad, AFaceIsChosenWhereThereAreSeveral) {
  write_step(BRepPrimAPI_MakeBox(10, 20, 30).Shape(), file("a.stp"));
  EXPECT_SAYS(refusal("path: 'a.stp' face: 6"), "cad.face: is 6, but 'a.stp' has 6 faces, counted from 0");
  EXPECT_SAYS(refusal("path: 'a.stp' faces: 1 faces: 6"), "cad.faces[1]: is 6, but 'a.stp' has 6 faces");
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
