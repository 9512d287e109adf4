// Meshes with surface EXACT: mass and inertia, division into convex parts, refusals.
#include <algorithm>
#include <filesystem>
#include <random>

#include "coupler/scene/mesh.h"
#include "tests/coupler/arch.h"
#include "tests/coupler/small_scene.h"

using namespace small_scene;
using sunder::Vec3;
using namespace sunder::scene;

namespace {

// The scene with a mesh of this text instead of the ball.
std::string scene_with_solid(const std::string& file, const std::string& text,
                             const std::string& more = "surface: EXACT") {
  std::ofstream(own_file(file)) << text;
  return replaced("sphere { radius_m: 0.02 }", fmt::format("mesh {{ path: \"{}_{}\" {} }}", getpid(), file, more));
}

sunder::RigidBody solid_of(const std::string& text) {
  const std::string path = own_file("solid_test.textproto");
  std::ofstream(path) << text;
  return sunder::shell::build(load(path, {})).bodies[0];
}

sunder::Surface closed_of(const arch::Mesh& m) {
  std::vector<Polygon> polygons;
  for (const auto& face : m.faces) polygons.push_back({face, 0});
  return closed_surface(m.points, polygons);
}

void expect_mesh_refused(const arch::Mesh& m, const std::vector<std::string>& says) {
  expect_refusal(scene_with_solid("bad.off", arch::off(m)), "bodies[0].mesh.path", says);
}

double volume_of(const std::vector<std::vector<Vec3>>& parts) {
  double sum = 0.0;
  for (const auto& part : parts) sum += hull_of(part).volume;
  return sum;
}

TEST(SolidMesh, HasMassCentreAndInertiaOfTheBlockWithoutItsGap) {
  // the outer box less the gap, about the middle of the block, then moved to the common centre
  using namespace arch;
  const double outside = 2500 * kWide * kDeep * kHigh, gap = 2500 * (kRight - kLeft) * kDeep * kGapHigh;
  const double mass = outside - gap, centre = (outside * kHigh - gap * kGapHigh) / 2.0 / mass;
  const auto box = [](double m, const Vec3& size, double up) {  // about a point `up` below its centre
    const Vec3 s = size.cwiseProduct(size);
    return Vec3(m / 12.0 * (s.y() + s.z()) + m * up * up, m / 12.0 * (s.x() + s.z()) + m * up * up,
                m / 12.0 * (s.x() + s.y()));
  };
  Vec3 inertia = box(outside, {kWide, kDeep, kHigh}, kHigh / 2 - centre) -
                 box(gap, {kRight - kLeft, kDeep, kGapHigh}, kGapHigh / 2 - centre);
  std::sort(inertia.begin(), inertia.end());
  const std::string off = scene_with_solid("arch.off", arch::off(mesh())),
                    obj = scene_with_solid("arch.obj", arch::obj(mesh()));
  for (const std::string& text : {off, obj}) {
    const sunder::RigidBody b = solid_of(text);
    EXPECT_NEAR(b.mass, mass, 1e-13 * mass);  // round-off of sums over tetrahedra
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(b.principal_inertia[d], inertia[d], 1e-12 * inertia[d]);
    EXPECT_NEAR((b.motion.position - Vec3(kWide / 2, kDeep / 2, 0.1 + centre)).norm(), 0.0, 1e-14);
    const auto& shape = std::get<sunder::ConvexShape>(b.shape);
    EXPECT_EQ(shape.parts.size(), 3u);
    ASSERT_TRUE(shape.surface);
    EXPECT_EQ(shape.surface->corners.size(), 16u);
    EXPECT_EQ(shape.surface->triangles.size(), 2u * 6u + 8u * 2u);
  }
}

TEST(SolidMesh, IsDividedIntoConvexPartsThatFillIt) {
  std::mt19937 random(1);
  const arch::Mesh arch = arch::mesh();
  std::vector<std::array<double, 2>> star;
  for (int i = 0; i < 16; ++i) {
    const double r = i % 2 ? 0.4 : 1.0, angle = -2.0 * M_PI * i / 16;
    star.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  arch::Mesh turned = arch;  // no face along an axis: coordinates have round-off
  for (Vec3& p : turned.points) p = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * p;
  for (const auto& [m, most] : {std::pair{arch, 3u}, std::pair{turned, 3u}, std::pair{arch::prism(star, 0.3), 9u}}) {
    const sunder::Surface s = closed_of(m);
    const auto parts = convex_parts(s);
    EXPECT_LE(parts.size(), most);
    EXPECT_NEAR(volume_of(parts), enclosed_volume(s), 1e-9 * enclosed_volume(s));  // merged parts may add this share
    Eigen::AlignedBox3d box;
    for (const Vec3& p : s.corners) box.extend(p);
    for (int k = 0; k < 300; ++k) {  // a point in the solid is in a part: adding it does not change that part's hull
      Vec3 x;
      for (int d = 0; d < 3; ++d) x[d] = std::uniform_real_distribution(box.min()[d], box.max()[d])(random);
      const double inside = winding_number(s, x);
      EXPECT_LT(std::min(std::abs(inside), std::abs(inside - 1.0)), 1e-9);
      const bool in_a_part = std::any_of(parts.begin(), parts.end(), [&](std::vector<Vec3> part) {
        const double before = hull_of(part).volume;
        part.push_back(x);
        return hull_of(part).volume < before * (1.0 + 1e-9);
      });
      EXPECT_EQ(in_a_part, inside > 0.5) << x.transpose();
    }
  }
}

TEST(SolidMesh, IsTurnedOutwardsForAnyOrientationOfItsFaces) {
  arch::Mesh inside_out = arch::mesh(), mixed = arch::mesh();
  for (auto& face : inside_out.faces) std::reverse(face.begin(), face.end());
  for (std::size_t i = 0; i < mixed.faces.size(); i += 3) std::reverse(mixed.faces[i].begin(), mixed.faces[i].end());
  for (const arch::Mesh& m : {arch::mesh(), inside_out, mixed})
    EXPECT_NEAR(enclosed_volume(closed_of(m)), arch::kVolume, 1e-15);
}

TEST(SolidMesh, InsideAnotherOneIsAHollow) {
  const auto cube = [](double low, double high) {
    arch::Mesh m = arch::prism({{low, low}, {low, high}, {high, high}, {high, low}}, high - low);
    for (Vec3& p : m.points) p.y() += low;
    return m;
  };
  arch::Mesh shell = cube(0.0, 3.0);
  const arch::Mesh hollow = cube(1.0, 2.0);  // its faces point outwards in the file
  shell.points.insert(shell.points.end(), hollow.points.begin(), hollow.points.end());
  for (auto face : hollow.faces) {
    for (int& c : face) c += 8;
    shell.faces.push_back(face);
  }
  const sunder::Surface s = closed_of(shell);
  EXPECT_NEAR(enclosed_volume(s), 26.0, 1e-12);
  EXPECT_NEAR(volume_of(convex_parts(s)), 26.0, 1e-7);
  EXPECT_NEAR(winding_number(s, {1.5, 1.5, 1.5}), 0.0, 1e-12);
}

TEST(SolidMesh, IsRefusedWhereItIsNotClosed) {
  arch::Mesh m = arch::mesh();
  m.faces.pop_back();
  expect_mesh_refused(m, {"is not closed: 4 of its edges", "line ", "close it, or take surface HULL"});
  m = arch::mesh();
  m.points.push_back(m.points[0] + Vec3(1e-9, 0, 0));  // a corner that almost coincides
  m.faces[2][0] = 16;
  expect_mesh_refused(m, {"is not closed"});
  m.faces.clear();
  expect_mesh_refused(m, {"points and no faces"});
}

TEST(SolidMesh, IsRefusedWhereItCrossesOrTouchesItself) {
  const auto two = [](const Vec3& by) {  // arches in one file
    arch::Mesh m = arch::mesh();
    const arch::Mesh other = m;
    for (const Vec3& p : other.points) m.points.push_back(p + by);
    for (auto face : other.faces) {
      for (int& c : face) c += 16;
      m.faces.push_back(face);
    }
    return m;
  };
  expect_mesh_refused(two({0.005, 0.005, 0.005}), {"crosses itself: the faces of lines "});
  expect_mesh_refused(two({arch::kWide, arch::kDeep, 0.0}), {"has an edge of 4 faces"});
  expect_mesh_refused(two({arch::kWide, arch::kDeep, arch::kHigh}), {"touches itself in the point (0.06, 0.03, 0.05)"});
  EXPECT_NEAR(enclosed_volume(closed_of(two({1.0, 0.0, 0.0}))), 2.0 * arch::kVolume, 1e-12);  // separate: one body
}

TEST(SolidMesh, IsRefusedWithTheLineOfAWrongFace) {
  const std::string good = arch::off(arch::mesh());
  const auto off = [&](const std::string& from, const std::string& to, const std::vector<std::string>& says) {
    std::string text = good;
    const auto at = text.rfind(from);
    ASSERT_NE(at, std::string::npos) << from;
    expect_refusal(scene_with_solid("bad.off", text.replace(at, from.size(), to)), "bodies[0].mesh.path", says);
  };
  // 3 lines of header, an empty one, 16 points and 10 faces: the last face is on line 30
  off("4 7 0 8 15", "4 7 0 8 16", {"line 30: the face names point 16, and there are 16"});
  off("4 7 0 8 15", "4 7 0 8", {"line 30: '4 7 0 8' is no face"});
  off("4 7 0 8 15", "2 7 0", {"line 30: '2 7 0' is no face"});
  off("4 7 0 8 15", "", {"ends after 9 of its 10 faces"});
  off("4 7 0 8 15", "4 7 8 0 15", {"line 30: the face of 4 corners crosses or touches itself"});
  off("4 7 0 8 15", "4 7 0 0 15", {"line 30: "});
  off("16 10 0", "17 10 0", {"ends after 9 of its 10 faces"});
  off("16 10 0", "16", {"does not start as an OFF file does"});
  expect_refusal(scene_with_solid("bad.obj", arch::obj(arch::mesh()) + "f 1 2 99\n"), "bodies[0].mesh.path",
                 {"line 28: '99' is none of the 16 points"});
  expect_refusal(scene_with_solid("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 1\n"),
                 "bodies[0].mesh.path", {"has the same face in lines 5 and 6"});
  expect_refusal(
      scene_with_solid("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e-9\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"),
      "bodies[0].mesh.path", {"encloses 1.67e-10 m^3"});
  expect_refusal(scene_with_solid("bad.off", good, "surface: 7"), "bodies[0].mesh.surface", {"is 7; HULL or EXACT"});
}

TEST(SolidMesh, IsRefusedForSoftBodies) {
  expect_refusal(
      scene_with_solid("arch.off", arch::off(arch::mesh())) +
          fmt::format("soft_bodies {{ name: \"jelly\" material: \"glass\" spacing_m: 0.005 pose {{ position {{ z: 5 }} "
                      "}} mesh {{ path: \"{}_arch.off\" surface: EXACT }} }}",
                      getpid()),
      "soft_bodies[0].mesh.surface", {"is EXACT, which is for rigid bodies"});
}

}  // namespace
