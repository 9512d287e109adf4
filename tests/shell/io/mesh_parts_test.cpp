// Shells of mesh files, from the file to the model.
#include "shell/io/mesh_parts.h"

#include <fstream>

#include <gtest/gtest.h>

#include "shell/io/build.h"
#include "shell/io/inspect_mesh.h"
#include "tests/shell/triangles.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class MeshParts : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path + "/" + name) << text;
  }
  void write(const std::string& name, const Triangles& t) const {
    std::ofstream out(folder.path + "/" + name);
    for (const Vec3& x : t.points) out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", x.x(), x.y(), x.z());
    for (const FileTriangle& f : t.faces)
      out << fmt::format("f {} {} {}\n", f.corners[0] + 1, f.corners[1] + 1, f.corners[2] + 1);
  }
  RunSetup setup(const std::string& mesh, const std::string& in_shell = "", const std::string& after = "",
                 const std::string& in_material = "") const {
    write("scene.textproto", R"(name: "mesh"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 )" +
                                 in_material + R"( }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.01
  mesh { )" + mesh + " }\n" + in_shell +
                                 "}\n" + after);
    return build(scene::load(folder.path + "/scene.textproto", {}));
  }
  template <class... Args>
  std::string refusal(Args&&... args) const {
    try {
      setup(std::forward<Args>(args)...);
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      return e.what();
    }
    return "accepted";
  }
  static void expect_part(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  static double area(const RunSetup& r) {
    double sum = 0.0;
    for (const ShellSetup& s : r.shells)
      for (const double part : s.model.mass) sum += part / (s.model.material.density * s.model.thickness);
    return sum;
  }

  TemporaryFolder folder;
};

Triangles sheet() {
  return lattice(12, 10, false, [](double u, double v) { return Vec3(u, 0.8 * v, 0.0); });
}

const char* kSquare = "OFF\n4 1 0\n0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n";

TEST_F(MeshParts, APlateIsOneShellWithTheNameOfTheScene) {
  write("a.obj", sheet());
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
  Triangles t = sheet();
  const Triangles other = sheet();
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
  write("a.glb", "glTF");
  expect_part(refusal("path: 'a.glb' element_m: 0.2"), "files that end in .off, .obj, .ply or .stl are read");
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
  expect_part(refusal(mesh, "supports { edges: ALL kind: CLAMPED }"),
              "shells[0].supports: is for a shell of one patch, and the mesh becomes 2 shells, pane.1 to pane.2");
  expect_part(refusal(mesh, "loads { point { at { u: 0 v: 0 } force { z: 1 } } }"), "shells[0].loads[0]");
  expect_part(refusal(mesh, "cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } }"), "shells[0].cuts");
  EXPECT_EQ(refusal(mesh, "", "", "strength: 1e8 fracture_energy: 10"), "accepted");  // cracks run over their borders
  EXPECT_EQ(refusal(mesh, "loads { pressure: 1 }"), "accepted");
}

TEST_F(MeshParts, InspectTellsChartsAndWhatIsRefused) {
  write("a.obj", ball(0.5, 8));
  const std::string told = inspect_mesh_report(folder.path + "/a.obj", {0.08});
  for (const char* part :
       {"\"components\": 1", "\"borders\": 0", "\"shell\": \"part.2\"", "\"smooth\": 1", "\"refused\": null"})
    expect_part(told, part);
  expect_part(inspect_mesh_report(folder.path + "/a.obj", {1e-5}), "\"refused\": \"element_m is 1e-05 m");
  EXPECT_TRUE(is_mesh_file("x/Y.STL"));
  EXPECT_FALSE(is_mesh_file("x/y.step"));
}

}  // namespace
