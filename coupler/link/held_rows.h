#pragma once
// Contacts and joints between rigid bodies that the shell's side solves in its substeps, in the engine's place.
#include <unordered_map>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::link {

/// Projected Gauss-Seidel on velocities, started from the impulses of the substep before. A contact may close its gap
/// within the substep and no more; a joint ends the substep without strain (SHAKE, one Newton step), so that neither
/// needs a spring. Impulses act on both bodies at one point: momentum and angular momentum are kept to round-off.
class HeldRows {
 public:
  /// For one window. `bodies` outlives it; each body that a row or joint names is there.
  void take(const std::vector<ContactRow>& rows, const std::vector<Joint>& joints,
            const std::vector<RigidBody*>& bodies);
  void clear() { contacts_.clear(), joints_.clear(); }
  bool empty() const { return contacts_.empty() && joints_.empty(); }
  /// Velocities of a substep of `h` seconds, which the bodies take after it. Returns the kinetic energy that this took
  /// [J].
  double solve(double h);

 private:
  struct Contact {
    RigidBody *first = nullptr, *second = nullptr;
    ContactRow row;
    Vec3 side = Vec3::UnitX(), other = Vec3::UnitY();  // tangents, world
    Vec3 impulse = Vec3::Zero();                       // along normal, side, other [N s]
    double target = 0.0;                               // of the relative normal velocity [m/s]
    Mat3 inverse = Mat3::Zero();  // mass along the three: change of the relative velocity per impulse [1/kg]
    Vec3 first_arm = Vec3::Zero(), second_arm = Vec3::Zero();  // to the point where the impulse acts [m]
  };
  struct Bilateral {
    RigidBody *first = nullptr, *second = nullptr;  // second null: the world
    Joint joint;
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // impulses of the last substep, in the axes below
    Mat3 axes = Mat3::Identity();                        // columns, world
    Vec3 linear_target = Vec3::Zero(), angular_target = Vec3::Zero();
    Vec3 first_arm = Vec3::Zero(), second_arm = Vec3::Zero();
    Mat3 point_mass = Mat3::Zero(),
         turn_mass = Mat3::Zero();  // inverses of what an impulse does, over the axes that are held
    int held_linear = 3, held_angular = 0;
  };
  void prepare(Contact& c, double h);
  void prepare(Bilateral& b, double h);
  static double sweep(Contact& c);
  static double sweep(Bilateral& b);
  double kinetic() const;

  std::vector<Contact> contacts_;
  std::vector<Bilateral> joints_;
  std::vector<RigidBody*> touched_;  // that move
};

}  // namespace sunder::link
