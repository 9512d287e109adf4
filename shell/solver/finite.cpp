#include "shell/solver/finite.h"

#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {

void check_finite(const ShellModel& m, const ShellState& s, double time) {
  double sum = 0.0;  // one number that is not finite makes it so
  for (std::size_t i = 0; i < s.motion.x.size(); ++i) sum += 0.0 * s.motion.x[i] + 0.0 * s.motion.v[i];
  if (sum == 0.0) return;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (s.position(slot).allFinite() && s.velocity(slot).allFinite()) continue;
    throw Error(
        Exit::kPhysics, "unstable",
        fmt::format("shell '{}' is unstable: at (u, v) = ({:.4g}, {:.4g}) and {:.6g} s its motion is not finite; "
                    "lower time_step_safety, or refine",
                    m.name, m.parameter[i].x(), m.parameter[i].y(), time));
  }
}

}  // namespace sunder::shell
