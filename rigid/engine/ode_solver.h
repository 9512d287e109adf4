#pragma once
// Contacts and joints at one instant, solved for velocities by ODE. Private to the adapter.
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// A moving body. The solver changes its velocities only.
struct SolverBody {
  double mass = 0.0;                                  // [kg]
  Vec3 inertia = Vec3::Zero();                        // principal moments [kg m^2]
  Vec3 position = Vec3::Zero();                       // [m]
  Quat orientation = Quat::Identity();                // body axes to world
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // world [m/s], [rad/s]
};

/// A contact of two bodies, or of a body and the world (second = -1). The solved relative velocity along the normal is
/// at least `target`.
struct SolverContact {
  int first = 0, second = -1;
  Vec3 point = Vec3::Zero();    // world [m]
  Vec3 normal = Vec3::UnitZ();  // from the second body to the first
  double friction = 0.0;        // [-]
  double target = 0.0;          // [m/s]; negative where a gap may close
  bool acted = false;           // set by the solver: the contact has an impulse
};

/// A joint of two bodies, or of a body and the world.
struct SolverJoint {
  Joint::Kind kind = Joint::Kind::kBall;
  int first = 0, second = -1;              // -1: the world
  Joint::Frame first_frame, second_frame;  // in body or world coordinates
};

/// Solves each group of connected bodies: a small one exactly (dWorldStep), a large one by sweeps (dWorldQuickStep).
/// `joint_share`: share of the joints' error that a window of `window_s` seconds removes [-]. Bodies without contacts
/// and joints keep their velocities to the bit. There is no state: the same arguments give the same bits. Throws Error
/// (engine) where ODE finds no finite velocities.
void solve_velocities(double window_s, double joint_share, std::vector<SolverBody>& bodies,
                      const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts);

/// Keeps ODE initialised, as the solver needs. Throws Error (bad_engine) where the library is not built in double
/// precision.
class OdeLibrary {
 public:
  OdeLibrary();
  ~OdeLibrary();
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

/// Version of the library, as "0.16.2".
const char* ode_version();

}  // namespace sunder::rigid
