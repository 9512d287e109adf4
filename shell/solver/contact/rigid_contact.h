#pragma once
// Contact of a shell with rigid bodies: impulses at surface samples.
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
/// A sphere with a Hertz stiffness is pushed by that law instead (solver/contact/hertz.h), a force that acts for
/// `kicked` [s] as those of the kick did.
int contact(const ShellModel& model, ShellState& state, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, const ContactCandidates& candidates, double dt,
            double kicked);

}  // namespace sunder::shell
