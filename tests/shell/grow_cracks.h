#pragma once
// A look at the cracks of a shell whose tips run, with rules of the test.
#include "shell/solver/cracking/criteria.h"

namespace sunder::shell {

/// Growth and nucleation over the last `dt` seconds, and release of faces. Returns the number of edges inserted.
inline int grow_cracks(const ShellModel& model, ShellState& state, const CrackRules& tips, double time, double dt,
                       std::uint64_t& random) {
  FractureRules rules;
  rules.mode = FractureMode::kTips, rules.tips = tips;
  return propose_edges({model, state, rules, time, dt, random}, CrackMoment::kLook);
}

}  // namespace sunder::shell
