#include "coupler/core/vec.h"

#include <cmath>

namespace sunder {

Quat rotation_from_vector(const Vec3& w) {
  const double angle = w.norm();
  // sin(a/2)/a; for small a its series, because the quotient would lose digits
  const double s = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return Quat(std::cos(0.5 * angle), s * w.x(), s * w.y(), s * w.z());
}

Vec3 rotation_vector(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;  // q and -q are one rotation; take the shorter one
  const Vec3 u = sign * q.vec();
  const double s = u.norm();
  if (s < 1e-12) return 2.0 * u;
  return (2.0 * std::atan2(s, sign * q.w()) / s) * u;
}

}  // namespace sunder
