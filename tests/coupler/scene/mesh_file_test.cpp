// Formats of mesh files, and hulls of many corners.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "coupler/scene/mesh.h"
#include "tests/coupler/arch.h"
#include "tests/coupler/small_scene.h"

using namespace small_scene;
using sunder::Vec3;
using namespace sunder::scene;

namespace {

std::string scene_with(const std::string& file, const std::string& text, const std::string& more = "surface: EXACT") {
  std::ofstream(own_file(file), std::ios::binary) << text;
  std::string scene =
      replaced("sphere { radius_m: 0.02 }", fmt::format("mesh {{ path: \"{}_{}\" {} }}", getpid(), file, more));
  return scene.replace(scene.find("z: 0.1"), 6, "z: 9.0");  // far from the pane
}

sunder::RigidBody body_of(const std::string& text) {
  const std::string path = own_file("mesh_file_test.textproto");
  std::ofstream(path) << text;
  return sunder::shell::build(load(path, {})).bodies[0];
}

void expect_arch(const std::string& file, const std::string& text, double tolerance = 1e-12) {
  SCOPED_TRACE(file + ":\n" + text.substr(0, 60));
  const double mass = 2500.0 * arch::kVolume;
  EXPECT_NEAR(body_of(scene_with(file, text)).mass, mass, tolerance * mass);
}

void expect_refused(const std::string& file, const std::string& text, const std::vector<std::string>& says) {
  expect_refusal(scene_with(file, text), "bodies[0].mesh.path", says);
}

std::string replaced_in(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

sunder::Surface surface_of(const arch::Mesh& m) {
  std::vector<Polygon> polygons;
  for (const auto& face : m.faces) polygons.push_back({face, 0});
  return closed_surface(m.points, polygons);
}

template <class T>
std::string bytes(T value, bool big_endian = false) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big_endian) std::reverse(raw.begin(), raw.end());
  return {raw.begin(), raw.end()};
}

// With a property before the coordinates, one behind them, a list behind the corners and an element of edges.
std::string ply(const arch::Mesh& m, const std::string& format) {
  const bool text = format == "ascii", big = format == "binary_big_endian";
  std::string out = fmt::format(
      "ply\nformat {} 1.0\ncomment made by hand\nelement vertex {}\nproperty uchar red\nproperty float x\n"
      "property double y\nproperty float32 z\nproperty short layer\nelement face {}\n"
      "property list uchar int vertex_indices\nproperty list uint8 float32 uv\nelement edge 1\nproperty int vertex1\n"
      "end_header\n",
      format, m.points.size(), m.faces.size());
  for (const Vec3& p : m.points)
    out += text ? fmt::format("255 {} {} {} -3\n", p.x(), p.y(), p.z())
                : bytes<std::uint8_t>(255) + bytes(static_cast<float>(p.x()), big) + bytes(p.y(), big) +
                      bytes(static_cast<float>(p.z()), big) + bytes<std::int16_t>(-3, big);
  for (const auto& face : m.faces) {
    out += text ? fmt::format("{}", face.size()) : bytes(static_cast<std::uint8_t>(face.size()));
    for (const int c : face) out += text ? fmt::format(" {}", c) : bytes<std::int32_t>(c, big);
    out += text ? " 1 0.5\n" : bytes<std::uint8_t>(1) + bytes(0.5f, big);
  }
  return out + (text ? "7\n" : bytes<std::int32_t>(7, big));
}

std::string stl_text(const arch::Mesh& m) {
  const auto [points, triangles] = surface_of(m);
  std::string out = "solid arch\n";
  for (const auto& t : triangles) {
    out += "facet normal 0 0 0\n outer loop\n";
    for (const int c : t) out += fmt::format("  vertex {} {} {}\n", points[c].x(), points[c].y(), points[c].z());
    out += " endloop\nendfacet\n";
  }
  return out + "endsolid arch\n";
}

std::string stl_binary(const arch::Mesh& m) {
  const auto [points, triangles] = surface_of(m);
  std::string out = "solid, as some programs begin a binary file too";
  out.resize(80, ' ');
  out += bytes(static_cast<std::uint32_t>(triangles.size()));
  for (const auto& t : triangles) {
    out += std::string(12, '\0');
    for (const int c : t)
      for (int d = 0; d < 3; ++d) out += bytes(static_cast<float>(points[c][d]));
    out += std::string(2, '\0');
  }
  return out;
}

/// Points of an ellipsoid with these half axes, all of them corners of its hull.
std::string ellipsoid(int n, const Vec3& axes) {
  std::string out = fmt::format("OFF {} 0 0\n", n);
  for (int k = 0; k < n; ++k) {
    const double z = -1.0 + (k + 0.5) * 2.0 / n, r = std::sqrt(1.0 - z * z), a = 2.399963229728653 * k;
    out += fmt::format("{} {} {}\n", axes.x() * r * std::cos(a), axes.y() * r * std::sin(a), axes.z() * z);
  }
  return out;
}

constexpr double kFloat = 1e-6;  // coordinates in single precision: 6e-8 each

TEST(MeshFile, OffHeaderMayStandOnOneLineWithItsCounts) {
  const std::string good = arch::off(arch::mesh()), rest = good.substr(good.find("16 10 0") + 7);
  for (const std::string header :
       {"OFF\n16 10 0", "OFF 16 10 0", "OFF16 10 0", "OFF 16 10 0 # counts", "  OFF\t16 10 0", "COFF\n16 10 0",
        "NOFF 16 10 0", "OFF\r\n16 10 0\r", "# first\nOFF 16 10"})
    expect_arch("header.off", header + rest);
  for (const std::string header : {"16 10 0", "ROFF 16 10 0", "OFF -16 10 0", "OFF 16", "OFF 99999999 10 0", "OFF"})
    expect_refused("header.off", header + rest, {"does not start as an OFF file does"});
}

TEST(MeshFile, ObjLinesAreContinuedByABackslash) {
  const std::string good = arch::obj(arch::mesh());
  std::string broken;
  for (std::size_t i = 0; i < good.size(); ++i) broken += good[i] == ' ' && i % 3 == 0 ? " \\\n " : good.substr(i, 1);
  ASSERT_NE(broken.find("f \\\n"), std::string::npos);
  expect_arch("broken.obj", broken);
  expect_arch("broken.obj", replaced_in(broken, "\n", "\r\n"));
  expect_arch("comment.obj", "# saved in C:\\\n" + good);  // a comment goes to the end of its line
  expect_refused("broken.obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 1 \\\n\\\n0\nf 1 \\\n2 7\n",
                 {"line 7: '7' is none of the 3"});
}

TEST(MeshFile, SolidsOfObjFilesReadNoTextureCoordinates) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt none\n";
  EXPECT_NEAR(body_of(scene_with("bare.obj", points, "surface: HULL")).mass, 2500.0 / 6.0, 1e-9);
  EXPECT_NEAR(body_of(scene_with("bare.obj", points + "f 1/9 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")).mass, 2500.0 / 6.0,
              1e-9);
}

TEST(MeshFile, PlyIsReadAsTextAndInBothOrdersOfBytes) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    expect_arch("arch.ply", ply(arch::mesh(), format), kFloat);
  const std::string text = ply(arch::mesh(), "ascii"), binary = ply(arch::mesh(), "binary_little_endian");
  expect_refused("bad.ply", binary.substr(0, binary.size() - 60), {"ends, or has no number, in face "});
  expect_refused("bad.ply", text.substr(0, text.find("255 ") + 12), {"ends, or has no number, in vertex "});
  expect_refused("bad.ply", replaced_in(text, "element vertex", "element point"), {"has no element 'vertex'"});
  expect_refused("bad.ply", replaced_in(text, "property float x", "property float u"), {"vertex 0: (nan, 0, 0)"});
  expect_refused("bad.ply", replaced_in(text, "float32 z", "quad z"), {"type 'quad'"});
  expect_refused("bad.ply", replaced_in(text, "format ascii", "format utf8"), {"does not start as a PLY file does"});
  expect_refused("bad.ply", replaced_in(text, " 15 1 0.5", " 1.5 1 0.5"), {": it names point 1.5"});
  expect_refused("bad.ply", replaced_in(text, "element face 10", "element face 9"), {"is not closed", "number 1"});
  expect_refused("bad.ply", replaced_in(text, "property short layer", "property list short int layer"),
                 {"vertex 0: it has a list of -3 numbers"});
  expect_refused("bad.ply", replaced_in(text, "end_header", "element nothing 99999999999999\nend_header"),
                 {"has an element 'nothing' without a property"});
}

TEST(MeshFile, StlIsReadAsTextAndAsBinary) {
  const std::string text = stl_text(arch::mesh()), binary = stl_binary(arch::mesh());
  expect_arch("arch.stl", text);
  expect_arch("arch.STL", binary, kFloat);
  expect_refused("bad.stl", binary.substr(0, binary.size() - 1), {"is no STL file", "is the copy whole?"});
  expect_refused("bad.stl", "", {"is no STL file"});
  expect_refused("bad.stl", replaced_in(text, "endsolid", ""), {"without the word endsolid"});
  expect_refused("bad.stl", replaced_in(text, "endloop\nendfacet\nfacet", "facet"),
                 {"line 7: the facet before it has no endfacet"});
  expect_refused("bad.stl", replaced_in(text, "endloop", "vertex 1 2 3"), {"line 8: the facet has 4 corners"});
  expect_refused("bad.stl", replaced_in(text, "vertex 0 ", "vertex nil "), {"line 4: '  vertex nil"});
  std::string open = binary.substr(0, binary.size() - 50);
  open[80] = static_cast<char>(open[80] - 1);
  expect_refused("bad.stl", open, {"is not closed", "of the face of number "});
  std::string no_number = binary;  // a corner of the third triangle, which others have named before
  no_number.replace(84 + 2 * 50 + 12, 4, bytes(std::nanf("")));
  expect_refused("bad.stl", no_number, {"triangle 3: (nan, ", "is no point of three numbers"});
}

TEST(MeshFile, OtherFormatsAreRefusedWithThoseThatAreRead) {
  expect_refused("arch.3ds", "3DS",
                 {"ends in '.3ds'; files that end in .off, .obj, .ply, .stl, .glb or .gltf are read"});
  expect_refused("arch", arch::obj(arch::mesh()), {".off, .obj, .ply, .stl, .glb or .gltf"});
}

TEST(MeshFile, HullOfManyCornersKeepsItsMassAndGivesTheEngineFewer) {
  for (const Vec3& axes : {Vec3(1, 1, 1), Vec3(0.05, 2, 0.3)})
    for (const std::string more : {"", "surface: HULL scale: 0.5"}) {
      const std::string scene = scene_with("ball.off", ellipsoid(671, axes), more);
      const double scale = more.empty() ? 1.0 : 0.5, whole = 4.0 / 3.0 * M_PI * axes.prod() * std::pow(scale, 3);
      const sunder::RigidBody b = body_of(scene);
      const auto& shape = std::get<sunder::ConvexShape>(b.shape);
      EXPECT_NEAR(b.mass, 2500 * whole, 0.02 * 2500 * whole);  // 671 corners hold 99 % of the ellipsoid
      ASSERT_EQ(shape.parts.size(), 1u);
      EXPECT_EQ(shape.parts[0].size(), static_cast<std::size_t>(kMostHullCorners));
      const double volume = hull_of(shape.parts[0]).volume;
      EXPECT_LT(volume, b.mass / 2500);
      EXPECT_GT(volume, (1.0 - kMostLost) * b.mass / 2500);
      ASSERT_TRUE(shape.surface);
      EXPECT_EQ(shape.surface->corners.size(), 671u);  // which the shell meets
      for (const Vec3& p : shape.parts[0])
        EXPECT_NE(std::find(shape.surface->corners.begin(), shape.surface->corners.end(), p),
                  shape.surface->corners.end());
    }
}

TEST(MeshFile, HullIsRefusedWhereTooFewCornersHoldItsVolume) {
  std::vector<Vec3> ball;
  for (int k = 0; k < 671; ++k) {
    const double z = -1.0 + (k + 0.5) * 2.0 / 671, r = std::sqrt(1.0 - z * z), a = 2.399963229728653 * k;
    ball.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  const sunder::Surface whole = sunder::convex_surface(ball);
  EXPECT_GT(simplified_hull(whole).volume, (1.0 - kMostLost) * sunder::enclosed_volume(whole));
  EXPECT_EQ(simplified_hull(whole, 700).corners.size(), 671u);
  try {
    simplified_hull(whole, 30);
    FAIL() << "though 30 corners hold less than nine tenths of a ball";
  } catch (const sunder::Error& e) {
    EXPECT_NE(std::string(e.what()).find("of 671 corners, and 30 of them hold"), std::string::npos) << e.what();
  }
}

// The solid of many corners, which is refused nowhere on the way that the messages name.
TEST(MeshFile, ExactSolidMayHaveAPartOfManyCorners) {
  std::vector<std::array<double, 2>> outline;
  for (int k = 0; k < 200; ++k) outline.push_back({0.1 * std::sin(M_PI * k / 100), 0.1 * std::cos(M_PI * k / 100)});
  const arch::Mesh coin = arch::prism(outline, 0.02);
  const sunder::RigidBody b = body_of(scene_with("coin.off", arch::off(coin)));
  EXPECT_NEAR(b.mass, 2500 * 0.02 * 100 * 0.01 * std::sin(M_PI / 100), 1e-9);
  const auto& parts = std::get<sunder::ConvexShape>(b.shape).parts;
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_LE(parts[0].size(), static_cast<std::size_t>(kMostHullCorners));
}

}  // namespace
