#pragma once
// The energy release of a tip as a domain integral.
#include <optional>

#include "shell/solver/state.h"

namespace sunder::shell {

/// Energy that an advance of a tip along `look.direction` releases for each area of crack, and the same across it, to
/// the left [J/m^2]. The second tells a sheet that is torn out of its plane where to go on; it lacks what the faces of
/// the crack add where the sheet is stretched along them.
///
/// J of Rice 1968 as a domain integral, for a Kirchhoff-Love shell at any rotation. The virtual advance is chi e: e is
/// the unit vector at rest, chi is 1 near the tip and 0 beyond `outer`. The advance pushed forward is w chi, w = x_,c
/// e^c. With any smooth field f the work of chi f vanishes in a shell that moves by itself. f is the linear field
/// nearest to w, so that what is of first order in the stress cancels:
///
///     G thickness = int n^ab (w chi_,a - (chi f)_,a) . x_,b + n^ab bbar_ab (e . nbar) chi
///                 - int m^ab (2 b_bc e^c chi_,a - ((chi f)_,ab - Gamma^c_ab (chi f)_,c) . n)
///                 - int (W + K) e^c chi_,c + int rho thickness (a . (w - f) - v . v_,c e^c) chi
///                 - int (d(W + K) / d thickness) thickness_,c e^c chi
///
/// over the area at rest; W and K are the elastic and the kinetic energy of it. Loads are left out: they are of second
/// order in the radius. Zero in a smooth field. Not valid where `outer` reaches another tip, crack or border, nor where
/// layers have a memory.
Vec2 energy_release_at(const ShellModel& model, const ShellState& state, const ReleaseLook& look);
/// The same, with the points of an earlier call.
Vec2 energy_release_at(const ShellModel& model, const ShellState& state, const ReleaseLook& look, ReleaseRing& known);

/// The same of a running tip, over as wide a ring as fits between it and other tips, other cracks and the border. Empty
/// where none fits, of a crack shorter than its flaw, and where J says nothing: beside layers that yield or weaken, and
/// beside an interlayer.
std::optional<Vec2> tip_release(const ShellModel& model, const ShellState& state, const Tip& tip, ReleaseRing& known);

/// Distance between the faces behind a tip along the mean of their normals [m]: of the means over either side of the
/// ring.
double faces_apart(const ShellState& state, const ReleaseRing& ring);

/// Energy release of a tip that turns by `turn` [rad], over that of one that runs straight on. The turn tells the share
/// of shear by maximum hoop stress, and so the opening of the kink (Erdogan and Sih 1963): 1 at 0, 4/3 at 70.5 degrees.
double kink_factor(double turn);

}  // namespace sunder::shell
