#pragma once
// Tips that run abreast, and the energy that they have together.
#include <span>
#include <vector>

#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/model.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// Share of its energy release [-] that each tip may spend. Mean stress ahead counts the same energy for each of
/// several tips that go the same way, see each other, and are too near for a ring of their own. Share = max w g / sum w
/// g, over the tip and those abreast of it: g = ratio^2, and w is the overlap of the weights of their means, exp(-a d^2
/// / (2 R^2)) at a distance d. Side by side and very near, they have together what one would have alone. 1 for a tip
/// with a ring, or alone, or dead. `drives` are those of the tips of `state`, before shares.
std::vector<double> shares_abreast(const ShellModel& model, const ShellState& state, const CrackRules& rules,
                                   std::span<const Drive> drives);

}  // namespace sunder::shell
