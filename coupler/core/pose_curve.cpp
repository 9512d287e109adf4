#include "coupler/core/pose_curve.h"

#include <cmath>
#include <numbers>

#include "coupler/core/smooth_keys.h"

namespace sunder {
namespace {

constexpr double kSameAxis = 1e-12;   // sine of the angle between two axes that count as one
constexpr double kSeriesTurn = 1e-4;  // [rad], below which series take the place of quotients
constexpr double kWholeTurn = 1e-3;   // [rad], from a whole turn, where the inverse of J is singular across the axis

// The turn from one key to the next in world axes.
Vec3 turn_between(const PoseKey& from, const PoseKey& to) {
  const double a = from.turn.norm(), b = to.turn.norm();
  if (from.counts_turns && to.counts_turns && from.turn.cross(to.turn).norm() <= kSameAxis * a * b)
    return to.turn - from.turn;
  return rotation_vector(rotation_from_vector(to.turn) * rotation_from_vector(from.turn).conjugate());
}

// J(r)^-1 w: the slope of a rotation vector r whose rotation turns with the spin w in world axes.
Vec3 slope_of_turn(const Vec3& r, const Vec3& w) {
  const double angle = r.norm();
  const Vec3 across = r.cross(w);
  if (across.norm() <= kSameAxis * angle * w.norm()) return w;
  double share = 1.0 / 12.0 + angle * angle / 720.0;
  if (angle > kSeriesTurn) share = (1.0 - 0.5 * angle * std::sin(angle) / (1.0 - std::cos(angle))) / (angle * angle);
  return w - 0.5 * across + share * r.cross(across);
}

}  // namespace

PoseCurve::PoseCurve(const std::vector<PoseKey>& keys) {
  for (const PoseKey& k : keys) {
    times_.push_back(k.time), positions_.push_back(k.position);
    orientations_.push_back(rotation_from_vector(k.turn));
  }
  velocities_ = smooth_slopes(times_, positions_);
  std::vector<Vec3> spins(keys.size(), Vec3::Zero());
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) turns_.push_back(turn_between(keys[k], keys[k + 1]));
  for (std::size_t k = 1; k + 1 < keys.size(); ++k) {
    const double h0 = times_[k] - times_[k - 1], h1 = times_[k + 1] - times_[k];
    spins[k] = smooth_slope(turns_[k - 1] / h0, turns_[k] / h1, h0, h1);
  }
  for (std::size_t k = 0; k < keys.size(); ++k) {
    velocities_[k] = keys[k].velocity.value_or(velocities_[k]);
    spins[k] = keys[k].spin.value_or(spins[k]);
  }
  for (std::size_t k = 0; k < turns_.size(); ++k) {
    turn_from_.push_back(spins[k]);
    const double past = std::remainder(turns_[k].norm(), 2.0 * std::numbers::pi);
    const bool singular = turns_[k].norm() > 1.0 && std::abs(past) < kWholeTurn;
    const Vec3 axis = turns_[k].normalized();
    turn_into_.push_back(singular ? Vec3(axis * axis.dot(spins[k + 1])) : slope_of_turn(turns_[k], spins[k + 1]));
  }
}

PlacedAt PoseCurve::at(double t) const {
  const HermiteWeights w = hermite_weights(times_, t);
  const std::size_t k = static_cast<std::size_t>(w.key);
  if (k >= turns_.size()) return {positions_[k], orientations_[k]};
  PlacedAt p;
  p.position = w.a * positions_[k] + w.b * velocities_[k] + w.c * positions_[k + 1] + w.d * velocities_[k + 1];
  p.orientation = (rotation_from_vector(turned(w)) * orientations_[k]).normalized();
  return p;
}

Vec3 PoseCurve::turned(const HermiteWeights& w) const {
  return w.b * turn_from_[w.key] + w.c * turns_[w.key] + w.d * turn_into_[w.key];
}

double PoseCurve::turning(double t, double u) const {
  const HermiteWeights from = hermite_weights(times_, t);
  HermiteWeights to = hermite_weights(times_, u);
  if (static_cast<std::size_t>(from.key) >= turns_.size()) return 0.0;
  // at the next key the piece before it has come to its end
  const Vec3 end = to.key == from.key ? turned(to) : turns_[from.key];
  return (end - turned(from)).norm();
}

}  // namespace sunder
