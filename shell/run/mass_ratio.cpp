#include "shell/run/mass_ratio.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

namespace sunder::shell {
namespace {

constexpr double kLeastRatio = 20.0;  // below it no engine has failed [-]
// Largest R g H^2 / L that engines hold, for a ratio of masses R, a window H, and a light body of the size L. A solver
// that iterates leaves a share of the heavy weight, which moves the light body by some R g H^2 in a window. Calibrated
// by boxes of 0.2 m over 2 s: in double precision they are squeezed out from 0.08 on. In single precision, which loses
// the light body's share of an impulse, the lower one slides by 27 mm at 0.005 (R = 1000), by 2 um at 0.002 and by less
// than 1 um at 0.0005.
constexpr double kHeldDouble = 0.005, kHeldSingle = 0.0005;  // [-]
constexpr double kNear = 0.02;      // gap of the boxes around two bodies that touch, as a share of the light one's size
constexpr double kAtRest = 0.5;     // speed of one on the other, in speeds that gravity adds over the light one's size
constexpr std::int64_t kLooks = 3;  // a body that bounces off is not seen so often

Eigen::AlignedBox3d box_of(const RigidBody& b) {
  Eigen::AlignedBox3d box;
  const auto add = [&](const Vec3& local) { box.extend(b.motion.position + b.motion.orientation * local); };
  if (const auto* sphere = std::get_if<SphereShape>(&b.shape)) {
    box.extend(b.motion.position + Vec3::Constant(sphere->radius));
    box.extend(b.motion.position - Vec3::Constant(sphere->radius));
  } else if (const auto* cuboid = std::get_if<BoxShape>(&b.shape)) {
    for (int k = 0; k < 8; ++k)
      add(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).cwiseProduct(cuboid->half_size));
  } else if (const auto* convex = std::get_if<ConvexShape>(&b.shape)) {
    for (const auto& part : convex->parts) std::for_each(part.begin(), part.end(), add);
  }
  return box;
}

std::string name_of(const std::vector<Proxy>& bodies, BodyId id) {
  const auto at = std::find_if(bodies.begin(), bodies.end(), [&](const Proxy& p) { return p.body.id == id; });
  return at == bodies.end() ? std::string() : at->body.name;
}

}  // namespace

void look_for_heavy(const std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double window,
                    bool double_precision, HeavyPair& pair) {
  const double g = gravity.norm();
  if (g == 0.0) return;
  HeavyPair worst;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) {
      const RigidBody &heavy = bodies[i].body, &light = bodies[j].body;
      if (!bodies[i].is_free() || !bodies[j].is_free() || heavy.mass < kLeastRatio * light.mass) continue;
      const double ratio = heavy.mass / light.mass;
      const Vec3 apart = heavy.motion.position - light.motion.position;
      if (ratio <= worst.ratio || apart.dot(gravity) >= 0.0 ||
          apart.norm() > 1.1 * (bodies[i].radius() + bodies[j].radius()))
        continue;
      const Eigen::AlignedBox3d below = box_of(light);
      const double size = below.sizes().minCoeff();
      const double held = std::sqrt((double_precision ? kHeldDouble : kHeldSingle) * size / (ratio * g));
      if (window <= held || (heavy.motion.velocity - light.motion.velocity).norm() > kAtRest * std::sqrt(g * size) ||
          below.exteriorDistance(box_of(heavy)) > kNear * size)
        continue;
      worst = {heavy.id, light.id, ratio, held, 0};
    }
  if (worst.ratio == 0.0 || worst.ratio < pair.ratio) return;
  worst.looks = worst.heavy == pair.heavy && worst.light == pair.light ? pair.looks + 1 : 1;
  pair = worst;
}

std::string blocked_warning(const std::vector<Proxy>& bodies, BodyId id, double when) {
  return fmt::format(
      "at {:.4g} s '{}', which follows a prescribed motion, pressed on a body that does not give way, or another one "
      "against it: work is booked as what free bodies gained there, and the engine's losses are not known",
      when, name_of(bodies, id));
}

namespace {

// To two digits, so that the number that is told is one that does. A number of two digits stays as it is.
double rounded_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit * (1.0 + 1e-12)) * unit;
}

}  // namespace

std::string heavy_warning(const std::vector<Proxy>& bodies, const HeavyPair& pair, const std::string& engine) {
  if (pair.looks < kLooks) return "";
  return fmt::format(
      "'{}' lies on '{}', which is {:.3g} times lighter: in windows as long as these the engine '{}' may let it sink "
      "in or squeeze it out; take --rigid ode, which holds any ratio, or a window_s of {:.2g} s or less",
      name_of(bodies, pair.heavy), name_of(bodies, pair.light), pair.ratio, engine, rounded_down(pair.window));
}

}  // namespace sunder::shell
