#pragma once
// The changing part of one shell, by kinds. A kind lists in hashed() what the hash of a run takes, and in saved() what
// a checkpoint stores: that, and what else the next substep reads. A copy takes all. Caches and scratch are computed
// again.
#include <algorithm>
#include <vector>

#include "shell/grid/transfer.h"
#include "shell/mechanics/row_force.h"
#include "shell/solver/books.h"
#include "shell/solver/crack_state.h"
#include "shell/solver/model.h"
#include "shell/solver/surroundings.h"

namespace sunder::shell {

/// Control points: vector fields are [3][component stride], with one entry for each slot.
struct Motion {
  std::vector<double> x, v, force;         // [m], [m/s], [N]
  double time = 0.0;                       // time of the positions, for loads and supports that change [s]
  std::vector<double> external;            // loads included in `force` [N]; empty: no loads
  std::vector<double> last_force;          // force of the last substep, for stiffness damping; empty: not comparable
  std::vector<double> mass, inverse_mass;  // [kg], [1/kg]; inverse 0: held, padding or detached
  std::vector<char> detached;              // 1 where the control point belongs to a piece that was handed off
  // For velocities that pass through the background grid; otherwise empty. Velocities before kick and contact,
  // velocities after them, velocities that move positions [m/s], and APIC's affine matrix [9][component stride] [1/s].
  std::vector<double> before, kicked, moving, affine;
  // Impulse of supports on control points since it was last set to zero [N s]; empty: it is not measured.
  std::vector<double> support_impulse;
  // Impulse of contact on control points since the start [N s]; empty: it is not measured.
  std::vector<double> contact_impulse;
  // Impulse of each body of the scene on the shell since the start [N s]; empty: it is not measured.
  std::vector<double> body_impulse;
  int released = 0;  // number of releases of supports that have been made

  /// Calls f with all members that the hash of a run takes.
  template <class Self, class F>
  static void hashed(Self& self, F&& f) {
    f(self.x, self.v);
  }
  /// Calls f with all members that a checkpoint saves.
  template <class F>
  void saved(F&& f) {
    hashed(*this, f);
    f(force, time, external, last_force, mass, inverse_mass, detached, before, kicked, moving, affine, support_impulse,
      contact_impulse, body_impulse, released);
  }
};

/// Layers and faces of each Gauss point.
struct LayerStates {
  std::vector<double> face_stress;    // [block][6][lane]: three components on each face [Pa]
  std::vector<double> strength;       // [block][lane]: strength with its scatter [Pa]
  std::vector<float> c, c_his;        // [block][lane]: damage now, and its maximum (paper eq. 9) [-]
  std::vector<double> plastic;        // states of layers that yield (RowPlasticity); empty: no layer has flowed
  char plastic_made = 0;              // whether `plastic` is there, for the kernels
  std::vector<double> plastic_forms;  // surface forms at the last plastic step; empty: no yielding
  std::vector<double> fibres;  // [block][lane][below, above][r13, r23, r33]; empty: none (solver/contact/fibres.h)
  // [block][lane][below, above]: damage of fibres now, and its maximum [-]; empty: they are not damaged
  std::vector<float> through, through_his;
  double brittleness = 0.0;  // H of eq. 9 [-]; 0: damage does not drive cracks
  bool heals = true;         // damage falls with the stress; otherwise it keeps its maximum

  /// Calls f with all members that the hash of a run takes.
  template <class Self, class F>
  static void hashed(Self& self, F&& f) {
    f(self.fibres, self.c_his, self.through, self.through_his);
  }
  /// Calls f with all members that a checkpoint saves.
  template <class F>
  void saved(F&& f) {
    hashed(*this, f);
    f(face_stress, strength, c, plastic, plastic_forms, brittleness, heals);
  }
  /// Damage of the fibres of a Gauss point, block * lanes + lane: the larger of both sides, now or its maximum.
  float fibre_damage(std::size_t gauss) const { return larger(through, gauss); }
  float worst_fibre_damage(std::size_t gauss) const { return larger(through_his, gauss); }

 private:
  static float larger(const std::vector<float>& sides, std::size_t gauss) {
    return sides.empty() ? 0.0f : std::max(sides[2 * gauss], sides[2 * gauss + 1]);
  }
};

/// An elastic energy [J] and its time [s].
struct TimedEnergy {
  double energy = 0.0, time = -1.0;
};

/// Stored answers to repeated questions. None of them changes what a run computes.
struct Caches {
  std::vector<double> least_strength;  // [block]; empty: not computed yet
  std::vector<char> over;              // [block]: 0 where no recorded stress is above the strength
  std::vector<char> marked;            // [block]: 0 where c was zero at the last check; empty: unknown
  std::vector<Visibility> visibility;  // of Gauss points near a new edge: control points that no crack hides
  std::vector<Visibility> used;        // of the same points: control points that their functions use
  std::vector<int> visibility_of;      // [block][lane]: index into `visibility`; -1: none
  /// A point with its functions after trial edges have left it this visibility. A refused edge is tried again, longer
  /// or a little later, and mostly leaves the same visibility.
  struct Trial {
    Visibility visibility;
    GatheredPoint point;
    TimedEnergy energy{};
  };
  struct Trials {
    std::vector<Trial> known;
    TimedEnergy present{};  // of the point without trial edges
  };
  std::vector<Trials> trials;  // of each entry of `visibility`; empty: none is stored
  KnownSurroundings surroundings;
};

/// Memory that each force evaluation overwrites.
struct ShellScratch {
  TransferBuffers transfer;
  RowScratch rows;
  PointScratch points, interlayer_points;
  std::vector<double> interlayer_force;
};

/// The whole state of one shell.
struct ShellState {
  Motion motion;
  LayerStates layers;
  Cracks cracks;
  CrackedPoints cracked;
  EnergyBook book;
  Caches caches;
  ShellScratch scratch;

  /// Calls f with all kinds that the hash of a run or a checkpoint takes.
  template <class Self, class F>
  static void kinds(Self& self, F&& f) {
    f(self.motion, self.layers, self.cracks, self.cracked, self.book);
  }
  /// Counts Gauss points without any stiffness on pieces that are not handed off.
  int rubble() const {
    return static_cast<int>(std::count_if(cracked.gathered.begin(), cracked.gathered.end(),
                                          [](const auto& g) { return g.kind == PointKind::kDead && !g.handed_off; }));
  }
  /// Returns the force discontinuity; it is zero at first.
  std::vector<double>& discontinuity() {
    if (cracks.force_discontinuity.empty()) cracks.force_discontinuity.assign(motion.force.size(), 0.0);
    return cracks.force_discontinuity;
  }
  /// Books energy [J] that new cracks release. The next kick uses it together with their force discontinuity.
  void release(double energy) { cracks.released += energy, book.fracture += energy; }
  /// Books energy [J] that faces in contact held and no longer hold.
  void release_by_faces(double energy) {
    cracks.released += energy, cracks.released_by_faces += energy, book.face_friction += energy;
  }
  bool yields() const { return !layers.plastic_forms.empty(); }
  bool weakens() const { return layers.brittleness > 0.0; }  // by damage
  /// Damage of a listed Gauss point, index `point`, now and at its worst: the largest of its layers and its fibres.
  float damage(std::size_t point) const {
    return std::max(cracked.damage[point].damage(), layers.fibre_damage(cracked.gauss_of(point)));
  }
  float worst_damage(std::size_t point) const {
    return std::max(cracked.damage[point].worst(), layers.worst_fibre_damage(cracked.gauss_of(point)));
  }
  Vec3 position(int slot) const { return at(motion.x, slot); }
  Vec3 velocity(int slot) const { return at(motion.v, slot); }
  Vec3 at(const std::vector<double>& a, int slot) const {
    const std::size_t stride = a.size() / 3;
    return {a[slot], a[stride + slot], a[2 * stride + slot]};
  }
  /// Books an impulse [N s] on a control point that is held along all axes: its supports bear it.
  void pass_to_supports(int slot, const Vec3& impulse) {
    std::vector<double>& sum = motion.support_impulse;
    if (sum.empty() || motion.inverse_mass[slot] > 0.0) return;
    const std::size_t stride = sum.size() / 3;
    sum[slot] -= impulse.x(), sum[stride + slot] -= impulse.y(), sum[2 * stride + slot] -= impulse.z();
  }
  /// Books an impulse [N s] along an axis on a control point that is held along it.
  void pass_to_supports(int slot, int axis, double impulse) {
    std::vector<double>& sum = motion.support_impulse;
    if (!sum.empty()) sum[axis * (sum.size() / 3) + slot] -= impulse;
  }
  /// Books an impulse [N s] of contact on a control point, where it is measured.
  void count_contact(int slot, const Vec3& impulse) {
    std::vector<double>& sum = motion.contact_impulse;
    const std::size_t stride = sum.size() / 3;
    for (int d = 0; d < 3 && stride > 0; ++d) sum[d * stride + slot] += impulse[d];
  }
  /// The same of body `id` on the shell.
  void count_body(std::size_t id, const Vec3& impulse) {
    std::vector<double>& sum = motion.body_impulse;
    for (std::size_t d = 0, first = 3 * (id - 1); d < 3 && first + 3 <= sum.size(); ++d) sum[first + d] += impulse[d];
  }
  void add_velocity(int slot, const Vec3& dv) {
    const std::size_t stride = motion.v.size() / 3;
    motion.v[slot] += dv.x(), motion.v[stride + slot] += dv.y(), motion.v[2 * stride + slot] += dv.z();
  }
};

/// Model and state of one shell.
struct ShellRef {
  const ShellModel* model;
  ShellState* state;
};

/// Makes the undeformed state. `velocity` [m/s] is that of all points without a support. `seed` determines the scatter
/// of strength.
ShellState make_state(const ShellModel& model, const Vec3& velocity, std::uint64_t seed);

/// Returns the functions (values only) of a Gauss point in this state: gathered ones where it has them, otherwise the
/// patch's.
void sample_functions(const ShellModel& model, const ShellState& state, int block, int lane,
                      std::vector<GatheredFunction>& out);

}  // namespace sunder::shell
