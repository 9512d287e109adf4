#pragma once
// Contact of a shell with rigid bodies, by impulses at surface samples.
#include <span>

#include <Eigen/Geometry>

#include "shell/contact/proxy.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// The contact law between the shell and one proxy.
struct ContactCoefficients {
  double friction = 0.5, restitution = 0.0;
  double hertz = 0.0;  // Hertz stiffness of a sphere, F = k d^(3/2), without friction [N/m^1.5]; 0: impulses
};

/// Surface samples that may touch each body before the next refresh.
struct ContactCandidates {
  struct Sample {
    int block, lane;
    int first = 0;  // number of substeps after the refresh in which it cannot touch
    Proxy::Known known{};
    Vec2 to_edge = Vec2::Zero();  // of a sample at the edge of the patch: from its Gauss point to it, in parameters
  };
  std::vector<std::vector<Sample>> of_body;
  // Scratch of the search: positions of samples, computed once for all bodies.
  struct Place {
    Vec3 x;
    std::uint32_t refresh = 0;  // number of the refresh that computed it
    bool there = false;
  };
  std::vector<Place> places;
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<int> near;                     // tiles
  std::vector<std::vector<Sample>> of_tile;  // of these
  // Distances of all samples to each body of many triangles, as they were last computed; and which bodies these were.
  std::vector<std::vector<Proxy::Known>> known;
  std::vector<BodyId> ids;
  std::uint32_t refresh = 0;
  int age = 0;  // substeps since the refresh
  // Scratch of contact(): samples that overlap with a body, in parts that threads share; those of all parts, and their
  // functions, one after another.
  struct Overlap {
    std::size_t candidate;
    Vec3 x;                       // of the mid-surface
    Proxy::Distance middle, gap;  // there, and at the face towards the body
  };
  struct Pressed {
    const Overlap* at;
    std::size_t first, count;  // functions
    Mat3 inverse;              // change of the relative velocity per impulse [1/kg]
    Vec3 wanted, back;         // relative velocity afterwards; half a kick [m/s]
    Vec3 j = Vec3::Zero();     // impulse so far [N s]
  };
  std::vector<Pressed> pressed;
  std::vector<GatheredFunction> functions;
  std::vector<std::vector<Overlap>> overlaps;
  std::size_t parts = 0;
};
constexpr int kContactRefresh = 16;  // substeps

/// Finds the candidates for the next kContactRefresh substeps of `dt` [s]. Results are the same for any number of
/// threads, here and in contact().
void refresh_candidates(const ShellModel& model, const ShellState& state, const std::vector<Proxy>& bodies,
                        const std::vector<ContactCoefficients>& coefficients, double dt, ContactCandidates& candidates,
                        int threads = 1);

/// Applies impulse j [N s] to the shell at x, by `functions`, and its negative to the body. Both sides of the body's
/// ledger are updated.
void apply_impulse(ShellState& state, Proxy& body, std::span<const GatheredFunction> functions, const Vec3& x,
                   const Vec3& j);

/// Applies contact impulses at the Gauss points' surface, body by body and sample by sample (Gauss-Seidel), after a
/// kick of `dt` [s]. Returns the number of samples in contact. Work is booked so that it closes with kinetic_energy: an
/// impulse half a step after the positions works on the velocity at the time of the positions, v - dt f / 2m. A sphere
/// with Hertz stiffness is treated by Hertz's law (solver/contact/hertz.h), a force that acts for `kicked` [s] as the
/// forces of the kick did.
int contact(const ShellModel& model, ShellState& state, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, ContactCandidates& candidates, double dt,
            double kicked, int threads = 1);

}  // namespace sunder::shell
