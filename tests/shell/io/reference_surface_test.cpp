// The middle of a sheet of which a scene gives a face.
#include "shell/io/reference_surface.h"

#include <cmath>
#include <numbers>

#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "shell/solver/model.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

double radius_off(const Patch& p, double radius) {
  double most = 0.0;
  for (double u = 0.0; u <= 1.0; u += 0.07)
    for (double v = 0.0; v <= 1.0; v += 0.07) {
      const Vec2 at(p.knots_u.begin() + u * (p.knots_u.end() - p.knots_u.begin()),
                    p.knots_v.begin() + v * (p.knots_v.end() - p.knots_v.begin()));
      const Vec3 x = p.evaluate(at).x;
      most = std::max(most, std::abs(std::hypot(x.x(), x.y()) - radius));
    }
  return most;
}

// 1 where u x v points away from the axis, or from the origin where there is none; else -1.
double outwards(const Patch& p, const Vec3& axis) {
  const SurfacePoint s =
      p.evaluate({0.5 * (p.knots_u.begin() + p.knots_u.end()), 0.5 * (p.knots_v.begin() + p.knots_v.end())});
  return s.u.cross(s.v).dot(s.x - axis * axis.dot(s.x)) > 0.0 ? 1.0 : -1.0;
}

}  // namespace

TEST(ReferenceSurface, OfACylinderASphereAndAPlaneIsExact) {
  for (const int degree : {2, 3}) {
    const Patch c = cylinder(0.2, 0.3, 1.5, 6, 4, degree);
    const Patch moved = offset_patch(
        c, [](const Vec2&) { return 0.01; }, 1e-12);
    const double side = outwards(c, Vec3(0, 0, 1));
    EXPECT_LT(radius_off(moved, 0.2 + side * 0.01), 1e-13);
    const Patch s = sphere(0.2, 1.2, 0.7, 1.4, 5, 5, degree);
    const Patch shell = offset_patch(
        s, [](const Vec2&) { return -0.01; }, 1e-12);
    const double r = shell.evaluate({0.5 * shell.knots_u.end(), 0.5 * shell.knots_v.end()}).x.norm();
    EXPECT_LT(std::abs(r - (0.2 - outwards(s, Vec3::Zero()) * 0.01)), 1e-13);
  }
  const Patch flat = plate(0.3, 0.2, 3, 4, Vec3::Zero(), Quat::Identity());
  const Patch up = offset_patch(
      flat, [](const Vec2& p) { return 0.01 * p.x(); }, 1e-12);  // a wedge
  EXPECT_NEAR(up.evaluate({0.1, 0.1}).x.z(), 0.001, 1e-15);
}

TEST(ReferenceSurface, ThatIsTooBentOrTooCoarseIsRefused) {
  const Patch c = cylinder(0.02, 0.3, 1.5, 6, 4);
  int refused = 0;
  for (const double far : {0.021, -0.021}) try {
      offset_patch(
          c, [far](const Vec2&) { return far; }, 1e-3);
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(std::string(e.what()).find("turns over"), std::string::npos) << e.what();
    }
  EXPECT_EQ(refused, 1);  // towards the axis
  try {
    offset_patch(
        cubic_patch(), [](const Vec2&) { return 0.1; }, 1e-9);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("take more elements"), std::string::npos) << e.what();
  }
}

// A cube whose faces are 2 mm thick: middles are 1 mm within, and its corners stay corners.
TEST(ReferenceSurface, OfAMeshKeepsCornersAndCreases) {
  const std::vector<Vec3> x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  std::vector<FileTriangle> t;
  for (const auto& q : std::vector<std::array<int, 4>>{
           {0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}})
    t.push_back({{q[0], q[1], q[2]}}), t.push_back({{q[0], q[2], q[3]}});
  TriangleMesh m = make_triangle_mesh(x, t, 0.0, "line");
  m.part.assign(m.triangles.size(), 0);
  offset_mesh(m, [](int, int) { return -0.001; });
  for (const Vec3& p : m.points)
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(std::min(p[d], 1.0 - p[d]), 0.001, 1e-15);
  EXPECT_THROW(offset_mesh(m, [](int, int) { return -0.6; }), Error);
}

class ReferenceScene : public MeshScene {};

TEST_F(ReferenceScene, OfAMeshIsHalfAThicknessWithin) {
  Triangles bowl = lattice(40, 30, false, [](double u, double v) {
    const double a = 1.0 * (u - 0.5), b = 0.8 * (v - 0.5);
    return Vec3(std::sin(a), std::sin(b) * std::cos(a), std::cos(a) * std::cos(b));  // a part of the unit sphere
  });
  write("a.obj", bowl);
  double away = 0.0;  // of the normal
  const auto radius = [&](const std::string& in_shell) {
    const ShellModel m = setup("path: 'a.obj' element_m: 0.05", in_shell).shells[0].model;
    away = outwards(m.patch, Vec3::Zero());
    return m.patch.evaluate({0.5 * m.patch.knots_u.end(), 0.5 * m.patch.knots_v.end()}).x.norm();
  };
  const double given = radius(""), outside = radius("reference: OUTSIDE"), inside = radius("reference: INSIDE");
  EXPECT_NEAR(away * (given - outside), 0.005, 1e-5);  // inwards of the face on the side of the normal
  EXPECT_NEAR(outside + inside, 2.0 * given, 1e-5);
  const double thin = radius(
      "reference: OUTSIDE thickness_law { along: X points { at_m: -1 factor: 0.2 } "
      "points { at_m: 1 factor: 0.2 } }");
  EXPECT_NEAR(away * (given - thin), 0.001, 1e-5);
}

TEST_F(ReferenceScene, OfAPatchMovesItsModel) {
  const auto height = [&](const std::string& in_shell) {
    write("scene.textproto", std::string(R"(name: "plate"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.01
  plate { size_x_m: 0.4 size_y_m: 0.2 elements_x: 16 elements_y: 8 }
  )") + in_shell + "\n}\n");
    return build(scene::load(folder.path + "/scene.textproto", {})).shells[0].model.patch.control_points[20].z();
  };
  EXPECT_NEAR(height("reference: OUTSIDE"), -0.005, 1e-15);
  EXPECT_NEAR(height("reference: INSIDE"), 0.005, 1e-15);
  EXPECT_NEAR(height(""), 0.0, 1e-15);
}
