#pragma once
// Soft bodies against rigid ones.
#include <array>
#include <vector>

#include "shell/contact/proxy.h"
#include "shell/soft/press.h"
#include "shell/soft/soft_state.h"

namespace sunder::shell {

/// One point that may press on a body.
struct BodyPress {
  std::size_t body, copy;
  const SoftSurface* face;
  Vec3 x, normal;  // out of the body
  double wanted, friction;
  std::array<std::size_t, kNodes * kNodes * kNodes> node;
  std::array<double, kNodes * kNodes * kNodes> weight;
  double own, along, across;  // inverse masses: of the nodes, and of both as `press` takes them [1/kg]
  Vec3 impulse = Vec3::Zero();
  Vec3 before;  // relative velocity before all impulses [m/s]
};

/// Kept from step to step.
struct PressScratch {
  std::vector<Vec3> points, v;
  std::vector<BodyPress> presses;
  std::vector<Proxy> copies;
};

/// Between `to_grid` and `from_grid`: impulses on grid nodes where points of the surface would be inside a body at the
/// end of the step, inelastic and with Coulomb's friction, all of them together by projected Gauss-Seidel. Each acts
/// at the surface, on the body and, by the weights there, on the nodes: both pages of the body's ledger close.
/// `friction[group]` [-]. Their work is booked. Returns the number of points that press.
int press_on_bodies(const SoftModel& model, SoftState& state, std::vector<Proxy>& bodies,
                    const std::vector<double>& friction, double dt, PressScratch& scratch);

}  // namespace sunder::shell
