#include "shell/solver/cracking/criteria.h"

#include <algorithm>

#include "shell/solver/cracking/damage_cracks.h"
#include "shell/solver/cracking/nucleation.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tips.h"

namespace sunder::shell {

std::span<const Criterion> all_criteria() {
  static const Criterion all[] = {
      prescribed_cuts(),
      tips_by_energy(),
      nucleation_by_strength(),
      cracks_from_damage(),
  };
  return all;
}

bool can_crack(const FractureRules& rules) {
  const auto all = all_criteria();
  return std::any_of(all.begin(), all.end(), [&](const Criterion& c) { return c.asked(rules); });
}

double stress_share(const FractureRules& rules, const ShellModel& model, double dt) {
  double share = 0.0;
  each_criterion(rules, [&](const Criterion& c) {
    if (c.stress_share) share = std::max(share, c.stress_share(model, dt));
  });
  return share;
}

int propose_edges(const CrackLook& look, CrackMoment moment) {
  int inserted = 0;
  each_criterion(look.rules, [&](const Criterion& c) {
    if (c.moment == moment) inserted += c.propose(look);
  });
  const auto all = all_criteria();
  const bool looks = std::any_of(all.begin(), all.end(), [&](const Criterion& c) {
    return c.moment == CrackMoment::kLook && c.asked(look.rules);
  });  // else faces are of cuts alone
  if ((moment == CrackMoment::kLook || !looks) && !look.state.cracks.interlocks.empty())
    release_interlocks(look.model, look.state, look.rules.tips.faces, false);
  return inserted;
}

}  // namespace sunder::shell
