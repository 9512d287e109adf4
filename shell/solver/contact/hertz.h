#pragma once
// Spheres in Hertz contact with a shell, F = k d^(3/2), at the nearest point of its surface.

#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {

/// Deepest approach as a share of the radius; beyond it Hertz's law is meaningless.
constexpr double kDeepestApproach = 0.2;

/// Applies the Hertz force between the shell and a sphere for a substep of `dt` [s], after the kick. `stiffness` is k
/// [N/m^1.5]; d is the approach of the sphere to the shell's face [m]. Returns whether they touch. Throws Error
/// (physics) where d exceeds kDeepestApproach radii.
bool hertz_contact(const ShellModel& model, ShellState& state, Proxy& sphere, double stiffness,
                   const std::vector<ContactCandidates::Sample>& candidates, double dt);

/// Returns the energy stored in the contacts of all spheres, 2/5 k d^(5/2) [J], plus half a kick of their forces.
/// Leapfrog conserves its sum with the bodies' kinetic energy at stored velocities and kinetic_energy() of the shell.
double hertz_energy(const ShellModel& model, const ShellState& state, const std::vector<Proxy>& bodies,
                    const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates,
                    double dt);

/// Returns the step [s] of a shell with stable step `step` [s] that meets a sphere at up to `speed` [m/s]. Hertz
/// contact stiffens the shell. The step resolves a contact in some thirty substeps, which conserves its energy to about
/// 1e-3.
double hertz_step(const ShellModel& model, const RigidBody& sphere, double stiffness, double speed, double step);
/// Returns the deepest approach [m] at that speed [m/s] on a rigid shell, for a mass [kg].
double hertz_approach(double mass, double stiffness, double speed);

}  // namespace sunder::shell
