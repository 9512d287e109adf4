#pragma once
// Contact of the two faces of a fresh crack edge. A sheet touches at both of its faces: a crack that bends open at one
// face still bears at the other, as a hinge does. So there are two points, at half a thickness above and below the
// middle of the edge. Each presses with a penalty and no tension, up to the crushing strength, and slides by Coulomb's
// law. One pair of points per edge is evaluated with the shape functions of each side.
#include "shell/solver/state.h"

namespace sunder::shell {

/// When faces are apart for good: opened by more than `opening` [m] and `of_thickness` [tau, where they are] at both
/// points. Faces that have slid past each other by more than the thickness, or along the edge by more than its length,
/// are apart as well.
struct InterlockLaw {
  double opening = 0.0, of_thickness = 0.0;
};

/// Least depth over which pressed faces grow stiff [m]. They meet at their highest points first, so their stiffness
/// grows evenly from zero over a depth of closing. A kink in the stiffness that is crossed within a substep makes
/// energy. So the depth is also at least kClosingTravels times the travel of the faces in the last substep in which
/// they were open and bore nothing.
double closing_depth(const ShellModel& model);

/// Puts the two sides of an edge in contact as they stand: the springs start without force. Where damage weakens the
/// shell they close where they do at rest, since damage has opened them before. False where a side sees too few control
/// points.
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

/// Adds the forces of one chunk of all pairs of faces (PointsBeside). `advance`: a substep begins here, and faces slide
/// and crush as far as their laws ask; open faces take the depth of their next closing from their travel since the last
/// one. Between two substeps the force is a function of the gaps in the frame of the deformed surface, so momentum and
/// angular momentum stay to round-off.
void interlock_forces(const ShellModel& model, ShellState& state, bool advance, int chunk, int chunks, const double* x,
                      double* force);
/// Energy of all faces at the last force [J].
double interlock_energy(const ShellState& state);
/// Books what faces have lost to friction and to crushing since the last call.
void book_faces(ShellState& state);

/// Releases faces that the last force found apart (`all`: all faces). Books the energy that the springs hold at the
/// present positions as contact of faces.
void release_interlocks(const ShellModel& model, ShellState& state, const InterlockLaw& law, bool all);

}  // namespace sunder::shell
