#pragma once
// Shear and compression through the thickness of shells that touch one another, or themselves: the paper's type-III
// particles, one on either side of each Gauss point. They keep layers apart and hold them by friction, in place of the
// contact that shells have otherwise (solver/contact/shell_contact.h).
#include "shell/contact/fibre_grid.h"
#include "shell/solver/contact/near_tiles.h"

namespace sunder::shell {

class Fibres {
 public:
  /// Shells without a fibre law have none. `spacing` of the grid [m], at least twice the thickness and an element.
  Fibres(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams, double spacing);

  /// After `drift` of a substep of `dt` [s]: fibres follow the velocities that led there, slip where they must, and
  /// what they do to control points at these positions is found. What slipping takes is booked as `contact`. Throws
  /// Error (physics) where layers are squeezed to nothing.
  void advance(const std::vector<ShellRef>& shells, double dt);
  /// After compute_forces, at the same positions.
  void add_forces(const std::vector<ShellRef>& shells);
  /// That fibres store [J]; after `add_forces`.
  double energy() const { return energy_; }
  /// What may meet is looked up anew, and forces are found again before they are used.
  void forget() { age_ = 0, known_ = false; }
  int candidates() const { return static_cast<int>(samples_.size()); }

 private:
  /// The frame of a surface's point, and how it turns.
  struct Frame {
    Mat3 q;           // columns q1, q2, n
    Mat3 spin;        // dq/dt q^T [1/s]
    Vec3 au, av;      // dual to the tangents
    double half = 0;  // volume of a fibre at rest, half the thickness [m^3]
  };
  struct Place {
    int shell, block, lane;
  };
  void refresh(const std::vector<ShellRef>& shells, double dt);
  void add_samples(const ShellRef& shell, const Tile& tile);
  void look(const std::vector<ShellRef>& shells);
  void follow(const ShellModel& model, ShellState& state, std::size_t sample, int side, double dt);
  void find_forces(const std::vector<ShellRef>& shells, double dt);
  Vec3 fibre(const ShellState& state, std::size_t sample, int side) const;
  /// The fibre becomes `a`; what it stored more is booked.
  void relax(const ShellModel& model, ShellState& state, const Place& place, int side, const Vec3& a);
  static std::size_t at(const ShellState& state, const Place& p, int side) {
    return 6 * (static_cast<std::size_t>(p.block) * state.cracked.tables.lanes + p.lane) + 3 * side;
  }

  FibreGrid grid_;
  NearTiles near_;
  std::vector<Place> places_;
  std::vector<LayerSample> samples_;
  std::vector<GatheredFunction> functions_;  // of all samples
  std::vector<std::size_t> first_;           // function of each sample, and their number
  std::vector<Frame> frames_;
  std::vector<std::array<Mat3, 2>> stress_;  // V d psi/d a3 (x) a3 [J]
  std::vector<std::vector<Vec3>> forces_;    // [shell][slot]
  std::vector<std::vector<int>> touched_;    // slots of each shell
  double energy_ = 0.0;
  int age_ = 0;
  bool known_ = false;
};

/// Stable step [s] of shells that are stable at `alone` by themselves, with their fibres, which bounds that of any
/// stack of layers: stiffness adds up, omega^2 <= (2 / alone)^2 + what fibres add. The latter, per area: two layers
/// d = (t1 + t2) / 2 apart oppose (t1 k1 + t2 k2) / (2 d^2) to approach or sliding, k the larger of 2 k and gamma; two
/// such beside a layer, and where a grid's node lies unevenly between both, 1.19 times that. A fibre also leans as its
/// surface turns, which is gamma t (dw/dx)^2.
double stable_step_with_fibres(double alone, const std::vector<const ShellModel*>& shells);

}  // namespace sunder::shell
