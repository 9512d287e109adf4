#pragma once
// Spheres that push a shell by Hertz's law, F = k d^3/2, at the point of its surface nearest to them.

#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {

/// Of the radius: deeper the law has no meaning.
constexpr double kDeepestApproach = 0.2;

/// The shell and the sphere, `stiffness` k [N/m^1.5], push one another for a substep of `dt`, after the kick; d is the
/// approach of the sphere and the shell's face. Returns whether they touch. Throws Error (physics) where the sphere
/// sinks in by more than a fifth of its radius.
bool hertz_contact(const ShellModel& model, ShellState& state, Proxy& sphere, double stiffness,
                   const std::vector<ContactCandidates::Sample>& candidates, double dt);

/// What the contacts of all spheres store, 2/5 k d^5/2 [J], and half a kick of theirs: with kinetic energies at the
/// stored velocities of bodies, and kinetic_energy() of the shell, this is what leapfrog keeps.
double hertz_energy(const ShellModel& model, const ShellState& state, const std::vector<Proxy>& bodies,
                    const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates,
                    double dt);

/// The step [s] of a shell of stable step `step` that meets a sphere at up to `speed` [m/s]: Hertz contact stiffens it,
/// and is followed in some thirty substeps, which keeps its energy to about 1e-3.
double hertz_step(const ShellModel& model, const RigidBody& sphere, double stiffness, double speed, double step);
/// Deepest approach [m] at that speed, if the shell did not give way.
double hertz_approach(double mass, double stiffness, double speed);

}  // namespace sunder::shell
