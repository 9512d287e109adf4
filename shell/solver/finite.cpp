#include "shell/solver/finite.h"

#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

constexpr double kLeastSafety = 0.1;  // a shell that is unstable in such substeps has another fault

}  // namespace

std::string unstable_remedy(const StepRule& rule) {
  if (rule.time_step > 0.0) return fmt::format("lower time_step_s, which is {} s, or refine", rule.time_step);
  if (rule.safety <= kLeastSafety) return fmt::format("refine: time_step_safety is {} already", rule.safety);
  return fmt::format(
      "lower time_step_safety, which is {}, or shorten window_s, between two of which the step is measured; refine "
      "where neither helps",
      rule.safety);
}

void check_finite(const ShellModel& m, const ShellState& s, double time, const StepRule& rule) {
  double sum = 0.0;  // one number that is not finite makes it so
  for (std::size_t i = 0; i < s.motion.x.size(); ++i) sum += 0.0 * s.motion.x[i] + 0.0 * s.motion.v[i];
  if (sum == 0.0) return;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (s.position(slot).allFinite() && s.velocity(slot).allFinite()) continue;
    throw Error(
        Exit::kPhysics, "unstable",
        fmt::format("shell '{}' is unstable: at (u, v) = ({:.4g}, {:.4g}) and {:.6g} s its motion is not finite; {}",
                    m.name, m.parameter[i].x(), m.parameter[i].y(), time, unstable_remedy(rule)));
  }
}

void check_finite(const std::vector<Proxy>& bodies, std::int64_t window, const StepRule& rule) {
  for (const Proxy& p : bodies) {
    if (p.body.motion.position.allFinite() && p.body.motion.velocity.allFinite()) continue;
    Error e(Exit::kPhysics, "unstable",
            fmt::format("the motion of '{}' is not finite: what it touches is unstable; {}", p.body.name,
                        unstable_remedy(rule)));
    e.window = window, e.body = p.body.name;
    throw e;
  }
}

}  // namespace sunder::shell
