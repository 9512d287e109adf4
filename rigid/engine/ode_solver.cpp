#include "rigid/engine/ode_solver.h"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <type_traits>

#include "coupler/core/error.h"

namespace sunder::rigid {
namespace {

static_assert(std::is_same_v<dReal, double>, "ode's headers are not those of the double precision build");

/// Largest number of rows of a group for the exact solver, whose time grows with their cube. Sweeps do not hold a stack
/// of plates.
constexpr int kExactRows = 500;
constexpr int kSweeps = 100;
constexpr double kOverRelaxation = 1.3;  // ODE's default
/// Softness of every row relative to its inverse mass. The exact solver factorises a matrix that would be singular,
/// because several corners of one plate are redundant.
constexpr double kOdeSoftness = 1e-9;  // [-]
/// Seed before each solve: QuickStep shuffles its rows by a process-wide random generator.
constexpr unsigned kSeed = 20;

/// Set by hear() where the exact solver gives up.
thread_local bool gave_up = false;

/// ODE's handler of messages.
void hear(int number, const char* message, va_list arguments) {
  gave_up = gave_up || number == d_ERR_LCP;
  if (number == d_ERR_LCP) return;
  std::fprintf(stderr, "ode: ");
  std::vfprintf(stderr, message, arguments);
  std::fputc('\n', stderr);
}

struct WorldDeleter {
  void operator()(dxWorld* world) const { dWorldDestroy(world); }  // with its bodies and joints
};

void set_pose(dBodyID body, const Vec3& x, const Quat& q) {
  dBodySetPosition(body, x.x(), x.y(), x.z());
  const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
  dBodySetQuaternion(body, turn);
}

dBodyID make_body(dWorldID world, const SolverBody& b) {
  dBodyID body = dBodyCreate(world);
  dMass mass;
  dMassSetParameters(&mass, b.mass, 0, 0, 0, b.inertia.x(), b.inertia.y(), b.inertia.z(), 0, 0, 0);
  dBodySetMass(body, &mass);
  dBodySetGyroscopicMode(body, 0);  // the predicted state includes the turn
  dBodySetLinearVel(body, b.velocity.x(), b.velocity.y(), b.velocity.z());
  dBodySetAngularVel(body, b.spin.x(), b.spin.y(), b.spin.z());
  return body;
}

/// Moves the bodies to poses without strain and makes the joint there, since ODE takes its frames from the bodies'
/// poses.
void make_joint(dWorldID world, const SolverJoint& j, dBodyID first, dBodyID second) {
  Vec3 at = Vec3::Zero();
  Quat frame = Quat::Identity();
  const auto put = [&](dBodyID body, const Joint::Frame& own) {
    const Quat turn = (frame * own.orientation.conjugate()).normalized();
    set_pose(body, at - turn * own.position, turn);
  };
  if (second)
    put(second, j.second_frame);
  else
    at = j.second_frame.position, frame = j.second_frame.orientation;
  put(first, j.first_frame);
  const Vec3 axis = frame * Vec3::UnitZ();
  dJointID joint = nullptr;
  switch (j.kind) {
    case Joint::Kind::kBall:
      dJointAttach(joint = dJointCreateBall(world, nullptr), first, second);
      dJointSetBallAnchor(joint, at.x(), at.y(), at.z());
      return;
    case Joint::Kind::kHinge:
      dJointAttach(joint = dJointCreateHinge(world, nullptr), first, second);
      dJointSetHingeAnchor(joint, at.x(), at.y(), at.z());
      dJointSetHingeAxis(joint, axis.x(), axis.y(), axis.z());
      return;
    case Joint::Kind::kSlider:
      dJointAttach(joint = dJointCreateSlider(world, nullptr), first, second);
      dJointSetSliderAxis(joint, axis.x(), axis.y(), axis.z());
      return;
    case Joint::Kind::kFixed:
      dJointAttach(joint = dJointCreateFixed(world, nullptr), first, second);
      dJointSetFixed(joint);
      return;
  }
}

dJointID make_contact(dWorldID world, const SolverContact& c, const std::vector<SolverBody>& bodies, double offset) {
  dContact contact = {};
  contact.surface.mode = dContactApprox1 | dContactFDir1 | dContactMotionN;
  contact.surface.mu = c.friction;
  contact.surface.motionN = c.target - offset;
  contact.geom.depth = 0.0;  // gaps are part of the target; ODE must not correct positions
  for (int i = 0; i < 3; ++i) contact.geom.pos[i] = c.point[i], contact.geom.normal[i] = c.normal[i];
  const Vec3 direction = slip_direction(c, bodies);
  for (int i = 0; i < 3; ++i) contact.fdir1[i] = direction[i];
  return dJointCreateContact(world, nullptr, &contact);
}

/// Solves one group in an ODE world of its own, so that the result does not depend on earlier windows or other groups.
/// False, without a change, where the solver fails.
bool solve_island(double window_s, double joint_share, bool exactly, std::vector<SolverBody>& bodies, Island& island) {
  const std::unique_ptr<dxWorld, WorldDeleter> owner(dWorldCreate());
  dWorldID world = owner.get();
  double least_mass = bodies[island.bodies.front()].mass;
  std::vector<dBodyID> made(bodies.size(), nullptr);
  for (const int i : island.bodies) {
    made[i] = make_body(world, bodies[i]);
    least_mass = std::min(least_mass, bodies[i].mass);
  }
  const auto of = [&](int i) { return i < 0 ? nullptr : made[i]; };
  for (const SolverJoint* j : island.joints) make_joint(world, *j, of(j->first), of(j->second));
  for (const int i : island.bodies) set_pose(made[i], bodies[i].position, bodies[i].orientation);
  std::vector<dJointFeedback> feedback(island.contacts.size());
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const SolverContact& c = *island.contacts[i];
    dJointID joint = make_contact(world, c, bodies, target_offset(i));
    dJointAttach(joint, of(c.first), of(c.second));
    feedback[i] = {};
    dJointSetFeedback(joint, &feedback[i]);
  }
  dWorldSetERP(world, joint_share);
  dWorldSetCFM(world, kOdeSoftness * window_s / least_mass);  // ODE's unit: softness [1/(N s)] times the window
  gave_up = false;
  if (exactly) {
    dWorldStep(world, window_s);
  } else {
    dRandSetSeed(kSeed);
    dWorldSetQuickStepNumIterations(world, kSweeps);
    dWorldSetQuickStepW(world, kOverRelaxation);
    dWorldQuickStep(world, window_s);
  }
  const auto spin_of = [&](int i) { return Eigen::Map<const Vec3>(dBodyGetAngularVel(made[i])); };
  const auto velocity_of = [&](int i) { return Eigen::Map<const Vec3>(dBodyGetLinearVel(made[i])); };
  for (const int i : island.bodies) gave_up = gave_up || !velocity_of(i).allFinite() || !spin_of(i).allFinite();
  if (gave_up) return false;
  for (const int i : island.bodies) bodies[i].velocity = velocity_of(i), bodies[i].spin = spin_of(i);
  for (std::size_t i = 0; i < island.contacts.size(); ++i) {
    const dReal* f = feedback[i].f1;
    island.contacts[i]->acted = island.contacts[i]->normal.dot(Vec3(f[0], f[1], f[2])) > 0.0;
  }
  return true;
}

}  // namespace

void OdeSolver::solve(double window_s, double joint_share, std::vector<SolverBody>& bodies,
                      const std::vector<SolverJoint>& joints, std::vector<SolverContact>& contacts) {
  for (Island& island : islands(bodies.size(), joints, contacts)) {
    if (island.rows() <= kExactRows && solve_island(window_s, joint_share, true, bodies, island)) continue;
    if (!solve_island(window_s, joint_share, false, bodies, island))
      throw Error(Exit::kPhysics, "engine",
                  fmt::format("ode finds no finite velocities for {} bodies with {} contacts and {} joints",
                              island.bodies.size(), island.contacts.size(), island.joints.size()));
  }
}

OdeSolver::OdeSolver() {
  if (!dCheckConfiguration("ODE_double_precision"))
    throw Error(Exit::kBadInput, "bad_engine",
                fmt::format("the ode library at hand is not the double precision build ({}); install libode8 of Debian",
                            dGetConfiguration()));
  ensure(dInitODE2(0) != 0, "ode does not start");
  dSetMessageHandler(hear);
}

OdeSolver::~OdeSolver() { dCloseODE(); }

std::string OdeSolver::version() const { return dODE_VERSION; }

}  // namespace sunder::rigid
