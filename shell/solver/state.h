#pragma once
// One shell: what changes during a run.
#include <algorithm>
#include <array>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "shell/fracture/mls.h"
#include "shell/grid/transfer.h"
#include "shell/mechanics/point_force.h"
#include "shell/solver/model.h"
#include "shell/solver/surroundings.h"

namespace sunder::shell {

/// A running end of a crack.
struct Tip {
  Vec2 p, direction;
  int vertex = 0, edge = -1, crack = 0;
  int sibling = -1;           // crack of the other arm of the last branch
  int face = 0;               // tension side, -1 or +1
  double pending = 0.0;       // length that it may advance [m]
  double since_branch = 0.0;  // [m]
  double grown = 0.0;         // since it was born [m]
  double strength = 1e300;    // of the flaw that it was born from [Pa], which resists less and less until it has
  double flaw = 0.0;          // grown so far [m]: half the critical length
  double first_turn = 0.0;    // most that its first edge may turn [rad]
  // while `pending` grew, weighted by speed: weight, turn [rad], drive
  double weight = 0.0, turn = 0.0, ratio = 0.0;
  bool alive = true;
  bool crossed = false;  // dead, and asked whether it goes on beyond a seam
};

/// The two faces of a fresh crack bear on one another at the middle of an edge (solver/interlock.h).
struct Interlock {
  int edge = 0;
  double area = 0.0;         // [m^2]
  double stiffness = 1e300;  // [Pa/m]; never more than it was
  std::vector<GatheredFunction> plus, minus;
  // Of these sides, what they see and what their functions use, and whether these are planes. Not part of checkpoints,
  // as they can be found again.
  std::array<Sight, 2> sights{}, uses{};
  std::array<bool, 2> planes{};
  bool looked = false;       // they have been
  Vec3 rest = Vec3::Zero();  // gap without force: across, along, normal [m]
  double rest_area = 1.0;    // of the tangents' parallelogram when it was fastened
  bool holds = true;
  // as the force last found them: opening [m], shear traction that springs of full stiffness would bear [Pa], energy
  // [J], faces still fit
  double opening = 0.0, shear = 0.0, energy = 0.0;
  bool sound = true;
  double was_open = 0.0;  // opening where the last substep began [m]
  double depth = 0.0;     // of closing, where more than the least [m]
};

/// Energies that left the mechanics, each booked where it went [J].
struct EnergyBook {
  double fracture = 0.0;  // released when cracks were inserted and interlock broke, taken by damage that does not heal
  double injected = 0.0;  // by what cracks change in a moment, where it adds energy in all
  double contact = 0.0;   // inelastic and frictional, shell against bodies
  double handoff = 0.0;   // kinetic and elastic energy that a rigid piece cannot carry
  double external = 0.0;  // work of loads and of supports that move, counted as gained
  double healing = 0.0;   // of damaged points that healed: lost, or made where negative
  double plastic = 0.0;   // dissipated by yielding
  double damping = 0.0;   // Rayleigh
  double transfer = 0.0;  // lost on the way through the background grid, made where negative
  double frozen = 0.0;    // of what is held when the shell is frozen

  /// What the mechanics have less because of all of these.
  double lost() const {
    return fracture - injected + contact + handoff - external + healing + plastic + transfer + damping + frozen;
  }
  EnergyBook& operator+=(const EnergyBook& o) {
    fracture += o.fracture, injected += o.injected, contact += o.contact, handoff += o.handoff, external += o.external;
    healing += o.healing, plastic += o.plastic, damping += o.damping, transfer += o.transfer, frozen += o.frozen;
    return *this;
  }
};

/// An elastic energy [J] and the time at which it was found [s].
struct TimedEnergy {
  double energy = 0.0, time = -1.0;
};

struct ShellState {
  std::vector<double> x, v, force;     // [3][plane]
  double time = 0.0;                   // of the positions, for loads and supports that change [s]
  std::vector<double> external;        // [3][plane], of the loads as `force` last had them; empty: no loads
  std::vector<double> last_force;      // of the substep before, for stiffness damping; empty: not comparable
  std::vector<double> mass;            // of each slot, as it stands (pieces that left took theirs)
  std::vector<double> inverse_mass;    // 0: held, padding or gone
  std::vector<char> gone;              // control point belongs to a piece that was handed off
  std::vector<double> surface_stress;  // [block][6][lane]
  std::vector<double> strength;        // [block][lane], with its scatter
  std::vector<float> c, c_his;         // [block][lane]
  std::vector<double> least_strength;  // [block]; empty: not looked for yet
  std::vector<char> over;       // [block]: 0 where no stress recorded is above the strength; not part of checkpoints
  std::vector<char> marked;     // [block]: 0 where c is zero since the last look; empty: unknown
  std::vector<double> plastic;  // states of layers that yield (RowPlasticity); empty: none do
  std::vector<double> plastic_forms;  // and the forms at which they last moved on
  std::vector<double> fibres;         // [block][lane][below, above][r13, r23, r33]; empty: none (solver/fibres.h)
  RowTables tables;                   // as the model's, areas of gathered points taken out
  RowTables interlayer;               // as the model's, areas of what has left taken out
  std::vector<GatheredPoint> points;  // Gauss points that a crack has touched, or that damage may weaken
  std::vector<char> kind_of;          // [block][lane]: PointKind of the entry in points, kQuadratic where there is none
  std::vector<int> point_of;          // [block][lane]: index into points, -1: none
  std::vector<PointDamage> damage;    // of each of these points where damage drives the cracks, else empty
  std::vector<char> watched;          // [block][lane]: damage may weaken the point, the rows sum it; empty: none
  double brittleness = 0.0;           // H of eq. 9; 0: cracks are not driven by damage
  bool heals = true;                  // damage follows the present stress, else it stays at its maximum
  CrackGraph cracks{Vec2::Zero(), Vec2::Ones(), 1.0, 0.01};
  std::vector<Sight> sights;  // of Gauss points that were near a new edge
  std::vector<Sight> uses;    // of each of them: control points that the functions of its entry in `points` use
  std::vector<int> sight_of;  // [block][lane]: index into sights, -1: none
  /// What edges on trial would leave of a point that sees so much. Those that are refused are tried again, longer or a
  /// little later, and mostly leave the same. Not part of checkpoints: it can be found again.
  struct Trial {
    Sight sight;
    GatheredPoint point;
    TimedEnergy energy{};
  };
  struct Trials {
    std::vector<Trial> known;
    TimedEnergy present{};  // of the point as it is
  };
  std::vector<Trials> trials;  // of each sight; empty: none is remembered
  // [block][lane]: no control point that the functions beside a crack use is further off, the larger of the two
  // coordinates [spacings]; 0: they are those of the patch
  std::vector<float> reach;
  std::vector<Tip> tips;
  KnownSurroundings surroundings;
  std::vector<Interlock> interlocks;
  std::vector<int> interlock_of;  // of each crack edge, -1: none
  std::vector<char> cut_done;     // prescribed cuts that have been made
  double last_crack_time = -1.0;  // [s]
  EnergyBook book;
  // [3][plane], the force of strains, faces and layers, not of loads, before less that after what cracks have changed
  // here; empty: none
  std::vector<double> jump;
  double let_go = 0.0;  // stored energy that they have released with it, booked as fracture [J]
  // For velocities that go through the background grid; empty where they do not.
  std::vector<double> before;  // [3][plane], velocities before kick and contact
  std::vector<double> kicked;  // [3][plane], and after them
  std::vector<double> moving;  // [3][plane], what positions move with
  std::vector<double> affine;  // [9][plane], of APIC [1/s]
  TransferBuffers transfer_buffers;
  RowScratch row_scratch;
  std::vector<double> point_scratch;
  std::vector<double> interlayer_force;
  double interlock_energy = 0.0;

  PointKind kind(std::size_t gauss) const { return static_cast<PointKind>(kind_of[gauss]); }
  void note_kind(const GatheredPoint& g) {
    kind_of[static_cast<std::size_t>(g.block) * tables.lanes + g.lane] = static_cast<char>(g.kind);
  }
  /// Gauss points of standing pieces that bear nothing any more.
  int rubble() const {
    return static_cast<int>(std::count_if(
        points.begin(), points.end(), [](const GatheredPoint& g) { return g.kind == PointKind::kDead && !g.left; }));
  }
  std::vector<double>& jumped() {
    if (jump.empty()) jump.assign(force.size(), 0.0);
    return jump;
  }
  /// Of what cracks change here, which the next kick takes up with the rest.
  void release(double energy) { let_go += energy, book.fracture += energy; }
  bool yields() const { return !plastic.empty(); }
  Vec3 position(int slot) const { return at(x, slot); }
  Vec3 velocity(int slot) const { return at(v, slot); }
  Vec3 at(const std::vector<double>& a, int slot) const {
    const std::size_t plane = a.size() / 3;
    return {a[slot], a[plane + slot], a[2 * plane + slot]};
  }
  void add_velocity(int slot, const Vec3& dv) {
    const std::size_t plane = v.size() / 3;
    v[slot] += dv.x(), v[plane + slot] += dv.y(), v[2 * plane + slot] += dv.z();
  }
};

/// A shell of several, model and state.
struct ShellRef {
  const ShellModel* model;
  ShellState* state;
};

/// States of its layers and their law; only of one that yields.
RowPlasticity plasticity_of(const ShellModel& model, ShellState& state);

ShellState make_state(const ShellModel& model, const Vec3& velocity, std::uint64_t seed);

/// Forces at the present positions into state.force: elastic, cracked points, interlock, loads at state.time.
/// Returns the elastic energy [J] where `energy`. Damage and plastic flow move on only where stress is recorded,
/// `stress_share` > 0: else the answer is that of a step from where they stand.
double compute_forces(const ShellModel& model, ShellState& state, bool energy, double stress_share, int threads);

/// Kinetic energy [J] at the time of the positions: m v- . v+ / 2, v- the stored velocities and v+ those a
/// kick of `dt` later. With the elastic energy of a linear shell it is what leapfrog keeps to round-off, at
/// any stable step; (v- + v+)^2 / 8 is not: at 0.8 of the stable step it gives the stiffest mode 1.6 times
/// its elastic energy too much. What a support drives counts with m v-^2 / 2: no force moves it.
double kinetic_energy(const ShellModel& model, const ShellState& state, double dt);

/// In the field of gravity [J], of what moves.
double potential_energy(const ShellModel& model, const ShellState& state, const Vec3& gravity);

/// Value shape functions of a Gauss point as it stands: gathered ones, else the patch's.
void sample_functions(const ShellModel& model, const ShellState& state, int block, int lane,
                      std::vector<GatheredFunction>& out);

}  // namespace sunder::shell
