#pragma once
// Criteria of fracture behind one interface: each looks at a shell and proposes new edges, which enter the mechanics
// through insertion.h only. A new criterion is a source and its header, and in criteria.cpp an #include and one line.
#include <span>

#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

/// What a criterion looks at and may crack.
struct CrackLook {
  const ShellModel& model;
  ShellState& state;
  const FractureRules& rules;
  double time;                               // of the positions [s]
  double span;                               // since the last look, or until the next one for kWindow [s]
  std::uint64_t& random;                     // advanced only where chance decides a direction
  std::vector<EdgeCut>* on_edges = nullptr;  // what cuts open of seams; of kWindow
};

/// When a criterion proposes edges.
enum class CrackMoment {
  kWindow,  // at the start of each window
  kLook,    // at a look, every crack_interval() substeps
};

struct Criterion {
  const char* name;
  CrackMoment moment;
  /// Whether these rules ask for it.
  bool (*asked)(const FractureRules& rules);
  /// Inserts its edges. Returns how many.
  int (*propose)(const CrackLook& look);
  /// Share of a new stress in the running mean that it looks at, for substeps of `dt` [s]; null: it looks at none.
  double (*stress_share)(const ShellModel& model, double dt) = nullptr;
  /// Called after each substep; null: nothing to do.
  void (*watch)(const CrackLook& look) = nullptr;
};

/// All of them, in the order in which they propose.
std::span<const Criterion> all_criteria();

/// Calls f with each criterion that the rules ask for.
template <class F>
void each_criterion(const FractureRules& rules, F&& f) {
  for (const Criterion& c : all_criteria())
    if (c.asked(rules)) f(c);
}

/// Whether any criterion is asked for.
bool can_crack(const FractureRules& rules);

/// Share of a new stress in the running mean, the largest that a criterion asks for; 0: none looks at it.
double stress_share(const FractureRules& rules, const ShellModel& model, double dt);

/// All criteria of the moment propose in turn. At a look, or at a window's start where no criterion has looks, faces
/// that no longer bear are released afterwards. Returns the number of edges inserted.
int propose_edges(const CrackLook& look, CrackMoment moment);

}  // namespace sunder::shell
