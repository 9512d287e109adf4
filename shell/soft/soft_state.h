#pragma once
// State of a soft body of particles, and one step over its background grid.
//
// The method is MLS-MPM (Hu et al. 2018) with APIC (Jiang et al. 2015) and quadratic B-splines. Positions and
// deformation gradients are those of time t. Velocities and affine fields are those of half a step earlier (leapfrog
// with variable steps). Transfers conserve linear and angular momentum to round-off; the energy that they lose is
// booked as `transfer`.
#include <vector>

#include "coupler/core/archive.h"
#include "shell/grid/stencil.h"
#include "shell/soft/soft_model.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// The background grid of one body in one step.
struct SoftGrid {
  SparseGrid blocks;
  std::vector<int> block;             // [particle][kBlocks]
  std::vector<double> mass;           // of each node [kg]; 0 for a node without particles
  std::vector<Vec3> v, acceleration;  // [m/s]; [m/s^2], from forces and gravity
};

/// Particles of a soft body, its energy book, and the grid and scratch of the current step.
struct SoftState {
  std::vector<Vec3> x, v;       // [m], [m/s]
  std::vector<Mat3> affine, f;  // velocity gradient [1/s]; deformation gradient
  double dt = 0.0;              // last step [s]; 0 at the start, where velocities are those of time t
  EnergyBook book{};
  SoftGrid grid{};
  // scratch, of each particle: 4/grid^2 times volume times Kirchhoff stress, negative [N/m]
  std::vector<Mat3> stress{};
  std::vector<double> energy{}, power{};
  double work = 0.0;  // power of forces and gravity on the velocities before the kick [W]

  /// Calls f with all members that the hash of a run takes.
  template <class Self, class F>
  static void hashed(Self& self, F&& f) {
    f(self.x, self.v, self.f, self.affine);
  }
  /// Calls f with all members that a checkpoint saves.
  template <class F>
  void saved(F&& f) {
    hashed(*this, f);
    f(dt, book);
  }
  /// The kernel of a particle on the grid.
  Stencil stencil(const SoftModel& m, int particle) const {
    const Vec3& p = x[particle];
    return {p.x(), p.y(), p.z(), m.grid};
  }
  /// Calls g(node, weight, offset from the particle [m]) for each node of a particle; valid after `to_grid`.
  template <class F>
  void each_node(const SoftModel& m, int particle, F&& g) const {
    stencil(m, particle).each(&grid.block[static_cast<std::size_t>(kBlocks) * particle], g);
  }
  /// Returns the vector [m] from the particle to its face's surface point.
  Vec3 above(const SoftSurface& face) const { return face.depth * (f[face.particle] * face.normal); }
  Vec3 surface_point(const SoftSurface& face) const { return x[face.particle] + above(face); }
  Vec3 surface_normal(const SoftSurface& face) const;  // not of unit length
  /// Calls g(node, weight, offset from the particle [m]) for the nodes of a surface point. The weights add up to one
  /// and their mean offset is the surface point, so an impulse shared by them acts exactly there. Some weights are
  /// negative. All these nodes have mass; nodes around the surface point itself may have none.
  template <class F>
  void each_surface_node(const SoftModel& m, const SoftSurface& face, F&& g) const {
    const Vec3 up = 4.0 / (m.grid * m.grid) * above(face);
    each_node(m, face.particle, [&](std::size_t k, double w, const double* d) {
      g(k, w * (1.0 + up.x() * d[0] + up.y() * d[1] + up.z() * d[2]), d);
    });
  }
};

/// Makes an undeformed state: `velocity` [m/s] of the centre of mass and `angular` velocity [rad/s] about it.
SoftState make_soft_state(const SoftModel& model, const Vec3& velocity, const Vec3& angular);

/// Transfers mass and momentum to the grid, computes forces there, and kicks velocities to half of `dt` [s] after the
/// time of the positions. Throws Error (soft_inverted) where a particle has turned inside out.
void to_grid(const SoftModel& model, SoftState& state, const Vec3& gravity, double dt, int threads);
/// Transfers the grid's velocities, contact impulses included, back to the particles, which drift by `dt` [s].
void from_grid(const SoftModel& model, SoftState& state, double dt, int threads);

/// Returns the stable step [s]: kCourant grid spacings divided by the speed of the fastest wave of any deformed
/// particle.
double soft_stable_step(const SoftModel& model, const SoftState& state);
constexpr double kCourant = 0.8;

/// Sums over particles. Kinetic energy is that of the time of the positions, half a kick after the velocities. Angular
/// momentum is about the origin and includes the affine field.
struct SoftSums {
  double mass = 0.0, kinetic = 0.0, elastic = 0.0, potential = 0.0;  // [kg], [J]
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero(), centre = Vec3::Zero();
  double momentum_scale = 0.0, angular_scale = 0.0;  // sums of magnitudes
};
/// Computes the sums of one soft body in a field of gravity [m/s^2].
SoftSums soft_sums(const SoftModel& model, const SoftState& state, const Vec3& gravity);

/// Returns the von Mises equivalent of the Cauchy stress [Pa] at the deformation gradient `f`.
double von_mises(const SoftModel& model, const Mat3& f);

template <class A>
void archive(A& a, SoftState& s) {
  s.saved([&a](auto&... members) { archive_all(a, members...); });
}

}  // namespace sunder::shell
