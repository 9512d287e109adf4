#pragma once
// Cracks that find their own way: growth at tips by fracture energy, nucleation by strength.
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

/// The open ends of a cut, edges `first` to before `last` of the graph, may run on from now on.
void start_at_ends(const ShellModel& model, ShellState& state, int first, int last);

/// Nucleation and growth over the last `dt` seconds. `random` is advanced only where chance decides a direction.
/// Returns the number of edges inserted.
int grow_cracks(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, double dt,
                std::uint64_t& random);

}  // namespace sunder::shell
