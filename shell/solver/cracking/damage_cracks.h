#pragma once
// Cracks from damage, as in the paper (sections 5.1, 5.2): stress damages and heals, what has ever been fully damaged
// is a region, and the middle line of the region becomes the crack.
#include "shell/solver/cracking/criteria.h"

namespace sunder::shell {

/// Damage is watched in each substep; where it is complete, cracks are extracted.
Criterion cracks_from_damage();

/// Hands the Gauss points that come near their strength, or whose fibres are damaged, to the damage law. Call it with
/// the stress of the present substep, not with a mean over time.
void watch_stress(const ShellModel& model, ShellState& state);

/// A point that was fully damaged once bears no bending any more where it is folded about as sharply as it is thick. It
/// bears nothing where its middle surface itself is crushed, or where it bore nothing before, being inside out. What it
/// has lost does not come back, and its energy is booked. A compressed layer heals, so the law alone would let such a
/// fold bear fully, and grow stiffer the sharper it is.
void release_folds(const ShellModel& model, ShellState& state);

/// Inserts the middle lines of what was fully damaged since the last call. Ends go on, branches join their stems, and
/// ends near the border run out. Earlier cracks stay as they are. Returns the number of edges inserted.
int extract_cracks(const ShellModel& model, ShellState& state, double time, const DamageRules& rules = {});

}  // namespace sunder::shell
