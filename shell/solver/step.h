#pragma once
// One substep of a shell with the bodies that it meets.
#include <Eigen/Geometry>

#include "shell/contact/proxy.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// How the shell and each proxy, by index, push one another.
struct ContactCoefficients {
  double friction = 0.5, restitution = 0.0;
  double hertz = 0.0;  // stiffness of a sphere by Hertz's law, F = k d^3/2, without friction [N/m^1.5]; 0: impulses
};

/// Which surface samples may meet which body within the next substeps; refreshed every so often.
struct ContactCandidates {
  struct Sample {
    int block, lane;
    int first = 0;  // substeps from the refresh in which it cannot touch
  };
  std::vector<std::vector<Sample>> of_body;
  // Scratch of the search: where samples are, found once however many bodies ask.
  struct Place {
    Vec3 x;
    std::uint32_t refresh = 0;  // in which it was found
    bool there = false;
  };
  std::vector<Place> places;
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<GatheredFunction> functions;
  std::uint32_t refresh = 0;
  int age = 0;  // substeps since the refresh
};
constexpr int kContactRefresh = 16;  // substeps

void refresh_candidates(const ShellModel& model, const ShellState& state, const std::vector<Proxy>& bodies,
                        const std::vector<ContactCoefficients>& coefficients, double dt, ContactCandidates& candidates);

/// The shell takes impulse j [N s] where `functions` stand, at x, and the body its negative; both pages of its ledger.
void apply_impulse(ShellState& state, Proxy& body, const std::vector<GatheredFunction>& functions, const Vec3& x,
                   const Vec3& j);

/// Impulses at the Gauss points' surface, one body and one sample after the other (Gauss-Seidel), after the
/// kick of `dt`; returns the number of samples in contact. Their work is booked so that it closes with
/// kinetic_energy: an impulse that acts half a step after the positions works on the velocity at the
/// positions' time, v - dt f / 2m.
/// A sphere with a Hertz stiffness is pushed by that law instead (solver/hertz.h), a force that acts for `kicked` [s]
/// as those of the kick did.
int contact(const ShellModel& model, ShellState& state, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates, double dt,
            double kicked);

/// How velocities move on from substep to substep.
struct TransferRules {
  Transfer kind = Transfer::kDirect;
  double spacing = 0.0;  // of the grid [m]
  // Forces on what supports hold go to the grid too and reach what moves beside it, as where supports are known to no
  // grid node; else supports bear them.
  bool leaky = false;
};

/// Cracks change the force between the half kicks before and after them. The force must be that of the present
/// positions, which a substep of `dt` led to: that half kick is made one by the force before, so that the velocity
/// there is what it was. What leapfrog keeps (kinetic_energy) mostly falls by that, and what is lost is booked with
/// what the cracks released. Where it would rise, only the share of the change is taken that keeps it; what even so is
/// gained is taken from what the same cracks have released, and booked as injected where it is more, both in the first
/// shell's book. Shells that hang together have one share. `kick`
/// begins with it for a shell alone; before it energies and momenta are those of no moment.
void take_up_jump(const std::vector<ShellRef>& shells, double dt);
/// v += dt (f/m + gravity) and damping; force must be that of the present positions. Stiffness damping is
/// beta (f - last f) / dt = -beta K v. The work of damping is booked.
/// From the middle of the `last` substep to that of this one, of length `dt` [s]: in books closed at positions' times
/// half of each is its work.
void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt, double last);
inline void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt) {
  kick(model, state, gravity, dt, dt);
}
/// What loads and supports that move do now [W]. The work is booked by halves, before and after each kick.
double external_power(const ShellModel& model, const ShellState& state);
/// Velocities through the background grid, and of what supports hold: after contact, in place of `constrain`, where
/// `kick` was told to keep those before it. What that loses of the energy is booked.
void through_grid(const ShellModel& model, ShellState& state, const TransferRules& rules, double dt, int threads);
/// Velocities of what supports hold, tie together or drive, after kick and contact of a substep of `dt` that begins
/// at state.time.
void constrain(const ShellModel& model, ShellState& state, double dt);
/// Positions, and state.time, a substep on.
void drift(const ShellModel& model, ShellState& state, double dt);

}  // namespace sunder::shell
