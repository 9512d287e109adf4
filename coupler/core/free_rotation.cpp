// The kinetic energy of rotation is split in two, as Fasso 2003 does: that of a top with two equal moments, and the
// rest, sum over one axis a of L_a^2 (1/I_a - 1/I_b) / 2. Both parts turn a body in closed form and leave the angular
// momentum as it is. Their symmetric composition keeps energy over any number of turns, except for an error that is
// bounded. Five of these in Suzuki's order (1990) are of fourth order.
#include "coupler/core/free_rotation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sunder {
namespace {

constexpr double kTurn = 0.1;        // most turn in a step [rad]
constexpr double kSmallTurn = 5e-4;  // up to here one symmetric composition is as exact as five [rad]
constexpr int kMostSteps = 10000;    // some 160 turns at full accuracy

/// The two parts of the energy. Rates are per angular momentum [1/(kg m^2)].
struct Split {
  int rest, axis;     // body axes: that of the rest, and that of the top
  double mean;        // of the top about the angular momentum: 1/I_b
  double about_top;   // of the top about its axis beside: 1/I_axis - 1/I_b
  double about_rest;  // 1/I_rest - 1/I_b
};

/// Chooses the axis such that the other two moments are nearly equal: the rest is least.
Split split(const Vec3& inertia) {
  const Vec3 inverse = inertia.cwiseInverse();
  int axis = 0;
  double least = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const double apart = std::abs(inverse[(k + 1) % 3] - inverse[(k + 2) % 3]);
    if (apart < least) least = apart, axis = k;
  }
  int rest = (axis + 1) % 3, other = (axis + 2) % 3;
  if (inertia[rest] > inertia[other]) std::swap(rest, other);
  return {rest, axis, inverse[other], inverse[axis] - inverse[other], inverse[rest] - inverse[other]};
}

void turn_rest(const Split& s, const Vec3& momentum, double h, Quat& q) {
  const double along = (q.conjugate() * momentum)[s.rest];
  q = q * rotation_from_vector(h * along * s.about_rest * Vec3::Unit(s.rest));
}

void turn_top(const Split& s, const Vec3& momentum, double h, Quat& q) {
  const double along = (q.conjugate() * momentum)[s.axis];
  q = rotation_from_vector(h * s.mean * momentum) * q *
      rotation_from_vector(h * along * s.about_top * Vec3::Unit(s.axis));
}

}  // namespace

Quat free_rotation(const Vec3& inertia, const Vec3& momentum, const Quat& start, double h) {
  const Split s = split(inertia);
  Quat q = start;
  if (s.about_rest == 0.0) {
    turn_top(s, momentum, h, q);
    return q.normalized();
  }
  const double first = 1.0 / (4.0 - std::cbrt(4.0));
  const std::array<double, 5> shares{first, first, 1.0 - 4.0 * first, first, first};
  double left = h;
  for (int done = 0; left != 0.0; ++done) {
    const Vec3 local = (q.conjugate() * momentum).cwiseAbs();
    const double rate = local.norm() * s.mean + local[s.axis] * std::abs(s.about_top) + local[s.rest] * s.about_rest;
    const double steps = std::max(1.0, std::ceil(rate * std::abs(left) / kTurn));
    const double step = left / steps;
    if (rate * std::abs(left) <= kSmallTurn || done == kMostSteps) {
      turn_rest(s, momentum, 0.5 * left, q);
      turn_top(s, momentum, left, q);
      turn_rest(s, momentum, 0.5 * left, q);
      return q.normalized();
    }
    turn_rest(s, momentum, 0.5 * shares[0] * step, q);
    for (int k = 0; k < 5; ++k) {
      turn_top(s, momentum, shares[k] * step, q);
      turn_rest(s, momentum, 0.5 * (shares[k] + (k < 4 ? shares[k + 1] : 0.0)) * step, q);
    }
    q.normalize();
    left = steps == 1.0 ? 0.0 : left - step;
  }
  return q;
}

}  // namespace sunder
