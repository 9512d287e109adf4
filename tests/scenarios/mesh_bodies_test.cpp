// Meshes of the shipped scenes as bodies: every engine takes their convex parts, however the mesh is turned.
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "coupler/scene/mesh.h"
#include "rigid/engine/engine.h"

namespace {

using namespace sunder;

scene::Polygon polygon(std::istream& in) {
  std::size_t n = 0;
  in >> n;
  scene::Polygon p;
  p.corners.resize(n);
  for (int& c : p.corners) in >> c;
  return p;
}

// A closed surface from an OFF file without comments, turned and scaled.
Surface surface_of(const std::string& file, const Mat3& turn) {
  std::ifstream in(file);
  std::string header;
  std::size_t points = 0, faces = 0, edges = 0;
  in >> header >> points >> faces >> edges;
  std::vector<Vec3> at(points);
  for (Vec3& p : at) {
    in >> p.x() >> p.y() >> p.z();
    p = 0.3 * (turn * p);
  }
  std::vector<scene::Polygon> polygons;
  for (std::size_t i = 0; i < faces; ++i) polygons.push_back(polygon(in));
  EXPECT_TRUE(in) << file;
  return scene::closed_surface(at, polygons);
}

TEST(MeshBodies, AreTakenByEveryEngineInAnyPose) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (const char* name : {"tree_branch_1", "tree_branch_2", "tree_branch_6", "tree_trunk"})
    for (int pose = 0; pose < 8; ++pose) {
      const Quat turn = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
      const Surface surface = surface_of(fmt::format("{}/{}.off", SUNDER_SCENES, name), turn.toRotationMatrix());
      RigidBody body;
      body.id = 1;
      body.name = name;
      body.mass = 1.0;
      body.principal_inertia = Vec3::Ones();
      body.shape = ConvexShape{scene::convex_parts(surface), {}};
      double volume = 0.0;
      for (const auto& part : std::get<ConvexShape>(body.shape).parts) volume += scene::hull_of(part).volume;
      EXPECT_NEAR(volume, enclosed_volume(surface), 1e-5 * volume) << name;  // slivers are left out, 1e-6 each at most
      for (const char* engine : {"bullet", "ode"})
        EXPECT_NO_THROW(rigid::make_engine(engine)->add(body)) << name << ", pose " << pose << ", " << engine;
    }
}

}  // namespace
