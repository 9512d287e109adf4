#include "tests/conformance/bodies.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace sunder::conformance {

RigidBody sphere(BodyId id, double radius) {
  RigidBody b;
  b.id = id, b.name = "sphere_" + std::to_string(id);
  b.mass = kGlass * 4.0 / 3.0 * EIGEN_PI * radius * radius * radius;
  b.principal_inertia = Vec3::Constant(0.4 * b.mass * radius * radius);
  b.shape = SphereShape{radius};
  return b;
}

RigidBody box(BodyId id, const Vec3& half) {
  RigidBody b;
  b.id = id, b.name = "box_" + std::to_string(id);
  b.mass = kGlass * 8.0 * half.prod();
  const Vec3 squares = half.cwiseAbs2();
  b.principal_inertia = b.mass / 3.0 * (Vec3::Constant(squares.sum()) - squares);
  b.shape = BoxShape{half};
  return b;
}

RigidBody half_space(BodyId id, const Quat& tilt) {
  RigidBody b;
  b.id = id, b.name = "half_space_" + std::to_string(id), b.is_static = true;
  b.motion.orientation = tilt;
  b.shape = HalfSpaceShape{};
  return b;
}

RigidBody plate(BodyId id, const std::vector<Polygon>& polygons, double thickness) {
  double area = 0.0;
  Vec2 moment = Vec2::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();  // integral of p p^T over the area
  for (const Polygon& p : polygons)
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
      const Vec2 u = p[i] - p[0], v = p[i + 1] - p[0], sum = p[0] + p[i] + p[i + 1];
      const double part = 0.5 * (u.x() * v.y() - u.y() * v.x());
      area += part, moment += part / 3.0 * sum;
      second +=
          part / 12.0 *
          (p[0] * p[0].transpose() + p[i] * p[i].transpose() + p[i + 1] * p[i + 1].transpose() + sum * sum.transpose());
    }
  const Vec2 centre = moment / area;
  Mat3 spread = Mat3::Zero();  // integral of x x^T over the volume, about the centre of mass
  spread.topLeftCorner<2, 2>() = thickness * (second - area * centre * centre.transpose());
  spread(2, 2) = area * thickness * thickness * thickness / 12.0;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(kGlass * (spread.trace() * Mat3::Identity() - spread));
  Mat3 turn = axes.eigenvectors();
  if (turn.determinant() < 0.0) turn.col(0) *= -1.0;
  RigidBody b;
  b.id = id, b.name = "plate_" + std::to_string(id);
  b.mass = kGlass * area * thickness;
  b.principal_inertia = axes.eigenvalues();
  b.motion.position = {centre.x(), centre.y(), 0.0};
  b.motion.orientation = Quat(turn).normalized();
  ConvexShape shape;
  for (const Polygon& p : polygons) {
    auto& corners = shape.parts.emplace_back();
    for (const double side : {-0.5, 0.5})
      for (const Vec2& q : p)
        corners.push_back(b.motion.orientation.conjugate() *
                          Vec3(q.x() - centre.x(), q.y() - centre.y(), side * thickness));
  }
  b.shape = shape;
  return b;
}

Polygon rectangle(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

RigidBody fixed(RigidBody b) {
  b.is_static = true, b.mass = 0.0, b.principal_inertia = Vec3::Zero();
  b.motion.velocity = b.motion.angular_momentum = Vec3::Zero();
  return b;
}

RigidBody at(RigidBody b, const Vec3& position) {
  b.motion.position = position;
  return b;
}

RigidBody moving(RigidBody b, const Vec3& velocity, const Vec3& spin) {
  b.motion.velocity = velocity, b.motion.angular_momentum = b.apply_inertia(spin);
  return b;
}

RigidBody turned(RigidBody b, const Vec3& rotation) {
  b.motion.orientation = (rotation_from_vector(rotation) * b.motion.orientation).normalized();
  return b;
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

std::vector<RigidBody> thrown_plates(BodyId first, int count, bool compounds) {
  std::mt19937 random(7);
  const auto vector = [&](double size) -> Vec3 {
    const double x = uniform(random, -size, size), y = uniform(random, -size, size), z = uniform(random, -size, size);
    return {x, y, z};
  };
  std::vector<RigidBody> out;
  for (int i = 0; i < count; ++i) {
    const double size = uniform(random, 0.02, 0.06);
    std::vector<Polygon> polygons{rectangle(0, 0, size, 0.6 * size)};
    if (compounds && i % 3 == 2)
      polygons = {rectangle(0, 0, size, 0.3 * size), rectangle(0, 0.3 * size, 0.4 * size, size)};
    RigidBody b = turned(plate(first + static_cast<BodyId>(i), polygons, 0.003), vector(3.0));
    const Vec3 velocity = Vec3(0, 0, -2) + vector(0.5);
    out.push_back(moving(at(b, {0.07 * (i % 3), 0.07 * (i / 3 % 3), 0.05 + 0.07 * (i / 9)}), velocity, vector(10.0)));
  }
  return out;
}

}  // namespace sunder::conformance
