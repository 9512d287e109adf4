#include "shell/io/audit.h"

#include <cmath>

#include <fmt/format.h>

namespace sunder::shell {
namespace {

constexpr double kMade = 0.02;   // of the most energy there was: what has no business to be made, or is missing
constexpr double kGiven = 0.05;  // overlaps that are let go give a little
constexpr double kUncertain = 0.1, kFrozen = 0.1;

}  // namespace

std::vector<std::string> doubts(const Audit& audit) {
  const EnergyBook& b = audit.book;
  const auto share = [&](double energy) { return audit.scale > 0.0 ? energy / audit.scale : 0.0; };
  std::vector<std::string> out;
  if (!(std::abs(audit.residual) <= kMade))
    out.push_back(
        fmt::format("the energy books miss {:.1f} % of the energy there was: lower time_step_safety, or refine",
                    100.0 * audit.residual));
  if (share(audit.given) > kGiven)
    out.push_back(
        fmt::format("contact has given back {:.1f} % of the energy there was, where it can only take: lower "
                    "time_step_safety, or refine",
                    100.0 * share(audit.given)));
  if (share(-b.healing) > kMade)
    out.push_back(
        fmt::format("damage that healed has made {:.1f} % of the energy there was", 100.0 * share(-b.healing)));
  if (share(-b.handoff) > kMade)
    out.push_back(fmt::format("pieces that left as rigid bodies took {:.1f} % more energy with them than they had{}",
                              100.0 * share(-b.handoff), audit.grid_transfer ? ": the grid glues what is cut" : ""));
  if (share(audit.coupling) > kUncertain)
    out.push_back(fmt::format(
        "windows are too long for bodies that the shell pushes and the engine holds: {:.1f} % of the energy "
        "there was is uncertain by it; shorten window_s, give coupling.adaptive_window, or take an engine "
        "that can do 'export_rows'",
        100.0 * share(audit.coupling)));
  if (share(audit.frozen) > kFrozen)
    out.push_back(
        fmt::format("the shell was frozen while it still moved with {:.0f} % of the energy there was: raise "
                    "fracture.quiet_time_s or latest_freeze_s",
                    100.0 * share(audit.frozen)));
  return out;
}

}  // namespace sunder::shell
