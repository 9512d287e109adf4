#pragma once
// A soft body of particles: what changes during a run, and one step of it over its background grid.
//
// MLS-MPM (Hu et al. 2018) with APIC (Jiang et al. 2015) and quadratic B-splines. Positions and deformation gradients
// stand at t, velocities and the affine field half a step earlier (leapfrog; steps may differ). Transfers keep linear
// and angular momentum to round-off; what they lose of the energy is booked as `transfer`.
#include <vector>

#include "coupler/core/archive.h"
#include "shell/grid/stencil.h"
#include "shell/soft/soft_model.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// The body's own nodes, of one step.
struct SoftGrid {
  SparseGrid blocks;
  std::vector<int> block;             // [particle][kBlocks]
  std::vector<double> mass;           // of each node [kg]; 0: none
  std::vector<Vec3> v, acceleration;  // [m/s], [m/s^2] of forces and gravity
};

struct SoftState {
  std::vector<Vec3> x, v;       // [m], [m/s]
  std::vector<Mat3> affine, f;  // gradient of the velocity [1/s], deformation gradient
  double dt = 0.0;              // of the last step [s]; 0: velocities stand at t as well
  EnergyBook book{};
  SoftGrid grid{};
  std::vector<Mat3> stress{};  // scratch: of each particle, as a node's force needs it [N/m]
  std::vector<double> energy{}, power{};
  double work = 0.0;  // that forces and gravity do a second on the velocities before the kick [W]

  Stencil stencil(const SoftModel& m, int particle) const {
    const Vec3& p = x[particle];
    return {p.x(), p.y(), p.z(), m.grid};
  }
  /// f(node, weight, offset from the particle [m]) after `to_grid`.
  template <class F>
  void each_node(const SoftModel& m, int particle, F&& g) const {
    stencil(m, particle).each(&grid.block[static_cast<std::size_t>(kBlocks) * particle], g);
  }
  /// A face's point of the surface from its particle [m], and its normal (not unit).
  Vec3 above(const SoftSurface& face) const { return face.depth * (f[face.particle] * face.normal); }
  Vec3 surface_point(const SoftSurface& face) const { return x[face.particle] + above(face); }
  Vec3 surface_normal(const SoftSurface& face) const;
  /// f(node, weight, offset from the particle [m]) as the surface's point moves: with the particle and its gradient.
  /// The weights sum to one and to that point, so an impulse that nodes take by them acts just there; some are
  /// negative. All of these nodes have mass, which those around the point itself may not.
  template <class F>
  void each_surface_node(const SoftModel& m, const SoftSurface& face, F&& g) const {
    const Vec3 up = 4.0 / (m.grid * m.grid) * above(face);
    each_node(m, face.particle, [&](std::size_t k, double w, const double* d) {
      g(k, w * (1.0 + up.x() * d[0] + up.y() * d[1] + up.z() * d[2]), d);
    });
  }
};

/// Undeformed, `velocity` [m/s] of its centre of mass and `angular` [rad/s] about it.
SoftState make_soft_state(const SoftModel& model, const Vec3& velocity, const Vec3& angular);

/// Velocities to the grid, forces there, and the kick to half of `dt` after the positions' time. Throws Error
/// (soft_inverted) where a particle has turned inside out.
void to_grid(const SoftModel& model, SoftState& state, const Vec3& gravity, double dt, int threads);
/// What impulses have left of the grid's velocities goes back, and particles drift by `dt`.
void from_grid(const SoftModel& model, SoftState& state, double dt, int threads);

/// Steps are stable below this [s]: kCourant grid spacings over the fastest wave of any particle as it is deformed.
double soft_stable_step(const SoftModel& model, const SoftState& state);
constexpr double kCourant = 0.8;

/// Sums over particles. Kinetic energy is that of the positions' time, half a kick after the velocities; angular
/// momentum about the origin counts the affine field.
struct SoftSums {
  double mass = 0.0, kinetic = 0.0, elastic = 0.0, potential = 0.0;  // [kg], [J]
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero(), centre = Vec3::Zero();
  double momentum_scale = 0.0, angular_scale = 0.0;  // sums of magnitudes
};
SoftSums soft_sums(const SoftModel& model, const SoftState& state, const Vec3& gravity);

/// Von Mises' equivalent of the Cauchy stress [Pa].
double von_mises(const SoftModel& model, const Mat3& f);

template <class A>
void archive(A& a, SoftState& s) {
  archive_all(a, s.x, s.v, s.affine, s.f, s.dt, s.book);
}

}  // namespace sunder::shell
