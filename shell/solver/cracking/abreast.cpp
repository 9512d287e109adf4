#include "shell/solver/cracking/abreast.h"

#include <algorithm>

namespace sunder::shell {

std::vector<double> shares_abreast(const ShellModel& m, std::span<const Tip> tips, std::span<const Drive> drives) {
  const auto shares = [&](std::size_t k) { return tips[k].alive && drives[k].release < 0.0; };
  std::vector<double> out(tips.size(), 1.0);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const double own = drives[i].ratio * drives[i].ratio;
    if (!shares(i) || !(own > 0.0)) continue;
    double most = own, sum = own;
    for (std::size_t k = 0; k < tips.size(); ++k) {
      if (k == i || !shares(k) || !((tips[k].p - tips[i].p).norm() < kReleaseLeast * m.spacing) ||
          !(tips[k].direction.dot(tips[i].direction) > 0.0))
        continue;
      const double other = drives[k].ratio * drives[k].ratio;
      most = std::max(most, other), sum += other;
    }
    out[i] = most / sum;
  }
  return out;
}

}  // namespace sunder::shell
