#include "shell/contact/driven_body.h"

#include <algorithm>

#include "coupler/core/smooth_keys.h"

namespace sunder::shell {
namespace {

constexpr double kFarTurn = 1.0;  // [rad], from which on the chord of an arc tells little of its length
constexpr int kLooks = 16;  // between two keys: the speed of a cubic is a parabola, whose top they see to a part in 500

}  // namespace

void ShapeCurve::at(double t, std::vector<Vec3>& out) const {
  const HermiteWeights w = hermite_weights(times, t);
  const std::size_t k = static_cast<std::size_t>(w.key);
  out = corners[k];
  if (k + 1 >= corners.size() || (w.c == 0.0 && w.b == 0.0)) return;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = w.a * out[i] + w.b * slopes[k][i] + w.c * corners[k + 1][i] + w.d * slopes[k + 1][i];
}

ShapeCurve shape_curve(std::vector<double> times, std::vector<std::vector<Vec3>> corners) {
  ShapeCurve c{std::move(times), std::move(corners), {}};
  c.slopes.assign(c.corners.size(), std::vector<Vec3>(c.corners.front().size(), Vec3::Zero()));
  for (std::size_t i = 0; i < c.corners.front().size(); ++i) {
    std::vector<Vec3> path;
    for (const std::vector<Vec3>& shape : c.corners) path.push_back(shape[i]);
    const std::vector<Vec3> slopes = smooth_slopes(c.times, path);
    for (std::size_t k = 0; k < slopes.size(); ++k) c.slopes[k][i] = slopes[k];
  }
  return c;
}

PlacedAt DrivenMotion::at(double t) const {
  const PlacedAt frame = path.empty() ? still : path.at(t);
  return {frame.position + frame.orientation * own.position, (frame.orientation * own.orientation).normalized()};
}

double DrivenMotion::last() const {
  return std::max(path.empty() ? 0.0 : path.times().back(), shape.empty() ? 0.0 : shape.times.back());
}

double DrivenMotion::fastest(double radius, double& when) const {
  std::vector<double> keys{0.0};
  if (!path.empty()) keys.insert(keys.end(), path.times().begin(), path.times().end());
  keys.insert(keys.end(), shape.times.begin(), shape.times.end());
  std::sort(keys.begin(), keys.end());
  double most = 0.0;
  std::vector<Vec3> now, then;
  const auto look = [&](double from, double to) {
    const PlacedAt a = at(from), b = at(to);
    const double turn = path.empty() ? 0.0 : path.turning(from, to);
    double travel = 0.0;
    if (deforms()) {
      shape.at(from, now), shape.at(to, then);
      for (std::size_t i = 0; i < now.size(); ++i) {
        const double least = (b.position + b.orientation * then[i] - a.position - a.orientation * now[i]).norm();
        const double most = (b.position - a.position).norm() + (then[i] - now[i]).norm() + turn * now[i].norm();
        travel = std::max(travel, turn > kFarTurn ? most : least);
      }
    } else {
      travel = (b.position - a.position).norm() + radius * turn;
    }
    if (travel / (to - from) > most) most = travel / (to - from), when = from;
  };
  for (std::size_t k = 0; k + 1 < keys.size(); ++k)
    for (int part = 0; part < kLooks && keys[k + 1] > keys[k]; ++part) {
      const double h = (keys[k + 1] - keys[k]) / kLooks;
      look(keys[k] + part * h, keys[k] + (part + 1) * h);
    }
  return most;
}

void place(const DrivenMotion& motion, double t, double dt, RigidBody& body, Vec3& spin) {
  const PlacedAt now = motion.at(t);
  body.motion = {now.position, now.orientation, Vec3::Zero(), Vec3::Zero()};
  spin.setZero();
  if (!(dt > 0.0)) return;
  const PlacedAt then = motion.at(t + dt);
  body.motion.velocity = (then.position - now.position) / dt;
  spin = rotation_vector(then.orientation * now.orientation.conjugate()) / dt;
  if (!body.is_static) body.motion.angular_momentum = body.apply_inertia(spin);
}

}  // namespace sunder::shell
