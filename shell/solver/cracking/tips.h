#pragma once
// Growth of cracks at their tips, by fracture energy.
#include "shell/solver/cracking/criteria.h"

namespace sunder::shell {

/// Tips run where the energy release exceeds the fracture energy (Freund's energy balance), and divide.
Criterion tips_by_energy();

/// The open ends of a cut, edges `first` to before `last` of the graph, may run on from now on.
void start_at_ends(const ShellModel& model, ShellState& state, int first, int last);

}  // namespace sunder::shell
