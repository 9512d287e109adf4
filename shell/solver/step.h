#pragma once
// One substep of a shell with the bodies that it meets.
#include "shell/contact/proxy.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// Friction and restitution between the shell and each proxy, by index.
struct ContactCoefficients {
  double friction = 0.5, restitution = 0.0;
};

/// Which surface samples may meet which body within the next substeps; refreshed every so often.
struct ContactCandidates {
  struct Sample {
    int block, lane;
    int first = 0;  // substeps from the refresh in which it cannot touch
  };
  std::vector<std::vector<Sample>> of_body;
  int age = 0;  // substeps since the refresh
};
constexpr int kContactRefresh = 16;  // substeps

void refresh_candidates(const ShellModel& model, const ShellState& state, const std::vector<Proxy>& bodies, double dt,
                        ContactCandidates& candidates);

/// Impulses at the Gauss points' surface, one body and one sample after the other (Gauss-Seidel), after the
/// kick of `dt`; returns the number of samples in contact. Their work is booked so that it closes with
/// kinetic_energy: an impulse that acts half a step after the positions works on the velocity at the
/// positions' time, v - dt f / 2m.
int contact(const ShellModel& model, ShellState& state, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates, double dt);

/// v += dt (f/m + gravity) and damping; force must be that of the present positions. Stiffness damping is
/// beta (f - last f) / dt = -beta K v. The work of damping is booked.
void kick(const ShellModel& model, ShellState& state, const Vec3& gravity, double dt);
/// Velocities of what supports hold, tie together or drive, after kick and contact of a substep of `dt` that begins
/// at state.time.
void constrain(const ShellModel& model, ShellState& state, double dt);
/// Positions, and state.time, a substep on.
void drift(const ShellModel& model, ShellState& state, double dt);

}  // namespace sunder::shell
