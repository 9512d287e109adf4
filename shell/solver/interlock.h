#pragma once
// Fresh crack faces bear on one another: they push in compression and key into one another in shear, as
// rough faces do, until they have opened by more than the height of the roughness. A crack never bears
// tension. One point per edge, at its middle, evaluated with each side's own shape functions.
#include "shell/solver/state.h"

namespace sunder::shell {

/// When faces let go.
struct InterlockLaw {
  double opening = 0.0;         // [m]: faces further apart key no longer
  double shear_strength = 0.0;  // [Pa]
};

/// Pressed together, faces meet at their highest points first: over the depth of closing their stiffness grows evenly
/// from none. A kink that is crossed within a substep makes energy (0.1 % of a shattering pane's in a millisecond), so
/// the depth is eight times what the faces moved in the last substep in which they were open, where they hold nothing
/// across, and at least this [m].
double closing_depth(const ShellModel& model);

/// Fastens the two sides of an edge as they stand: the spring starts without force.
/// False where a side sees too few control points.
bool fasten(const ShellModel& model, const ShellState& state, Interlock& lock);

/// Whether the edges from `first` on hide control points that a face uses.
bool loses_sight(const ShellModel& model, const ShellState& state, Interlock& lock, int first);

struct Refastened {
  std::vector<std::pair<int, Vec3>> jump;  // of a slot, for the state's: the force before less that after [N]
  double let_go = 0.0;                     // for the books [J]
};
/// After another crack has cut its sight: new shape functions, the same extension. The faces may then bear less, or one
/// see too little and let go. Changes no other lock.
Refastened refasten(const ShellModel& model, const ShellState& state, Interlock& lock);

/// Adds the forces of one chunk of them (PointsBeside). `advance`: a substep begins here, and faces that are open take
/// the depth of their next closing from how they have moved since the last one. A function of the gap in the frame of
/// the deformed surface, so momentum and angular momentum are kept to round-off.
void interlock_forces(const ShellModel& model, ShellState& state, bool advance, int chunk, int chunks, const double* x4,
                      double* force4);
/// As the last force found it [J].
double interlock_energy(const ShellState& state);

/// Lets go where the last force found faces opened or sheared too far (`all`: everywhere); books what the
/// springs hold at the present positions.
void release_interlocks(const ShellModel& model, ShellState& state, const InterlockLaw& law, bool all);

}  // namespace sunder::shell
