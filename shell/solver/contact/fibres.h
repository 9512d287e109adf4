#pragma once
// Shear and compression through the thickness of shells that touch one another, or themselves. These are the paper's
// type-III particles, one on either side of each Gauss point. Beside a crack they have the functions of their Gauss
// point. They keep layers apart and hold them by friction, in place of solver/contact/shell_contact.h.
#include <optional>

#include "shell/contact/fibre_grid.h"
#include "shell/solver/contact/near_tiles.h"

namespace sunder::shell {

/// The fibres of all shells that have a fibre law, and their forces.
class Fibres {
 public:
  /// `spacing` of the grid [m] is at least twice the thickness and at least an element.
  Fibres(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams, double spacing);

  /// Advances fibres after the `drift` of a substep of `dt` [s]: they follow the velocities of that substep and slip
  /// where friction allows it. Their forces on control points at the new positions are computed. Dissipation by slip is
  /// booked as `contact`, that by damage as `fracture`, or `healing` where damage heals. Throws Error (physics) where
  /// layers are compressed beyond a limit.
  void advance(const std::vector<ShellRef>& shells, double dt);
  /// Adds the fibres' forces. Call it after compute_forces, at the same positions.
  void add_forces(const std::vector<ShellRef>& shells);
  /// Returns the stored energy [J]; valid after `add_forces`.
  double energy() const { return energy_; }
  /// The place where layers that are not one surface overlap most, or are nearer than the grid tells apart.
  struct Overlap {
    int shell;
    Vec3 x;  // [m]
  };
  /// Returns that place, or nothing where all layers are apart: fibres then bear nothing, whatever the shells do.
  /// Changes nothing.
  std::optional<Overlap> overlap(const std::vector<ShellRef>& shells);
  /// Makes the next call look up candidates again and compute forces before they are used.
  void forget() { age_ = 0, known_ = false; }
  int candidates() const { return static_cast<int>(samples_.size()); }

 private:
  /// The local frame of a surface point, and its rotation.
  struct Frame {
    Mat3 q;           // columns q1, q2, n
    Mat3 spin;        // dq/dt q^T [1/s]
    Vec3 au, av;      // dual to the tangents
    double half = 0;  // rest volume of a fibre over half the thickness [m^3]
  };
  struct Place {
    int shell, block, lane;
  };
  void refresh(const std::vector<ShellRef>& shells, double dt);
  static std::size_t changes(const std::vector<ShellRef>& shells);
  void add_samples(const ShellRef& shell, const Tile& tile);
  void look(const std::vector<ShellRef>& shells);
  void advance_fibre(const ShellModel& model, ShellState& state, std::size_t sample, int side, double dt);
  void find_forces(const std::vector<ShellRef>& shells, double dt);
  Vec3 fibre(const ShellState& state, std::size_t sample, int side) const;
  /// Damage of a fibre before and after a substep [-], and the factor of its strengths.
  struct Weakening {
    double before = 0.0, now = 0.0, factor = 1.0;
  };
  /// Stores and returns the damage of a fibre that has become `a`.
  static Weakening weaken(const ShellModel& model, ShellState& state, const Place& place, int side, const Vec3& a);
  /// Sets a fibre to `a`, a state without stress, and books the energy that it releases.
  void relax(const ShellModel& model, ShellState& state, const Place& place, int side, const Vec3& a);
  static std::size_t at(const ShellState& state, const Place& p, int side) {
    return 6 * (static_cast<std::size_t>(p.block) * state.cracked.tables.lanes + p.lane) + 3 * side;
  }
  static double damage(const ShellState& state, const Place& p, int side) {
    return state.layers.through.empty() ? 0.0 : state.layers.through[at(state, p, side) / 3];
  }

  FibreGrid grid_;
  NearTiles near_;
  std::vector<Place> places_;
  std::vector<LayerSample> samples_;
  std::vector<GatheredFunction> functions_;  // functions of all samples, one sample after the other
  std::vector<std::size_t> first_;           // first function of each sample, then their total number
  std::vector<Frame> frames_;
  std::vector<std::array<Mat3, 2>> stress_;  // V d psi/d a3 (x) a3 [J], on both sides of each sample
  std::vector<std::vector<Vec3>> forces_;    // [shell][slot]
  std::vector<std::vector<int>> touched_;    // slots of each shell
  double energy_ = 0.0;
  int age_ = 0;
  bool known_ = false;
  std::size_t changes_ = 0;  // when candidates were looked up
};

/// Returns the stable step [s] of shells with fibres, whose own stable step is `alone`. It holds for any stack of
/// layers, since stiffnesses add: omega^2 <= (2 / alone)^2 + the fibres' part. Per area, two layers at the distance d =
/// (t1 + t2) / 2 resist approach or sliding by (t1 k1 + t2 k2) / (2 d^2). Here k is the larger of 2 times the
/// compression modulus and the shear modulus. A layer has two such neighbours; a grid node that lies unevenly between
/// two layers adds a factor of 1.19. A fibre also leans as its surface turns, which adds gamma t (dw/dx)^2, with gamma
/// the shear modulus.
double stable_step_with_fibres(double alone, const std::vector<const ShellModel*>& shells);

}  // namespace sunder::shell
