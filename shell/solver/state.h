#pragma once
// One shell: what changes during a run, by kinds. A kind lists in saved() what a checkpoint keeps; caches and scratch
// can be found again.
#include <algorithm>
#include <vector>

#include "shell/grid/transfer.h"
#include "shell/mechanics/row_force.h"
#include "shell/solver/books.h"
#include "shell/solver/crack_state.h"
#include "shell/solver/model.h"
#include "shell/solver/surroundings.h"

namespace sunder::shell {

/// Control points: [3][component stride] per vector field, one entry a slot.
struct Motion {
  std::vector<double> x, v, force;         // [m], [m/s], [N]
  double time = 0.0;                       // of the positions, for loads and supports that change [s]
  std::vector<double> external;            // loads within `force` [N]; empty: no loads
  std::vector<double> last_force;          // of the substep before, for stiffness damping; empty: not comparable
  std::vector<double> mass, inverse_mass;  // [kg], [1/kg]; inverse 0: held, padding or detached
  std::vector<char> detached;              // control point belongs to a piece that was handed off
  // For velocities that go through the background grid, else empty: before kick and contact, after them, the velocity
  // of positions [m/s], and APIC's affine matrix [9][component stride] [1/s].
  std::vector<double> before, kicked, moving, affine;

  /// Calls f with all members that a checkpoint keeps.
  template <class F>
  void saved(F&& f) {
    f(x, v, force, time, external, last_force, mass, inverse_mass, detached, before, kicked, moving, affine);
  }
};

/// Layers and faces of each Gauss point.
struct LayerStates {
  std::vector<double> surface_stress;  // [block][6][lane], three components on each face [Pa]
  std::vector<double> strength;        // [block][lane], with its scatter [Pa]
  std::vector<float> c, c_his;         // [block][lane], damage now and at most (paper eq. 9) [-]
  std::vector<double> plastic;         // states of layers that yield (RowPlasticity); empty: none do
  std::vector<double> plastic_forms;   // surface forms at which they last moved on
  std::vector<double> fibres;  // [block][lane][below, above][r13, r23, r33]; empty: none (solver/contact/fibres.h)
  double brittleness = 0.0;    // H of eq. 9; 0: cracks are not driven by damage
  bool heals = true;           // damage follows the present stress, else it stays at its maximum

  /// Calls f with all members that a checkpoint keeps.
  template <class F>
  void saved(F&& f) {
    f(surface_stress, strength, c, c_his, plastic, plastic_forms, fibres, brittleness, heals);
  }
};

/// An elastic energy [J] and the time at which it was found [s].
struct TimedEnergy {
  double energy = 0.0, time = -1.0;
};

/// Answers that are kept because they are asked again; none changes what a run computes.
struct Caches {
  std::vector<double> least_strength;  // [block]; empty: not looked for yet
  std::vector<char> over;              // [block]: 0 where no recorded stress is above the strength
  std::vector<char> marked;            // [block]: 0 where c is zero since the last look; empty: unknown
  std::vector<Sight> visibility;       // of Gauss points near a new edge: control points that no crack hides
  std::vector<Sight> used;             // of each of them: control points that its functions use
  std::vector<int> visibility_of;      // [block][lane]: index into `visibility`, -1: none
  /// What edges on trial leave of a point with this visibility. A refused edge is tried again, longer or a little
  /// later, and mostly leaves the same.
  struct Trial {
    Sight sight;
    GatheredPoint point;
    TimedEnergy energy{};
  };
  struct Trials {
    std::vector<Trial> known;
    TimedEnergy present{};  // of the point as it is
  };
  std::vector<Trials> trials;  // of each entry of `visibility`; empty: none is remembered
  KnownSurroundings surroundings;
};

/// Memory that a force evaluation uses and the next one overwrites.
struct ShellScratch {
  TransferBuffers transfer;
  RowScratch rows;
  std::vector<double> points;
  std::vector<double> interlayer_force;
};

struct ShellState {
  Motion motion;
  LayerStates layers;
  Cracks cracks;
  CrackedPoints cracked;
  EnergyBook book;
  Caches caches;
  ShellScratch scratch;

  /// Gauss points of standing pieces that bear nothing any more.
  int rubble() const {
    return static_cast<int>(std::count_if(cracked.gathered.begin(), cracked.gathered.end(),
                                          [](const auto& g) { return g.kind == PointKind::kDead && !g.left; }));
  }
  /// The force discontinuity, zero everywhere at first.
  std::vector<double>& discontinuity() {
    if (cracks.force_discontinuity.empty()) cracks.force_discontinuity.assign(motion.force.size(), 0.0);
    return cracks.force_discontinuity;
  }
  /// Books stored energy that new cracks released [J]; the next kick takes it up with their force discontinuity.
  void release(double energy) { cracks.released += energy, book.fracture += energy; }
  bool yields() const { return !layers.plastic.empty(); }
  bool weakens() const { return layers.brittleness > 0.0; }  // by damage
  Vec3 position(int slot) const { return at(motion.x, slot); }
  Vec3 velocity(int slot) const { return at(motion.v, slot); }
  Vec3 at(const std::vector<double>& a, int slot) const {
    const std::size_t plane = a.size() / 3;
    return {a[slot], a[plane + slot], a[2 * plane + slot]};
  }
  void add_velocity(int slot, const Vec3& dv) {
    const std::size_t plane = motion.v.size() / 3;
    motion.v[slot] += dv.x(), motion.v[plane + slot] += dv.y(), motion.v[2 * plane + slot] += dv.z();
  }
};

/// A shell of several, model and state.
struct ShellRef {
  const ShellModel* model;
  ShellState* state;
};

/// The state at rest, moving at `velocity` [m/s] where nothing holds it. `seed` decides the scatter of strength.
ShellState make_state(const ShellModel& model, const Vec3& velocity, std::uint64_t seed);

/// Value shape functions of a Gauss point as it stands: gathered ones, else the patch's.
void sample_functions(const ShellModel& model, const ShellState& state, int block, int lane,
                      std::vector<GatheredFunction>& out);

}  // namespace sunder::shell
