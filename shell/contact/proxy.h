#pragma once
// Bodies as the shell meets them: true mass and inertia, a signed distance, moved by each impulse at once.
#include <memory>
#include <vector>

#include "coupler/core/body.h"
#include "shell/contact/hull.h"
#include "shell/contact/solid_distance.h"

namespace sunder::shell {

/// Coulomb impulse on a surface sample [N s]; the caller books its negative on the body.
/// n points out of the body, v_rel = v_sample - v_body [m/s]; `inverse_mass` of the pair: the change of v_rel
/// per impulse [1/kg], symmetric positive definite. Sticks where Coulomb allows it, else slides against v_rel.
Vec3 contact_impulse(const Vec3& n, const Vec3& v_rel, const Mat3& inverse_mass, double friction, double restitution);

class Proxy {
 public:
  explicit Proxy(RigidBody body);
  RigidBody body;
  // Share of an overlap with the shell that contact takes back in a substep: where rows press the body on after contact
  // has stopped it (link/held_rows.h), it would creep in by a little every time.
  double recovery = 0.0;
  bool unmoved = false;                 // by impulses, which are only counted: the lagged scheme
  Vec3 linear_impulse = Vec3::Zero();   // from the shell in this window [N s]
  Vec3 angular_impulse = Vec3::Zero();  // about the centre of mass [N m s]
  // The ledger's other page: what the shell's control points received, summed where they are.
  Vec3 shell_linear = Vec3::Zero(), shell_angular = Vec3::Zero();
  double impulse_sum = 0.0;  // of |J| [N s]
  double moment_sum = 0.0;   // of the moments on the shell's page, each entry's magnitude [N m s]

  struct Distance {
    double value;  // [m], negative inside
    Vec3 normal;   // outward, world
  };
  Distance distance(const Vec3& world) const;
  double radius() const { return radius_; }  // of a sphere about the centre that holds the body; infinite: half space
  /// Half of the second of the sides of a box, or of that around a solid that is no hull; `radius` of other shapes:
  /// what is less may pass between samples [m].
  double half_width() const;
  /// v of the body's material at a world point [m/s].
  Vec3 velocity_at(const Vec3& world) const;
  /// Change of the material's velocity at a world point per impulse there [1/kg].
  Mat3 inverse_mass_at(const Vec3& world) const;
  /// The body takes impulse j at a world point and books it.
  void apply(const Vec3& world, const Vec3& j);

 private:
  std::vector<std::vector<Plane>> parts_;       // in body coordinates
  std::shared_ptr<const SolidDistance> solid_;  // in their place; copies of a proxy share it
  double radius_ = 0.0;
};

}  // namespace sunder::shell
