#pragma once
// Contact of soft bodies with rigid bodies.
#include <array>
#include <vector>

#include "shell/contact/proxy.h"
#include "shell/soft/press.h"
#include "shell/soft/soft_state.h"

namespace sunder::shell {

/// A surface point of a soft body that may press on a rigid body.
struct BodyPress {
  std::size_t body, copy;  // indices of the body and of its copy in PressScratch
  const SoftSurface* face;
  Vec3 x, normal;  // point [m]; normal out of the body
  double wanted, friction;
  std::array<std::size_t, kNodes * kNodes * kNodes> node;
  std::array<double, kNodes * kNodes * kNodes> weight;
  double own, along, across;  // inverse masses [1/kg]: of the nodes alone; of both sides, as `press` takes them
  Vec3 impulse = Vec3::Zero();
  Vec3 before;  // relative velocity before all impulses [m/s]
};

/// Working memory that is reused from step to step.
struct PressScratch {
  std::vector<Vec3> points, v;
  std::vector<BodyPress> presses;
  std::vector<Proxy> copies;
};

/// Applies impulses to the grid nodes of a soft body and to rigid bodies. At the end of the step of `dt` [s], no
/// surface point is inside a body. Contact is inelastic with Coulomb friction `friction[group]` [-]; projected
/// Gauss-Seidel solves all points together. Call it between `to_grid` and `from_grid`. Each impulse acts at the surface
/// point, on the body and, by the weights there, on the nodes, so the body's linear and angular ledger both close. The
/// work is booked. Returns the number of points that press.
int press_on_bodies(const SoftModel& model, SoftState& state, std::vector<Proxy>& bodies,
                    const std::vector<double>& friction, double dt, PressScratch& scratch);

}  // namespace sunder::shell
