#pragma once
// Bodies and a caller for tests of engines: shards, and windows with gravity in the predicted states.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "rigid/engine/engine.h"

namespace sunder::rigid::testing {

constexpr double kGlass = 2500.0;  // [kg/m^3]
constexpr double kGravity = 9.81;  // [m/s^2]

using Polygon = std::vector<Vec2>;  // anticlockwise [m]

inline std::vector<Vec3> prism(const Polygon& polygon, double thickness, const Vec3& shift = Vec3::Zero()) {
  std::vector<Vec3> corners;
  for (const Vec2& p : polygon)
    for (double side : {-0.5, 0.5}) corners.push_back(Vec3(p.x(), p.y(), side * thickness) - shift);
  return corners;
}

/// A plate of convex polygons that share edges. The body has the plate's principal axes and place.
inline RigidBody plate(BodyId id, const std::vector<Polygon>& polygons, double thickness) {
  double area = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
  Vec2 first = Vec2::Zero();
  for (const Polygon& p : polygons) {
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vec2 a = p[i], b = p[(i + 1) % p.size()];
      const double cross = a.x() * b.y() - a.y() * b.x();
      area += cross / 2.0;
      first += cross / 6.0 * (a + b);
      xx += cross / 12.0 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
      yy += cross / 12.0 * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
      xy += cross / 24.0 * (a.x() * b.y() + 2.0 * a.x() * a.y() + 2.0 * b.x() * b.y() + b.x() * a.y());
    }
  }
  const Vec2 centre = first / area;
  xx -= area * centre.x() * centre.x();
  yy -= area * centre.y() * centre.y();
  xy -= area * centre.x() * centre.y();
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);  // of the axis of the largest moment
  const Eigen::Rotation2Dd turn(-angle);
  const double c = std::cos(angle), s = std::sin(angle);
  const double along = c * c * xx + 2.0 * s * c * xy + s * s * yy, across = xx + yy - along;
  const double sheet = kGlass * thickness, bend = kGlass * area * thickness * thickness * thickness / 12.0;
  RigidBody body;
  body.id = id;
  body.name = "plate_" + std::to_string(id);
  body.mass = sheet * area;
  body.principal_inertia = Vec3(sheet * across + bend, sheet * along + bend, sheet * (along + across));
  body.motion.position = Vec3(centre.x(), centre.y(), 0.0);
  body.motion.orientation = Quat(std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle));
  ConvexShape shape;
  for (const Polygon& p : polygons) {
    Polygon local;
    for (const Vec2& q : p) local.push_back(turn * (q - centre));
    shape.parts.push_back(prism(local, thickness));
  }
  body.shape = shape;
  return body;
}

inline Polygon rectangle(double x0, double y0, double x1, double y1) {
  return {Vec2(x0, y0), Vec2(x1, y0), Vec2(x1, y1), Vec2(x0, y1)};
}

inline RigidBody sphere(BodyId id, double radius, double mass) {
  RigidBody body;
  body.id = id;
  body.name = "sphere_" + std::to_string(id);
  body.mass = mass;
  body.principal_inertia = Vec3::Constant(0.4 * mass * radius * radius);
  body.shape = SphereShape{radius};
  return body;
}

inline RigidBody box(BodyId id, const Vec3& half, double mass) {
  RigidBody body;
  body.id = id;
  body.name = "box_" + std::to_string(id);
  body.mass = mass;
  const Vec3 s = half.cwiseProduct(half);
  body.principal_inertia = mass / 3.0 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  body.shape = BoxShape{half};
  return body;
}

inline RigidBody half_space(BodyId id) {
  RigidBody body;
  body.id = id;
  body.name = "floor";
  body.is_static = true;
  body.shape = HalfSpaceShape{};
  return body;
}

/// A random number in [low, high) from the raw generator: the same with every standard library.
inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (random() / 4294967296.0);
}

/// Shards 2 to 20 cm wide and 3 to 4 mm thick, every fourth one an L of two parts. They fall at 1 to 10 m/s from about
/// 0.3 m above the floor, with random orientation and spin.
inline std::vector<RigidBody> thrown_shards(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<RigidBody> bodies;
  for (int i = 0; i < count; ++i) {
    const double size = 0.02 * std::pow(10.0, uniform(random, 0.0, 1.0)), thickness = uniform(random, 0.003, 0.004);
    std::vector<Polygon> polygons;
    if (i % 4 == 3) {
      polygons = {rectangle(0, 0, size, 0.3 * size), rectangle(0, 0.3 * size, 0.4 * size, size)};
    } else {
      const int corners = 3 + static_cast<int>(uniform(random, 0.0, 5.0));
      Polygon polygon;
      for (int k = 0; k < corners; ++k) {  // on an ellipse: always convex
        const double angle = 2.0 * EIGEN_PI * (k + uniform(random, 0.0, 0.7)) / corners;
        polygon.push_back(0.5 * size * Vec2(std::cos(angle), 0.6 * std::sin(angle)));
      }
      polygons = {polygon};
    }
    RigidBody body = plate(static_cast<BodyId>(i + 1), polygons, thickness);
    body.motion.position = Vec3(0.25 * (i % 4), 0.25 * (i / 4 % 4), 0.3 + 0.12 * (i / 16));
    const Vec3 axis(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    body.motion.orientation = rotation_from_vector(3.0 * axis).normalized();
    body.motion.velocity = Vec3(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), -uniform(random, 1, 10));
    const Vec3 spin(uniform(random, -10, 10), uniform(random, -10, 10), uniform(random, -10, 10));
    body.motion.angular_momentum = body.apply_inertia(spin);
    bodies.push_back(body);
  }
  return bodies;
}

/// The shell process's part for an engine: proxies that fly freely through the substeps of each window.
class Caller {
 public:
  Caller(Engine& engine, double window_s, double gravity) : engine_(engine), window_s_(window_s), gravity_(gravity) {}

  void add(const RigidBody& body) {
    engine_.add(body);
    if (!body.is_static) proxies_[body.id] = body;
  }

  void window() {
    constexpr int kSubsteps = 4;
    const double h = window_s_ / kSubsteps;
    predicted_.clear();
    for (auto& [id, proxy] : proxies_) {
      for (int i = 0; i < kSubsteps; ++i) {
        proxy.motion.velocity.z() -= gravity_ * h;
        proxy.drift(h);
      }
      predicted_.push_back({id, proxy.motion});
    }
    engine_.advance(window_s_, predicted_, {});
    for (const EngineState& state : engine_.states()) proxies_.at(state.id).motion = state.motion;
  }

  void run(double seconds) {
    for (long i = std::lround(seconds / window_s_); i > 0; --i) window();
  }

  const RigidBody& body(BodyId id) const { return proxies_.at(id); }
  const std::map<BodyId, RigidBody>& bodies() const { return proxies_; }
  const std::vector<PredictedState>& predicted() const { return predicted_; }

  double kinetic_energy() const {
    double sum = 0.0;
    for (const auto& [id, body] : proxies_) sum += body.kinetic_energy();
    return sum;
  }
  /// Kinetic and potential energy [J].
  double energy() const {
    double sum = kinetic_energy();
    for (const auto& [id, body] : proxies_) sum += body.mass * gravity_ * body.motion.position.z();
    return sum;
  }

  /// Energy of the last predicted states [J]. The difference from energy() is the engine's.
  double predicted_energy() const {
    double sum = 0.0;
    for (const PredictedState& state : predicted_) {
      RigidBody body = proxies_.at(state.id);
      body.motion = state.motion;
      sum += body.kinetic_energy() + body.mass * gravity_ * body.motion.position.z();
    }
    return sum;
  }

 private:
  Engine& engine_;
  double window_s_, gravity_;
  std::map<BodyId, RigidBody> proxies_;
  std::vector<PredictedState> predicted_;
};

/// Height of a convex body's lowest corner [m].
inline double lowest_corner(const RigidBody& body) {
  double low = 1e300;
  for (const auto& part : std::get<ConvexShape>(body.shape).parts)
    for (const Vec3& p : part) low = std::min(low, (body.motion.position + body.motion.orientation * p).z());
  return low;
}

}  // namespace sunder::rigid::testing
