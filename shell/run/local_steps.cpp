#include "shell/run/local_steps.h"

#include <algorithm>
#include <limits>

#include "shell/io/build_seams.h"
#include "shell/run/simulation.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/kick_drift.h"

namespace sunder::shell {
namespace {

// Leaves long steps to those shells of each group with which it is stable:
//   dt^2 (1/T^2 + 1/T_s^2) < 1/2, T the stable step of the group, T_s the least one of shells with long steps alone.
void keep_stable(const std::vector<StepLimit>& shells, double dt, std::vector<int>& every) {
  const double bound = 0.5 * kMostOfStable * kMostOfStable;
  const std::size_t count = shells.size();
  for (std::size_t k = 0; k < count; ++k) {
    double together = std::numeric_limits<double>::infinity();
    bool alone = true, may = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (shells[i].group != shells[k].group) continue;
      together = std::min(together, shells[i].joined);
      alone = alone && i == k, may = may && shells[i].may;
    }
    if (alone) continue;
    const double reached = dt * dt * (1.0 / (together * together) + 1.0 / (shells[k].alone * shells[k].alone));
    every[k] = may && reached <= bound ? std::min(every[k], kJoinedStep) : 1;
  }
}

std::vector<int> longest_steps(const std::vector<StepLimit>& shells, double dt, int most, double safety) {
  std::vector<int> every(shells.size(), 1);
  for (std::size_t k = 0; k < shells.size(); ++k)
    while (shells[k].may && 2 * every[k] <= most && 2 * every[k] * dt <= safety * shells[k].step) every[k] *= 2;
  keep_stable(shells, dt, every);
  return every;
}

}  // namespace

LocalSteps local_steps(const std::vector<StepLimit>& shells, double window, int least, double safety) {
  double work = 0.0, lowest = std::numeric_limits<double>::infinity();
  for (const StepLimit& s : shells) work += s.work;
  LocalSteps best;
  for (int most = 1; most <= kLongestStep; most *= 2) {
    const int substeps = (least + most - 1) / most * most;
    const std::vector<int> every = longest_steps(shells, window / substeps, most, safety);
    double sum = work;
    for (std::size_t k = 0; k < shells.size(); ++k) sum += shells[k].work / every[k];
    if (substeps * sum < lowest) lowest = substeps * sum, best = {substeps, every};
  }
  return best;
}

int Simulation::choose_local_steps(double tick, int least, int ticks) {
  if (!setup_.local_steps || !state.solving()) return least * ticks;
  std::vector<StepLimit> limits;
  for (const ShellPart& part : state.shells) {
    const ShellModel& m = part.model();
    StepLimit& l = limits.emplace_back();
    l.step = part.step_alone(), l.alone = part.measured_alone(), l.joined = part.smallest_step;
    l.work = static_cast<double>(m.tables.gauss_points()) * static_cast<double>(m.tables.layers.zeta.size());
    l.may = !state.fibres && m.material.stiffness_damping == 0.0 &&
            std::all_of(part.setup->hertz.begin(), part.setup->hertz.end(), [](double k) { return k == 0.0; });
  }
  int group = 0;
  for (const std::vector<int>& joined : joined_groups(setup_)) {
    for (const int k : joined) {
      limits[k].group = group;
      if (joined.size() > 1 && !state.seam_strength.empty()) limits[k].may = false;
    }
    ++group;
  }
  const LocalSteps chosen = local_steps(limits, tick, least, setup_.safety);
  for (std::size_t k = 0; k < limits.size(); ++k) {
    LocalStep& local = state.shells[k].local;
    local.before = local.every, local.every = chosen.every[k], local.together = 1;
    for (std::size_t i = 0; i < limits.size(); ++i)
      if (limits[i].group == limits[k].group) local.together = std::max(local.together, chosen.every[i]);
    state.local_work.done += limits[k].work * ticks * chosen.substeps / chosen.every[k];
    state.local_work.without += limits[k].work * ticks * least;
    state.local_work.largest = std::max<std::int64_t>(state.local_work.largest, chosen.every[k]);
  }
  return chosen.substeps * ticks;
}

std::vector<std::vector<double>> Simulation::weigh_forces(double dt) {
  std::vector<std::vector<double>> plain;
  if (std::none_of(state.shells.begin(), state.shells.end(), [](const ShellPart& p) { return p.local.every > 1; }))
    return plain;
  for (const ShellPart& part : state.shells) {
    plain.push_back(part.state->motion.force), plain.push_back(part.state->motion.external);
    if (part.local.every == 1) continue;
    if (state.stitching.empty()) apply_force_discontinuity({{&part.model(), part.state.get()}}, part.local.every * dt);
    scale_forces(*part.state, part.local.every);
  }
  return plain;
}

void Simulation::restore_forces(const std::vector<std::vector<double>>& plain) {
  for (std::size_t k = 0; k < plain.size() / 2; ++k) {
    Motion& motion = state.shells[k].state->motion;
    motion.force = plain[2 * k], motion.external = plain[2 * k + 1];
  }
  if (!plain.empty() && !state.stitching.empty()) state.stitching.move_forces(refs());
}

}  // namespace sunder::shell
