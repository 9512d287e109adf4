#pragma once
// Fresh crack faces bear on one another: they push in compression and resist in shear, as rough faces do, until they
// have opened by more than the height of the roughness. A crack never bears tension. One point per edge, at its middle,
// is evaluated with the shape functions of each side.
#include "shell/solver/state.h"

namespace sunder::shell {

/// When faces release.
struct InterlockLaw {
  double opening = 0.0;         // faces further apart bear no more [m]
  double shear_strength = 0.0;  // shear traction at which they slip [Pa]
};

/// Least depth over which pressed faces grow stiff [m]. They meet at their highest points first, so their stiffness
/// grows evenly from zero over a depth of closing. A kink in the stiffness that is crossed within a substep makes
/// energy. So the depth is also at least kClosingTravels times the travel of the faces in the last substep in which
/// they were open and bore nothing.
double closing_depth(const ShellModel& model);

/// Fastens the two sides of an edge as they stand: the spring starts without force. False where a side sees too few
/// control points.
bool fasten(const ShellModel& model, const ShellState& state, Interlock& lock);

/// Whether the edges from `first` on hide control points that a face uses.
bool loses_visibility(const ShellModel& model, const ShellState& state, Interlock& lock, int first);

struct Refastened {
  std::vector<std::pair<int, Vec3>>
      force_change;       // change of force by slot, for the force discontinuity: before less after [N]
  double released = 0.0;  // energy released, for the books [J]
};
/// After another crack has cut the visibility of a face: new shape functions, the same extension. The faces may then
/// bear less, or release where one sees too little. Changes no other pair of faces.
Refastened refasten(const ShellModel& model, const ShellState& state, Interlock& lock);

/// Adds the forces of one chunk of all pairs of faces (PointsBeside). `advance`: a substep begins here, and open faces
/// take the depth of their next closing from their travel since the last one. The force is a function of the gap in the
/// frame of the deformed surface, so momentum and angular momentum stay to round-off.
void interlock_forces(const ShellModel& model, ShellState& state, bool advance, int chunk, int chunks, const double* x4,
                      double* force4);
/// Energy of all faces at the last force [J].
double interlock_energy(const ShellState& state);

/// Releases faces that the last force found opened or sheared too far (`all`: all faces). Books the energy that the
/// springs hold at the present positions.
void release_interlocks(const ShellModel& model, ShellState& state, const InterlockLaw& law, bool all);

}  // namespace sunder::shell
