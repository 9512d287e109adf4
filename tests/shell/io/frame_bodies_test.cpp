// Bodies of frames as meshes: closed surfaces of the right size and place, and what is written of each.
#include "shell/io/frame_bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/shell/soft_blocks.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr BodyId kFirstShard = 100;

RigidBody drawn_body(BodyId id, const Shape& shape) {
  RigidBody b;
  b.id = id, b.shape = shape, b.mass = 2.0, b.principal_inertia = Vec3(1, 2, 4);
  b.motion.position = Vec3(0.5, -1.0, 2.0);
  b.motion.orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  return b;
}
VtpMesh mesh_of(const std::vector<RigidBody>& bodies, const FrameFields& fields = {}) {
  return body_mesh(bodies, kFirstShard, {}, {}, fields);
}
// Area of a mesh of triangles [m^2], and the volume that it encloses, positive where normals look outwards [m^3].
struct Enclosed {
  double area = 0.0, volume = 0.0;
  explicit Enclosed(const VtpMesh& mesh) {
    const Vec3 origin(0.5, -1.0, 2.0);
    for (const std::vector<int>& t : mesh.polygons) {
      const Vec3 a = mesh.points[t[0]] - origin, b = mesh.points[t[1]] - origin, c = mesh.points[t[2]] - origin;
      area += 0.5 * (b - a).cross(c - a).norm(), volume += a.dot(b.cross(c)) / 6.0;
    }
  }
};
const VtpArray& array_of(const std::vector<VtpArray>& arrays, const std::string& name) {
  for (const VtpArray& a : arrays)
    if (a.name == name) return a;
  static const VtpArray none{"none", 1, {}};
  ADD_FAILURE() << "no array " << name;
  return none;
}
bool has_array(const std::vector<VtpArray>& arrays, const std::string& name) {
  return std::any_of(arrays.begin(), arrays.end(), [&](const VtpArray& a) { return a.name == name; });
}
// The corner at the origin and one on each axis.
std::vector<Vec3> corner_part(double size, const Vec3& at) {
  return {at, at + size * Vec3::UnitX(), at + size * Vec3::UnitY(), at + size * Vec3::UnitZ()};
}

}  // namespace

TEST(FrameBodies, ABoxHasItsAreaAndVolume) {
  const VtpMesh mesh = mesh_of({drawn_body(7, BoxShape{Vec3(1, 2, 3)})});
  EXPECT_EQ(mesh.polygons.size(), 12u);
  const Enclosed box(mesh);
  EXPECT_NEAR(box.area, 8.0 * (2.0 + 3.0 + 6.0), 1e-12);  // round-off
  EXPECT_NEAR(box.volume, 8.0 * 6.0, 1e-12);
  EXPECT_EQ(array_of(mesh.cell_data, "body").values, std::vector<double>(12, 7.0));
  EXPECT_EQ(array_of(mesh.cell_data, "kind").values, std::vector<double>(12, 0.0));
  EXPECT_TRUE(mesh.point_data.empty());
}

TEST(FrameBodies, PointsOfASphereAreOnIt) {
  const VtpMesh mesh = mesh_of({drawn_body(1, SphereShape{0.25})});
  for (const Vec3& x : mesh.points) EXPECT_NEAR((x - Vec3(0.5, -1.0, 2.0)).norm(), 0.25, 1e-15);
  for (const std::vector<int>& t : mesh.polygons) {
    const Vec3 a = mesh.points[t[0]];
    EXPECT_GT((mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).norm(), 1e-4);  // none at the poles without area
  }
  // A ring of 24 chords has sin(15 degrees) / 15 degrees of its circle's area, 0.989. In 12 rings from pole to pole a
  // chord of 15 degrees bends as much, and there are two radii: 0.96 or more together.
  const double whole = 4.0 / 3.0 * std::numbers::pi * std::pow(0.25, 3), volume = Enclosed(mesh).volume;
  EXPECT_LT(volume, whole);
  EXPECT_GT(volume, 0.96 * whole);
}

TEST(FrameBodies, AHalfSpaceIsASquareInItsPlane) {
  const RigidBody body = drawn_body(1, HalfSpaceShape{});
  const VtpMesh mesh = mesh_of({body});
  EXPECT_NEAR(Enclosed(mesh).area, 4.0, 1e-14);
  const Vec3 up = body.motion.orientation * Vec3::UnitZ();
  for (const Vec3& x : mesh.points) EXPECT_NEAR(up.dot(x - body.motion.position), 0.0, 1e-15);
}

TEST(FrameBodies, PartsOfAConvexBodyAreEachClosed) {
  const std::vector<Vec3> large = corner_part(2.0, Vec3::Zero()), small = corner_part(1.0, Vec3(5, 0, 0));
  const VtpMesh mesh = mesh_of({drawn_body(1, ConvexShape{{large, small}})});
  EXPECT_EQ(mesh.polygons.size(), 8u);
  EXPECT_NEAR(Enclosed(mesh).volume, (8.0 + 1.0) / 6.0, 1e-13);
  // order of the corners does not matter
  std::vector<Vec3> mixed{large[2], large[0], large[3], large[1]};
  EXPECT_NEAR(Enclosed(mesh_of({drawn_body(1, ConvexShape{{mixed}})})).volume, 8.0 / 6.0, 1e-13);
}

TEST(FrameBodies, FacesOfAConvexPartWithManyCornersAreDrawnOnce) {
  std::vector<Vec3> cube;
  for (const int i : {0, 1, 2, 3, 4, 5, 6, 7}) cube.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  const VtpMesh mesh = mesh_of({drawn_body(1, ConvexShape{{cube}})});
  EXPECT_EQ(mesh.polygons.size(), 12u);
  EXPECT_NEAR(Enclosed(mesh).area, 6.0, 1e-13);
  EXPECT_NEAR(Enclosed(mesh).volume, 1.0, 1e-13);
}

TEST(FrameBodies, ASurfaceIsDrawnInPlaceOfItsParts) {
  auto surface = std::make_shared<Surface>();
  surface->corners = corner_part(1.0, Vec3::Zero());
  surface->triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const RigidBody body = drawn_body(1, ConvexShape{{corner_part(9.0, Vec3::Zero())}, surface});
  const VtpMesh mesh = mesh_of({body, body});
  ASSERT_EQ(mesh.points.size(), 8u);  // corners that triangles share are one point
  for (int k = 0; k < 4; ++k)
    EXPECT_EQ(mesh.points[k], body.motion.position + body.motion.orientation * surface->corners[k]);
  EXPECT_EQ(mesh.polygons[1], (std::vector<int>{0, 1, 3}));
  EXPECT_EQ(mesh.polygons[5], (std::vector<int>{4, 5, 7}));  // the second body has points of its own
  EXPECT_NEAR(Enclosed(mesh).volume, 2.0 / 6.0, 1e-15);
}

TEST(FrameBodies, KindTellsShardsAndStaticBodies) {
  std::vector<RigidBody> bodies;
  for (const BodyId id : {1u, kFirstShard - 1, kFirstShard, kFirstShard + 5})
    bodies.push_back(drawn_body(id, HalfSpaceShape{}));
  bodies[1].is_static = bodies[3].is_static = true;
  EXPECT_EQ(array_of(mesh_of(bodies).cell_data, "kind").values, (std::vector<double>{0, 0, 2, 2, 1, 1, 3, 3}));
}

TEST(FrameBodies, OfNoneHaveTheirArraysAllTheSame) {
  const VtpMesh mesh = mesh_of({});
  EXPECT_TRUE(mesh.points.empty());
  ASSERT_EQ(mesh.cell_data.size(), 2u);
  EXPECT_TRUE(mesh.cell_data[0].integer);
  EXPECT_TRUE(array_of(mesh.cell_data, "body").values.empty());
  EXPECT_TRUE(array_of(mesh.cell_data, "kind").values.empty());
}

TEST(FrameBodies, APieceOfAShellKeepsItsIdPlacesAndShells) {
  DrawnMesh piece;
  piece.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  piece.triangles = {{0, 1, 2}};
  piece.rest = {{3, 0, 0}, {4, 0, 0}, {3, 1, 0}};
  piece.uv = {{0.1, 0.2}, {0.3, 0.4}, {0.5, 0.6}};
  piece.shell = {4};
  const RigidBody shard = drawn_body(kFirstShard + 2, SphereShape{9.0}), other = drawn_body(1, HalfSpaceShape{});
  std::map<BodyId, DrawnMesh> drawn{{shard.id, piece}};
  const std::map<BodyId, BodyId> ids{{shard.id, 12}};
  VtpMesh mesh = body_mesh({other, shard}, kFirstShard, drawn, ids, {});
  EXPECT_EQ(array_of(mesh.cell_data, "body").values, (std::vector<double>{1, 1, 12}));
  EXPECT_EQ(array_of(mesh.cell_data, "kind").values, (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(array_of(mesh.cell_data, "shell").values, (std::vector<double>{-1, -1, 4}));
  ASSERT_EQ(mesh.points.size(), 7u);
  const VtpArray &u = array_of(mesh.point_data, "displacement"), &uv = array_of(mesh.point_data, "uv");
  ASSERT_EQ(u.values.size(), 21u);
  ASSERT_EQ(uv.values.size(), 14u);
  for (std::size_t k = 0; k < 12; ++k) EXPECT_EQ(u.values[k], 0.0);
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d) EXPECT_EQ(u.values[3 * (4 + k) + d], mesh.points[4 + k][d] - piece.rest[k][d]);
  EXPECT_EQ(std::vector<double>(uv.values.begin() + 8, uv.values.end()),
            (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}));
  EXPECT_FALSE(has_array(mesh.point_data, "colour"));
  // Where some piece has colours, all else is white.
  drawn[shard.id].colour = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0.5}};
  mesh = body_mesh({other, shard}, kFirstShard, drawn, ids, {});
  const VtpArray& colour = array_of(mesh.point_data, "colour");
  ASSERT_EQ(colour.values.size(), 21u);
  for (std::size_t k = 0; k < 12; ++k) EXPECT_EQ(colour.values[k], 1.0);
  EXPECT_EQ(std::vector<double>(colour.values.begin() + 12, colour.values.end()),
            (std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 0.5}));
}

TEST(FrameBodies, MotionIsThereWhereItIsAsked) {
  FrameFields fields;
  fields.velocity = [](std::size_t body, const Vec3& at) { return Vec3(static_cast<double>(body), at.x(), 0.0); };
  std::vector<RigidBody> bodies{drawn_body(1, HalfSpaceShape{}), drawn_body(2, HalfSpaceShape{})};
  bodies[0].is_static = true, bodies[0].mass = 0.0;
  bodies[1].motion.orientation.setIdentity();
  bodies[1].motion.angular_momentum = Vec3(3, 4, 8);  // about axes of 1, 2 and 4 kg m^2
  EXPECT_FALSE(has_array(mesh_of(bodies, fields).cell_data, "mass_kg"));
  fields.set.add(FieldSet::kBodyMotion);
  const VtpMesh mesh = mesh_of(bodies, fields);
  EXPECT_EQ(array_of(mesh.cell_data, "mass_kg").values, (std::vector<double>{0, 0, 2, 2}));
  const VtpArray& spin = array_of(mesh.cell_data, "spin_rad_per_s");
  ASSERT_EQ(spin.values.size(), 12u);
  EXPECT_EQ(spin.unit, "rad/s");
  for (int k = 0; k < 6; ++k) EXPECT_EQ(spin.values[k], 0.0);
  for (int d = 0; d < 3; ++d) EXPECT_DOUBLE_EQ(spin.values[6 + d], Vec3(3, 2, 2)[d]);
  const VtpArray& velocity = array_of(mesh.point_data, "velocity");
  ASSERT_EQ(velocity.values.size(), 24u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(velocity.values[3 * k], k < 4 ? 0.0 : 1.0);
    EXPECT_EQ(velocity.values[3 * k + 1], mesh.points[k].x());
  }
}

// Particles of a block at rest and of one that is stretched: J is the volume over that at rest, and balls grow with it.
TEST(SoftMesh, BallsHaveTheVolumeOfTheirParticles) {
  using namespace soft_blocks;
  SoftBodies soft({block({0.02, 0.02, 0.02}, at({0, 0, 0}), 0.01), block({0.01, 0.01, 0.01}, at({1, 0, 0}), 0.01)}, 0,
                  {});
  SoftState& second = soft.states()[1];
  for (auto& f : second.f) f = 2.0 * Mat3::Identity();
  for (Vec3& v : second.v) v = Vec3(1, 2, 3);
  const VtpMesh mesh = soft_mesh(soft);
  const std::size_t count = soft.states()[0].x.size(), all = count + second.x.size();
  ASSERT_EQ(mesh.verts.size(), all);
  EXPECT_TRUE(mesh.polygons.empty());
  const std::vector<double>&j = array_of(mesh.point_data, "J").values,
        &radius = array_of(mesh.point_data, "radius").values, &body = array_of(mesh.point_data, "soft_body").values,
        &velocity = array_of(mesh.point_data, "velocity").values,
        &surface = array_of(mesh.point_data, "surface").values, &normal = array_of(mesh.point_data, "normal").values;
  ASSERT_EQ(radius.size(), all);
  ASSERT_EQ(normal.size(), 3 * all);
  double volume[2] = {};
  for (std::size_t k = 0; k < all; ++k) {
    const int which = k < count ? 0 : 1;
    EXPECT_EQ(mesh.verts[k], static_cast<int>(k));
    EXPECT_EQ(body[k], which);
    EXPECT_EQ(j[k], which == 0 ? 1.0 : 8.0);
    EXPECT_EQ(velocity[3 * k + 1], which == 0 ? 0.0 : 2.0);
    volume[which] += 4.0 / 3.0 * std::numbers::pi * std::pow(radius[k], 3);
    // A normal sum of one to three faces, at a right angle to each other; zero inside.
    const double squared = Vec3(normal[3 * k], normal[3 * k + 1], normal[3 * k + 2]).squaredNorm();
    EXPECT_EQ(surface[k], squared > 0.5 ? 1.0 : 0.0);
    EXPECT_NEAR(squared, std::round(squared), 1e-12);
  }
  EXPECT_NEAR(volume[0], std::pow(0.04, 3), 1e-18);  // round-off
  EXPECT_NEAR(volume[1], 8.0 * std::pow(0.02, 3), 1e-18);
}
