// Shells of mesh files, from the file to the model.
#include "shell/io/mesh_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "shell/io/check.h"
#include "shell/solver/parting/pieces.h"
#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class MeshParts : public MeshScene {};

Triangles lattice_sheet() {
  return lattice(12, 10, false, [](double u, double v) { return Vec3(u, 0.8 * v, 0.0); });
}

const char* kSquare = "OFF\n4 1 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n";

TEST_F(MeshParts, APlateIsOneShellWithTheNameOfTheScene) {
  write("a.obj", lattice_sheet());
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1", "supports { edges: U_MIN kind: CLAMPED }");
  ASSERT_EQ(r.shells.size(), 1u);
  EXPECT_EQ(r.shells[0].model.name, "pane");
  EXPECT_TRUE(r.shells[0].model.trim.empty());
  EXPECT_NEAR(area(r), 0.8, 1e-9);
}

TEST_F(MeshParts, AllFormatsGiveTheSameShell) {
  write("a.off", kSquare);
  write("a.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n");
  write("a.ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n");
  write("a.stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 1 0\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 1 0\nvertex 0 1 0\nendloop\nendfacet\n"
        "endsolid a\n");
  for (const char* end : {"off", "obj", "ply", "stl"}) {
    const RunSetup r = setup(fmt::format("path: 'a.{}' element_m: 0.2", end));
    ASSERT_EQ(r.shells.size(), 1u);
    EXPECT_EQ(r.shells[0].model.control_points(), 12 * 7);
    EXPECT_NEAR(area(r), 2.0, 1e-9);
  }
}

// A lattice with texture coordinates (0.3 + 0.5 x, 0.9 - 0.7 y), every second face turned over, and counted back from
// the last one in the other half.
std::string textured(double without_beyond) {
  const Triangles t = lattice_sheet();
  std::string out;
  for (const Vec3& x : t.points)
    out += fmt::format("v {:.17g} {:.17g} 0\nvt {:.17g} {:.17g}\n", x.x(), x.y(), 0.3 + 0.5 * x.x(), 0.9 - 0.7 * x.y());
  const int points = static_cast<int>(t.points.size());
  for (std::size_t k = 0; k < t.faces.size(); ++k) {
    auto c = t.faces[k].corners;
    if (k % 2 == 0) std::swap(c[1], c[2]);
    const bool has = t.points[c[0]].x() <= without_beyond;
    const auto corner = [&](int i) {
      const std::string vt = has ? fmt::format("{}", k % 2 == 0 ? c[i] + 1 : c[i] - points) : "";
      return fmt::format("{}/{}/", c[i] + 1, vt);
    };
    out += fmt::format("f {} {} {}\n", corner(0), corner(1), corner(2));
  }
  return out;
}

TEST_F(MeshParts, TextureCoordinatesOfAnObjFileAreThoseOfFrames) {
  write("a.obj", textured(1e9));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1 pose { position { z: 2 } }");
  ASSERT_EQ(r.shells.size(), 1u);
  const ShellModel& m = r.shells[0].model;
  const double u = m.patch.knots_u.end(), v = m.patch.knots_v.end();
  for (const Vec2& share : {Vec2(0, 0), Vec2(1, 1), Vec2(0.37, 0.61), Vec2(0.93, 0.02)}) {
    const Vec2 p(share.x() * u, share.y() * v);
    const Vec3 x = m.patch.evaluate(p).x;
    EXPECT_LT((drawn_parameter(m, p) - Vec2(0.3 + 0.5 * x.x(), 0.9 - 0.7 * x.y())).norm(), 1e-9) << share.transpose();
  }
}

// A lattice whose colours are linear in x and y; the last point has none where `whole` is false.
std::string tinted(bool whole) {
  const Triangles t = lattice_sheet();
  std::string out;
  for (std::size_t k = 0; k < t.points.size(); ++k) {
    const Vec3& x = t.points[k];
    out += fmt::format("v {:.17g} {:.17g} 0", x.x(), x.y());
    if (whole || k + 1 < t.points.size())
      out += fmt::format(" {:.17g} {:.17g} {:.17g}", 0.2 + 0.5 * x.x(), 0.9 - 0.7 * x.y(), 0.1 * x.x() + 0.2 * x.y());
    out += "\n";
  }
  for (const FileTriangle& f : t.faces)
    out += fmt::format("f {} {} {}\n", f.corners[0] + 1, f.corners[1] + 1, f.corners[2] + 1);
  return out;
}

TEST_F(MeshParts, ColoursOfPointsAreThoseOfFrames) {
  write("a.obj", tinted(true));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1 pose { position { z: 2 } }");
  ASSERT_EQ(r.shells.size(), 1u);
  const ShellModel& m = r.shells[0].model;
  const double u = m.patch.knots_u.end(), v = m.patch.knots_v.end();
  for (const Vec2& share : {Vec2(0, 0), Vec2(1, 1), Vec2(0.37, 0.61), Vec2(0.93, 0.02)}) {
    const Vec2 p(share.x() * u, share.y() * v);
    const Vec3 x = m.patch.evaluate(p).x;
    const Vec3 wanted(0.2 + 0.5 * x.x(), 0.9 - 0.7 * x.y(), 0.1 * x.x() + 0.2 * x.y());
    EXPECT_LT((drawn_colour(m, p) - wanted).norm(), 1e-9) << share.transpose();  // as the fit of a flat chart
  }
}

TEST_F(MeshParts, AChartWithAPointWithoutAColourIsWhite) {
  write("a.obj", tinted(false));
  const ShellModel m = setup("path: 'a.obj' element_m: 0.1").shells[0].model;
  EXPECT_FALSE(m.colour);
  EXPECT_EQ(drawn_colour(m, Vec2(0.1, 0.1)), Vec3(1, 1, 1));
}

TEST_F(MeshParts, AChartWithAFaceWithoutTextureCoordinatesHasParameters) {
  write("a.obj", textured(0.9));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  const ShellModel& m = r.shells[0].model;
  const Vec2 whole(m.patch.knots_u.end(), m.patch.knots_v.end());
  EXPECT_LT((drawn_parameter(m, 0.25 * whole) - Vec2(0.25, 0.25)).norm(), 1e-12);
}

TEST_F(MeshParts, TextureCoordinatesThatAreNotThereAreRefusedWithTheirLine) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n";
  for (const char* corner : {"3/3", "3/-3", "3/0", "3/3/1"}) {
    write("b.obj", points + "f 1/1 2/2 " + corner + "\n");
    const std::string told = refusal("path: 'b.obj' element_m: 0.2");
    expect_part(told, "line 6");
    expect_part(told, "none of the 2 vt before it");
  }
  write("b.obj", points + "vt none\nf 1/1 2/2 3/1\n");
  const std::string told = refusal("path: 'b.obj' element_m: 0.2");
  expect_part(told, "line 6");
  expect_part(told, "'vt none' is no texture coordinate of one to three numbers; export the file again, or without");
  write("b.obj", points + "f 1/1 2/2 3/2\n");
  EXPECT_EQ(setup("path: 'b.obj' element_m: 0.2").shells.size(), 1u);
}

TEST_F(MeshParts, UnitUpAndPoseMoveTheSurface) {
  write("a.off", kSquare);
  const RunSetup r = setup("path: 'a.off' element_m: 0.2 unit_m: 0.5 up: Y pose { position { z: 3 } }");
  EXPECT_NEAR(area(r), 0.5, 1e-9);
  Eigen::AlignedBox3d box;
  for (const Vec3& x : r.shells[0].model.patch.control_points) box.extend(x);
  EXPECT_LT((box.min() - Vec3(0, 0, 3)).norm(), 1e-9);
  EXPECT_LT((box.max() - Vec3(1, 0, 3.5)).norm(), 1e-9);
}

TEST_F(MeshParts, ASphereIsTwoShellsThatATieJoins) {
  write("a.obj", ball(0.5, 8));
  const RunSetup r = setup("path: 'a.obj' element_m: 0.08");
  ASSERT_EQ(r.shells.size(), 2u);
  EXPECT_EQ(r.shells[0].model.name, "pane.1");
  EXPECT_EQ(r.shells[1].model.name, "pane.2");
  EXPECT_EQ(r.shells[0].model.contact_group, r.shells[1].model.contact_group);
  ASSERT_EQ(r.stitches.seams.size(), 1u);
  EXPECT_TRUE(r.stitches.seams[0].smooth);
  EXPECT_TRUE(r.stitches.seams[0].closed);
  EXPECT_NEAR(area(r) / M_PI, 1.0, 2e-3);
}

TEST_F(MeshParts, SidesOfABoxAreStitchedAlongWholeEdges) {
  write("a.off",
        "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n"
        "4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
  const RunSetup r = setup("path: 'a.off' element_m: 0.2");
  ASSERT_EQ(r.shells.size(), 6u);
  ASSERT_EQ(r.stitches.seams.size(), 12u);
  for (const Seam& s : r.stitches.seams) {
    EXPECT_FALSE(s.trimmed());
    EXPECT_NEAR(s.angle, 0.5 * M_PI, 1e-6);
  }
  EXPECT_NEAR(area(r), 6.0, 1e-9);
}

TEST_F(MeshParts, ComponentsAreShellsOfTheirOwn) {
  Triangles t = lattice_sheet();
  const Triangles other = lattice_sheet();
  for (const FileTriangle& f : other.faces)
    t.add(f.corners[0] + static_cast<int>(other.points.size()), f.corners[1] + static_cast<int>(other.points.size()),
          f.corners[2] + static_cast<int>(other.points.size()));
  for (const Vec3& x : other.points) t.points.push_back(x + Vec3(0, 0, 1));
  write("a.obj", t);
  const RunSetup r = setup("path: 'a.obj' element_m: 0.1");
  EXPECT_EQ(r.shells.size(), 2u);
  EXPECT_TRUE(r.stitches.seams.empty());
}

TEST_F(MeshParts, FilesThatAreNoSurfaceAreRefusedWithTheirLine) {
  write("a.off", kSquare);
  expect_part(refusal("path: 'a.glb' element_m: 0.2"), "a.glb");
  write("a.3ds", "3DS");
  expect_part(refusal("path: 'a.3ds' element_m: 0.2"),
              "files that end in .off, .obj, .ply, .stl, .glb or .gltf are read");
  write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  expect_part(refusal("path: 'b.obj' element_m: 0.2"), "'b.obj' has points and no faces");
  write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  expect_part(refusal("path: 'b.obj' element_m: 0.2"), "line 4");
  write("b.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n");
  expect_part(refusal("path: 'b.obj' element_m: 0.2"),
              "'b.obj' line 6: the face at (0, 0, 0) has no area, the first of 1; leave them out");
  write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  expect_part(refusal("path: 'b.obj' element_m: 0.2"), "has 1 edges of three faces or more");
  const std::string whole = kSquare;
  for (std::size_t n = 0; n + 2 < whole.size(); n += 3) {  // a file that ends too soon
    write("c.off", whole.substr(0, n));
    EXPECT_NE(refusal("path: 'c.off' element_m: 0.2"), "accepted") << n;
  }
}

TEST_F(MeshParts, TooManyTrianglesAreRefusedWithARemedy) {
  std::string many = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int k = 0; k <= 300000; ++k) many += "f 1 2 3\n";
  write("many.obj", many);
  expect_part(
      refusal("path: 'many.obj' element_m: 0.2"),
      "'many.obj' has more than 300000 triangles; reduce it, for example by the modifier Decimate of Blender or by "
      "Quadric Edge Collapse Decimation of MeshLab: shells lose what is finer than element_m");
}

// A sheet of 708 x 708 points, as scans have: a million faces.
TEST_F(MeshParts, AMillionFacesAreRefusedInEveryFormat) {
  constexpr int kSide = 708, kFaces = 2 * (kSide - 1) * (kSide - 1);
  std::string points, faces, stl(80, ' ');
  const auto number = [&stl](auto value) { stl.append(reinterpret_cast<const char*>(&value), sizeof value); };
  number(static_cast<std::uint32_t>(kFaces));
  for (int k = 0; k < kSide * kSide; ++k) points += fmt::format("{} {} 0\n", k % kSide, k / kSide);
  for (int j = 0; j + 1 < kSide; ++j)
    for (int i = 0; i + 1 < kSide; ++i)
      for (const int up : {0, 1}) {
        const std::array<int, 3> x = {i, i + 1, i + 1 - up}, y = {j, j + up, j + 1};
        faces += "3";
        for (int k = 0; k < 3; ++k) faces += fmt::format(" {}", y[k] * kSide + x[k]);
        faces += "\n";
        for (int k = -1; k < 3; ++k)
          for (const float v : {k < 0 ? 0.0f : float(x[k]), k < 0 ? 0.0f : float(y[k]), k < 0 ? 1.0f : 0.0f}) number(v);
        number(std::uint16_t{0});
      }
  write("a.off", fmt::format("OFF\n{} {} 0\n{}{}", kSide * kSide, kFaces, points, faces));
  write("a.ply", fmt::format("ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
                             "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
                             "end_header\n{}{}",
                             kSide * kSide, kFaces, points, faces));
  write("a.stl", stl);
  for (const char* end : {"off", "ply", "stl"})
    expect_part(refusal(fmt::format("path: 'a.{}' element_m: 0.2", end)),
                fmt::format("'a.{}' has more than 300000 triangles; reduce it", end));
}

// One face of six corners: a chart that is trimmed along its border.
TEST_F(MeshParts, AHexagonIsOneShell) {
  const double h = 0.5 * std::sqrt(3.0);
  const std::string corners =
      fmt::format("1 0 0\n0.5 {0:.17g} 0\n-0.5 {0:.17g} 0\n-1 0 0\n-0.5 -{0:.17g} 0\n0.5 -{0:.17g} 0\n", h);
  write("a.off", "OFF\n6 1 0\n" + corners + "6 0 1 2 3 4 5\n");
  const RunSetup r = setup("path: 'a.off' element_m: 0.1");
  ASSERT_EQ(r.shells.size(), 1u);
  EXPECT_EQ(r.shells[0].model.name, "pane");
  EXPECT_FALSE(r.shells[0].model.trim.empty());
  EXPECT_TRUE(r.stitches.seams.empty());
  EXPECT_NEAR(area(r) / (3.0 * h), 1.0, 0.01);
  for (const char* crossed : {"6 0 2 1 3 4 5", "6 0 1 2 3 5 4", "6 0 3 1 2 4 5"}) {
    write("a.off", "OFF\n6 1 0\n" + corners + crossed + "\n");
    expect_part(refusal("path: 'a.off' element_m: 0.1"),
                "'a.off' line 9: the face of 6 corners crosses or touches itself; divide it into triangles");
  }
}

TEST_F(MeshParts, ElementsThatDoNotFitAreRefused) {
  write("a.off", kSquare);
  expect_part(refusal("path: 'a.off'"), "shells[0].mesh.element_m");
  expect_part(refusal("path: 'a.off' element_m: 1e-4"), "at most 1e+06: give a longer one");
  expect_part(refusal("path: 'a.off' element_m: 1.5"), "give one below 1 m");
  expect_part(refusal("path: 'a.off' element_m: 0.1 weld_m: 0.2"), "weld less than an element");
  expect_part(refusal("path: 'a.off' element_m: 0.1 crease_deg: 1"), "mesh.crease_deg: is 1; 5 to 180");
  expect_part(refusal("path: 'a.off' element_m: 0.1 degree: 4"), "mesh.degree: is 4; 2 (quadratic) or 3 (cubic)");
  expect_part(refusal("path: 'a.off' element_m: 0.1 unit_m: 0"), "mesh.unit_m");
  expect_part(refusal("element_m: 0.1"), "mesh.path: is missing");
}

TEST_F(MeshParts, WhatIsForOnePatchIsRefusedForSeveral) {
  write("a.obj", ball(0.5, 8));
  const std::string mesh = "path: 'a.obj' element_m: 0.08";
  expect_part(
      refusal(mesh, "supports { edges: ALL kind: CLAMPED }"),
      "shells[0].supports[0]: is for a shell of one patch, and the mesh becomes 2 shells, pane.1 to pane.2; give "
      "boxes");
  expect_part(refusal(mesh, "loads { point { at { u: 0 v: 0 } force { z: 1 } } }"), "shells[0].loads[0]");
  expect_part(refusal(mesh, "cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } }"),
              "shells[0].cuts[0]: is for a shell of one patch");
  EXPECT_EQ(refusal(mesh, "", "", "strength: 1e8 fracture_energy: 10"), "accepted");  // cracks run over their borders
  EXPECT_EQ(refusal(mesh, "loads { pressure: 1 }"), "accepted");
}

// Two plates beside each other, each with a group and a material.
std::string two_groups() {
  return "o both\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
         "g left outer\nusemtl Red\nf 1 2 5 4\ng right outer\nusemtl Blue\nf 2 3 6 5\n";
}

TEST_F(MeshParts, GroupsHaveAThicknessAndAMaterialOfTheirOwn) {
  write("a.obj", two_groups());
  const std::string after = "materials { name: 'steel' density: 8000 youngs_modulus: 2e11 poisson_ratio: 0.3 }\n";
  for (const char* name : {"group: 'right'", "usemtl: 'Blue'"}) {
    const RunSetup r =
        setup(fmt::format("path: 'a.obj' element_m: 0.2 parts {{ {} material: 'steel' thickness_m: 0.02 }}", name), "",
              after);
    ASSERT_EQ(r.shells.size(), 2u);
    EXPECT_EQ(r.shells[0].model.name, "pane.1");
    double mass[2] = {};
    for (const int k : {0, 1})
      for (const double part : r.shells[k].model.mass) mass[k] += part;
    EXPECT_NEAR(mass[0] / (2500 * 0.01), 1.0, 1e-6);
    EXPECT_NEAR(mass[1] / (8000 * 0.02), 1.0, 1e-6);
    EXPECT_EQ(r.shells[1].model.material.youngs_modulus, 2e11);
    EXPECT_EQ(r.shells[0].model.contact_group, r.shells[1].model.contact_group);
    ASSERT_EQ(r.stitches.seams.size(), 1u);  // flat, so it bends as one surface
    EXPECT_TRUE(r.stitches.seams[0].smooth);
  }
  EXPECT_EQ(setup("path: 'a.obj' element_m: 0.2").shells.size(), 1u);
  EXPECT_EQ(setup("path: 'a.obj' element_m: 0.2 parts { group: 'both' thickness_m: 0.02 }").shells.size(), 1u);
}

TEST_F(MeshParts, PartsThatAreWrongAreRefused) {
  write("a.obj", two_groups());
  const auto told = [&](const std::string& part) {
    return refusal("path: 'a.obj' element_m: 0.2 parts { " + part + " }");
  };
  expect_part(told("group: 'rigth' thickness_m: 0.02"),
              "shells[0].mesh.parts[0].group: is 'rigth', which is no group of 'a.obj'; did you mean 'right'? It has: "
              "left, outer, both, right");
  expect_part(told("usemtl: 'Glass' thickness_m: 0.02"),
              "parts[0].usemtl: is 'Glass', which is no usemtl of 'a.obj'; it has: Red, Blue");
  expect_part(told("thickness_m: 0.02"), "parts[0]: names neither a group nor a usemtl of the file; name one of them");
  expect_part(told("group: 'left' usemtl: 'Red' thickness_m: 0.02"), "names a group and a usemtl");
  expect_part(told("group: 'left'"), "parts[0]: has neither a material nor a thickness_m of its own");
  expect_part(told("group: 'left' thickness_m: -1"), "parts[0].thickness_m: is -1; must be positive");
  expect_part(told("group: 'left' material: 'glas'"), "parts[0].material: 'glas' is no material of this scene");
  expect_part(told("group: 'left' thickness_m: 0.02 } parts { group: 'left' thickness_m: 0.03"),
              "parts[1]: is for the same faces as parts[0]");
  expect_part(told("group: 'left' thickness_m: 0.02 } parts { group: 'outer' thickness_m: 0.03"),
              "parts[1]: names the face of line 10 of 'a.obj', which parts[0] names too");
  expect_part(refusal("path: 'a.obj' element_m: 0.2 parts { group: 'left' thickness_m: 0.02 }", "",
                      "materials { name: 'm' density: 1 }\n"),
              "accepted");
  expect_part(refusal("path: 'a.obj' element_m: 0.2 parts { group: 'left' material: 'm' }", "",
                      "materials { name: 'm' density: 1 }\n"),
              "parts[0].material: 'm' has no youngs_modulus or poisson_ratio");
  write("a.off", kSquare);
  expect_part(refusal("path: 'a.off' element_m: 0.2 parts { group: 'left' thickness_m: 0.02 }"),
              "parts[0].group: is 'left', and no face of 'a.off' has a group; export an OBJ file with groups");
  write("b.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nusemtl Red\nf 1 2 3 4\n");
  expect_part(refusal("path: 'b.obj' element_m: 0.2 parts { group: 'left' thickness_m: 0.02 }"), "name a usemtl");
}

std::string painted(const std::string& colours) {
  return "v 0 0 0 " + colours + "\nv 2 0 0 1 0.5 0\nv 2 1 0 1 0.5 0\nv 0 1 0 0 0.5 0\nf 1 2 3 4\n";
}

TEST_F(MeshParts, ColoursAreStrength) {
  const std::string strong = "strength: 1e8 fracture_energy: 10";
  write("a.obj", painted("0 0.5 0"));
  write("a.ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 127 0\n2 0 0 255 127 0\n2 1 0 255 127 0\n0 1 0 0 127 0\n4 0 1 2 3\n");
  for (const char* end : {"obj", "ply"}) {
    const RunSetup r = setup(
        fmt::format("path: 'a.{}' element_m: 0.2 strength_paint {{ channel: RED low_factor: 0.2 high_factor: 1.2 }}",
                    end),
        "", "", strong);
    ASSERT_EQ(r.shells.size(), 1u);
    const ShellModel& m = r.shells[0].model;
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) {
        const double x = m.patch.evaluate(gauss_point(m.patch, m.tables, q, e).parameter).x.x();
        EXPECT_NEAR(m.strength_factor_at(q, e), 0.2 + 0.5 * x, 1e-6);
      }
  }
  const RunSetup r =
      setup("path: 'a.obj' element_m: 0.2 strength_paint { channel: GREEN low_factor: 0.2 }", "", "", strong);
  EXPECT_NEAR(r.shells[0].model.strength_factor_at(0, 0), 0.6, 1e-6);
}

TEST_F(MeshParts, PaintThatIsWrongIsRefused) {
  const std::string strong = "strength: 1e8 fracture_energy: 10", mesh = "path: 'a.obj' element_m: 0.2 strength_paint ";
  const auto told = [&](const std::string& paint) { return refusal(mesh + paint, "", "", strong); };
  write("a.obj", painted("0 0.5 0"));
  EXPECT_EQ(told("{ channel: RED low_factor: 0.5 }"), "accepted");
  expect_part(told("{ low_factor: 0.5 }"),
              "shells[0].mesh.strength_paint.channel: is missing; RED, GREEN, BLUE or GREY");
  expect_part(told("{ channel: RED }"), "strength_paint.low_factor: is missing");
  expect_part(told("{ channel: RED low_factor: 0 }"), "strength_paint.low_factor: is 0");
  expect_part(told("{ channel: RED low_factor: 1 high_factor: 1e9 }"), "strength_paint.high_factor: is 1000000000");
  expect_part(refusal(mesh + "{ channel: RED low_factor: 0.5 }"),
              "strength_paint: scales the strength, which material 'glass' has not");
  write("a.obj", painted("0 2 0"));
  expect_part(told("{ channel: RED low_factor: 0.5 }"), "point 1 of 'a.obj', counted from 1, has the colour (0, 2, 0)");
  write("a.obj", painted(""));
  expect_part(told("{ channel: RED low_factor: 0.5 }"), "point 1 of 'a.obj', counted from 1, has no colour");
  write("a.obj", lattice_sheet());
  expect_part(told("{ channel: RED low_factor: 0.5 }"),
              "points of 'a.obj' have no colours; export a PLY, OBJ or glTF file");
}

TEST_F(MeshParts, AMeshWhoseUnitMayBeForgottenHasAWarning) {
  write("a.off", "OFF\n4 1 0\n0 0 0\n12 0 0\n12 6 0\n0 6 0\n4 0 1 2 3\n");
  const auto told = [&](const std::string& mesh) {
    const RunSetup r = setup(mesh);
    return check_report(scene::load(folder.path + "/scene.textproto", {}), r);
  };
  expect_part(told("path: 'a.off' element_m: 0.5"),
              "warning        'a.off' is taken in metres, 12 m long, as no unit_m is "
              "given; give 0.001 for millimetres, or 1\n");
  for (const char* unit : {"1", "0.1"})
    EXPECT_EQ(told(fmt::format("path: 'a.off' element_m: {} unit_m: {}", unit == std::string("1") ? 0.5 : 0.05, unit))
                  .find("is taken in metres"),
              std::string::npos);
  EXPECT_EQ(unit_warning("a", 0.001, "unit_m"), "");
  EXPECT_EQ(unit_warning("a", 10.0, "unit_m"), "");
  expect_part(unit_warning("a", 0.0009, "unit_m"), "'a' is taken in metres, 0.0009 m long");
}

// Two squares with a corner in common; along the edge from it a gap opens up to 0.1 mm.
TEST_F(MeshParts, AMeshThatTouchesItselfInAPointHasAWarningAndWeldingMendsIt) {
  write("a.off", "OFF\n7 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n2 1 0\n1.0001 1 0\n4 0 1 2 3\n4 1 4 5 6\n");
  const auto told = [&](const std::string& weld, std::ptrdiff_t warnings) {
    const RunSetup r = setup("path: 'a.off' element_m: 0.1 unit_m: 1 " + weld);
    const auto of_points = [](const std::string& warning) {
      return warning.find("touches itself") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(r.touching.begin(), r.touching.end(), of_points), warnings);
    return check_report(scene::load(folder.path + "/scene.textproto", {}), r);
  };
  expect_part(told("", 1),
              "warning        shell 'pane': the surface of 'a.off' touches itself in 1 point, the first at (1, 0, 0) m "
              "before its pose, and bears no load from one sheet to the other there");
  EXPECT_EQ(told("weld_m: 1e-3", 0).find("touches itself"), std::string::npos);
}

}  // namespace
