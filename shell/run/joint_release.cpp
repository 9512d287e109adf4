// Release of joints that break.
#include <algorithm>
#include <cmath>

#include "shell/run/coupler.h"

namespace sunder::shell {
namespace {

Joint::Frame placed(const Proxy* body, const Joint::Frame& f) {
  if (!body) return f;
  const BodyMotion& m = body->body.motion;
  return {m.position + m.orientation * f.position, m.orientation * f.orientation};
}

}  // namespace

// The frames of an unstrained joint coincide at the start, so their distance measures its strain.
void Coupler::release_joints() {
  const auto body = [&](BodyId id) -> const Proxy* { return id == 0 ? nullptr : &state_.bodies[id - 1]; };
  for (std::size_t i = 0; i < setup_.joints.size(); ++i) {
    const JointBreak& b = setup_.breaks[i];
    if (released_at_[i] >= 0.0 || !b.can()) continue;
    const Joint& j = setup_.joints[i];
    const Joint::Frame first = placed(body(j.first), j.first_frame), second = placed(body(j.second), j.second_frame);
    const double angle = rotation_vector(second.orientation.conjugate() * first.orientation).norm();
    const double extension = std::abs((first.position - second.position).dot(second.orientation * Vec3::UnitZ()));
    if (clock_.time() < b.time - 1e-6 * setup_.tick && angle < b.angle && extension < b.extension) continue;
    released_at_[i] = clock_.time();
    released_.insert(std::upper_bound(released_.begin(), released_.end(), j.id), j.id);
  }
}

}  // namespace sunder::shell
