#include "shell/solver/cracking/abreast.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {

std::vector<double> shares_abreast(const ShellModel& m, const ShellState& s, const CrackRules& r,
                                   std::span<const Drive> drives) {
  const std::vector<Tip>& tips = s.cracks.tips;
  const double fall = 0.5 * kRadialFall / (r.tip_radius * r.tip_radius);
  const double reach = std::pow(kReleaseLeast * m.spacing, 2);
  std::vector<double> out(tips.size(), 1.0);
  std::vector<std::size_t> driven;  // by mean stress; most tips have ended, and are not looked at again
  for (std::size_t i = 0; i < tips.size(); ++i)
    if (tips[i].alive && drives[i].release < 0.0 && drives[i].ratio > 0.0) driven.push_back(i);
  for (const std::size_t i : driven) {
    const double own = drives[i].ratio * drives[i].ratio;
    double most = own, sum = own;
    for (const std::size_t k : driven) {
      const double apart = (tips[k].p - tips[i].p).squaredNorm();
      if (k == i || !(apart < reach) || !(tips[k].direction.dot(tips[i].direction) > 0.0) ||
          !s.cracks.graph.visible(tips[i].p, tips[k].p, tips[i].edge, tips[k].edge))
        continue;
      const double other = std::exp(-fall * apart) * drives[k].ratio * drives[k].ratio;
      most = std::max(most, other), sum += other;
    }
    out[i] = most / sum;
  }
  return out;
}

}  // namespace sunder::shell
