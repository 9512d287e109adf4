#pragma once
// Contacts and joints between rigid bodies that the shell process solves in its substeps instead of the engine.
#include <unordered_map>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::link {

/// Projected Gauss-Seidel on velocities, started from the impulses of the previous substep. A contact may close its gap
/// in the substep but not overlap. A joint ends the substep without strain (SHAKE, one Newton step). So neither needs a
/// spring. An impulse acts on both bodies at one point, which keeps momentum and angular momentum to round-off.
class HeldRows {
 public:
  /// Takes the rows and joints of one window. `bodies` has each body that they name and outlives the window. Contacts
  /// that were there in the window before start from their impulses.
  void take(const std::vector<ContactRow>& rows, const std::vector<Joint>& joints,
            const std::vector<RigidBody*>& bodies);
  /// Drops all rows and joints.
  void clear() { contacts_.clear(), joints_.clear(); }
  bool empty() const { return contacts_.empty() && joints_.empty(); }
  /// Changes the bodies' velocities for a substep of `h` seconds, before the bodies move. Returns the kinetic energy
  /// that this dissipates [J].
  double solve(double h);

 private:
  struct Contact {
    RigidBody *first = nullptr, *second = nullptr;
    ContactRow row;
    Vec3 side = Vec3::UnitX(), other = Vec3::UnitY();  // tangents, world
    Vec3 impulse = Vec3::Zero();                       // along normal, side, other [N s]
    double target = 0.0;                               // least relative normal velocity [m/s]
    Mat3 inverse = Mat3::Zero();  // inverse mass along the three axes: relative velocity per impulse [1/kg]
    Vec3 first_arm = Vec3::Zero(), second_arm = Vec3::Zero();  // from centres to the point of the impulse [m]
  };
  struct Bilateral {
    RigidBody *first = nullptr, *second = nullptr;  // second null: the world
    Joint joint;
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // impulses of the last substep, in the axes below
    Mat3 axes = Mat3::Identity();                        // columns, world
    Vec3 linear_target = Vec3::Zero(), angular_target = Vec3::Zero();
    Vec3 first_arm = Vec3::Zero(), second_arm = Vec3::Zero();
    Mat3 point_mass = Mat3::Zero(), turn_mass = Mat3::Zero();  // effective mass and inertia along the held axes
    int held_linear = 3, held_angular = 0;
  };
  void prepare(Contact& c, double h);
  void prepare(Bilateral& b, double h);
  static double sweep(Contact& c);
  static double sweep(Bilateral& b);
  double kinetic() const;

  std::vector<Contact> contacts_;
  std::vector<Bilateral> joints_;
  std::vector<RigidBody*> touched_;  // moving bodies of all rows and joints
};

}  // namespace sunder::link
