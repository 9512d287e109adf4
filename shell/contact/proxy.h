#pragma once
// Copies of rigid bodies for the shell: true mass and inertia, a signed distance. An impulse moves a copy at once.
#include <limits>
#include <memory>
#include <vector>

#include "coupler/core/body.h"
#include "shell/contact/driven_body.h"
#include "shell/contact/hull.h"
#include "shell/contact/solid_distance.h"

namespace sunder::shell {

/// Coulomb impulse on a surface sample [N s]; the caller books its negative on the body. n points out of the body, and
/// v_rel = v_sample - v_body [m/s]. `inverse_mass` is the change of v_rel per impulse [1/kg], symmetric and positive
/// definite. The sample sticks where Coulomb's law allows it; otherwise the impulse acts against v_rel.
Vec3 contact_impulse(const Vec3& n, const Vec3& v_rel, const Mat3& inverse_mass, double friction, double restitution);

/// What to do about a body that moves `travel` [m] in a substep, further than it is wide [m].
std::string slow_down(double travel, double wide, double safety);

class Proxy {
 public:
  /// `driven`: the motion that the scene prescribes; null: the body moves by impulses, or it is static.
  /// `arrived`: the time to which it has moved [s].
  explicit Proxy(RigidBody body, std::shared_ptr<const DrivenMotion> driven = nullptr, double arrived = 0.0);
  RigidBody body;
  // Share of an overlap with the shell that contact removes in a substep. Rows of the engine may press a body on after
  // contact has stopped it (link/held_rows.h). Without recovery the body would creep into the shell.
  double recovery = 0.0;
  bool unmoved = false;                 // impulses are counted and do not move the body: the lagged scheme
  Vec3 linear_impulse = Vec3::Zero();   // from the shell in this window [N s]
  Vec3 angular_impulse = Vec3::Zero();  // about the centre of mass [N m s]
  // The other side of the ledger: impulses on the shell's control points, with moments about their own places.
  Vec3 shell_linear = Vec3::Zero(), shell_angular = Vec3::Zero();
  double impulse_sum = 0.0;  // of |J| [N s]
  double moment_sum = 0.0;   // sum of the magnitudes of the moments on the shell's side [N m s]

  /// True where impulses change the motion of the body.
  bool is_free() const { return !body.is_static && !driven_; }
  bool is_driven() const { return driven_ != nullptr; }
  /// Triangles that a distance has to search; 0: none, the shape is convex or has parts that are.
  std::size_t triangles() const { return solid_ ? solid_->triangles() : 0; }
  /// True where the shape changes with time. The engine does not hold such a body.
  bool deforms() const { return driven_ && driven_->deforms(); }
  /// Moves a driven body to its place at time t, with the velocities that lead to its place at t + dt.
  void drive(double t, double dt);
  /// Moves a driven body to its place at time t and keeps its velocities. A shape that changes is drawn from now on.
  void arrive(double t);
  /// Work of a driven body on what takes impulse j from it at a world point [J].
  double work(const Vec3& world, const Vec3& j) const { return driven_ ? j.dot(velocity_at(world)) : 0.0; }

  struct Distance {
    double value;                 // [m], negative inside
    Vec3 normal;                  // outward, world
    Vec3 nearest = Vec3::Zero();  // point of a solid that is not convex, in body coordinates
    std::int32_t triangle = -1;   // of such a solid, that holds the point; -1: another shape
  };
  /// `guess`: the triangle of a point nearby. The distance is the same, and found sooner.
  Distance distance(const Vec3& world, std::int32_t guess = -1) const;
  /// A distance that was computed: no other point is nearer to the body by more than the way to it.
  struct Known {
    Vec3 local = Vec3::Zero();  // in body coordinates
    double value = -std::numeric_limits<double>::infinity();
    double moved = 0.0;          // of the shape, until then [m]
    std::int32_t triangle = -1;  // as in Distance
  };
  Known known(const Vec3& world, const Distance& distance) const;
  /// How far the distance may be from a known one of this body [m].
  double change_since(const Vec3& world, const Known& known) const;
  /// True where `known` tells that the distance is larger than `least`. `slack` covers round-off [m].
  bool surely_beyond(const Vec3& world, const Known& known, double least, double slack) const;
  /// Radius of a sphere about the centre that holds the body [m]; infinite for a half space.
  double radius() const { return radius_; }
  /// Half of the middle side of a box, or of the box around a solid that is not convex; `radius` for other shapes [m].
  /// A body with a smaller half width than the spacing of samples may pass between them.
  double half_width() const;
  /// Time to which a driven body has moved [s].
  double arrived() const { return arrived_; }
  /// True where a driven body has come to the end of its motion.
  bool has_arrived() const { return driven_ && arrived_ >= driven_->last(); }
  /// Speed of the centre now [m/s]; of a driven body the largest of all its points over the whole motion.
  double top_speed() const { return driven_ ? driven_->top_speed : body.motion.velocity.norm(); }
  /// Largest speed of its points relative to its centre [m/s].
  double turning_speed() const;
  /// Velocity of the body's material at a world point [m/s].
  Vec3 velocity_at(const Vec3& world) const;
  /// The same where the distance of that point is known.
  Vec3 velocity_at(const Vec3& world, const Distance& there) const;
  /// Change of the material's velocity at a world point per impulse there [1/kg].
  Mat3 inverse_mass_at(const Vec3& world) const;
  /// Applies impulse j [N s] at a world point and books it.
  void apply(const Vec3& world, const Vec3& j);

 private:
  std::vector<std::vector<Plane>> parts_;  // in body coordinates
  std::shared_ptr<SolidDistance> solid_;   // instead of parts_; copies of a proxy share it
  double radius_ = 0.0;
  std::shared_ptr<const DrivenMotion> driven_;
  Vec3 spin_ = Vec3::Zero();  // of a driven body [rad/s]
  double arrived_ = 0.0;      // [s]

  Vec3 rigid_velocity_at(const Vec3& world) const;
  Vec3 local(const Vec3& world) const { return body.motion.orientation.conjugate() * (world - body.motion.position); }
};

}  // namespace sunder::shell
