#pragma once
// Contacts and joints of one instant, solved for velocities by ODE. Private to the adapter.
#include <vector>

#include "coupler/core/body.h"

namespace sunder::rigid {

/// A body that moves. The solver changes its velocities, and nothing else.
struct SolverBody {
  double mass = 0.0;                                  // [kg]
  Vec3 inertia = Vec3::Zero();                        // principal [kg m^2]
  Vec3 position = Vec3::Zero();                       // [m]
  Quat orientation = Quat::Identity();                //
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // world [m/s], [rad/s]
};

/// Two bodies, or a body and the world (second = -1), separate along the normal with at least the velocity `target`.
struct SolverContact {
  int first = 0, second = -1;
  Vec3 point = Vec3::Zero();    // world [m]
  Vec3 normal = Vec3::UnitZ();  // from the second body to the first
  double friction = 0.0;        // [-]
  double target = 0.0;          // [m/s]; negative: a gap that may close
  bool acted = false;           // pushed; said by the solver
};

struct SolverJoint {
  Joint::Kind kind = Joint::Kind::kBall;
  int first = 0, second = -1;              // -1: the world
  Joint::Frame first_frame, second_frame;  // in body coordinates, or the world's
};

/// Solves what hangs together exactly (dWorldStep) where it is small, by sweeps (dWorldQuickStep) where it is not.
/// `joint_share` of the joints' error is taken back within `window_s`. Bodies that nothing pushes keep their velocities
/// to the bit. No state: the same arguments give the same bits.
void solve_velocities(double window_s, double joint_share, std::vector<SolverBody>& bodies,
                      const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts);

/// ODE must be initialised while any solver runs; one of these keeps it so. Throws Error (bad_engine) where the
/// library is not the double precision one.
class OdeLibrary {
 public:
  OdeLibrary();
  ~OdeLibrary();
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

/// "0.16.2"
const char* ode_version();

}  // namespace sunder::rigid
