#include "shell/solver/cracking/abreast.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {

std::vector<double> shares_abreast(const ShellModel& m, const ShellState& s, const CrackRules& r,
                                   std::span<const Drive> drives) {
  const std::vector<Tip>& tips = s.cracks.tips;
  const double fall = 0.5 * kRadialFall / (r.tip_radius * r.tip_radius);
  const auto shares = [&](std::size_t k) { return tips[k].alive && drives[k].release < 0.0; };
  std::vector<double> out(tips.size(), 1.0);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const double own = drives[i].ratio * drives[i].ratio;
    if (!shares(i) || !(own > 0.0)) continue;
    double most = own, sum = own;
    for (std::size_t k = 0; k < tips.size(); ++k) {
      const double apart = (tips[k].p - tips[i].p).squaredNorm();
      if (k == i || !shares(k) || !(apart < std::pow(kReleaseLeast * m.spacing, 2)) ||
          !(tips[k].direction.dot(tips[i].direction) > 0.0) ||
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
