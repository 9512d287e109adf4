#pragma once
// Contacts and joints at one instant, solved for velocities by a library. WindowEngine does the rest of a window.
#include <string>
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

/// A library that solves for velocities.
class VelocitySolver {
 public:
  virtual ~VelocitySolver() = default;
  /// Name and version of the engine, as EngineInfo has them.
  virtual std::string name() const = 0;
  virtual std::string version() const = 0;
  /// Solves for contacts and joints. `joint_share`: share of the joints' error that a window of `window_s` seconds
  /// removes [-]. Bodies without contacts and joints keep their velocities to the bit. Nothing is remembered: the same
  /// arguments give the same bits. Throws Error (engine) where the library finds no finite velocities.
  virtual void solve(double window_s, double joint_share, std::vector<SolverBody>& bodies,
                     const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts) = 0;
};

/// A group of connected bodies.
struct Island {
  std::vector<int> bodies;
  std::vector<const SolverJoint*> joints;
  std::vector<SolverContact*> contacts;

  /// Number of rows of the solver.
  int rows() const;
};

/// Groups that have contacts or joints.
std::vector<Island> islands(std::size_t body_count, const std::vector<SolverJoint>& joints,
                            std::vector<SolverContact>& contacts);

/// Velocity of the body's point that is at `point` (world) [m/s].
inline Vec3 velocity_at(const SolverBody& b, const Vec3& point) {
  return b.velocity + b.spin.cross(point - b.position);
}

/// The first direction of friction, which follows the slip. A fixed pair of directions would resist up to sqrt(2) as
/// much between the two.
Vec3 slip_direction(const SolverContact& contact, const std::vector<SolverBody>& bodies);

/// A small offset of the target of a row [m/s]. Exact solvers of complementarity fail where corners of a symmetric
/// stack separate at the same instant, so each row gets another one.
double target_offset(std::size_t row);

}  // namespace sunder::rigid
