#include "shell/run/equilibria.h"

#include <algorithm>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

void keep_last(const Equilibria& e, double time) {
  e.simulation.make_states();  // of shells whose turn would have come
  e.pieces.look();
  e.recorder.write_frame(time);
}

}  // namespace

void Equilibria::find_first(const std::function<void()>& look) const {
  try {
    simulation.start_shells(look);
  } catch (const Error& e) {
    if (e.kind == "equilibrium") keep_last(*this, 0.0);
    throw;
  }
}

void Equilibria::find_all(const std::function<void()>& look) const {
  simulation.make_states();
  for (int step = 0; step < setup.steps; ++step) {
    try {
      simulation.find_equilibria(step, look);
    } catch (const Error& e) {
      double share = 1.0;  // of the way to this step, for the shell that has failed
      for (const ShellPart& part : simulation.state.shells)
        if (!part.equilibrium.converged) share = std::min(share, part.equilibrium.share);
      if (e.kind == "equilibrium" && (step > 0 || share > 0.0)) keep_last(*this, step + share);
      throw;
    }
    clock.tick = ++clock.windows;
    pieces.look();
    const double energy = simulation.total_energy(0.0);
    if (step == 0) books.open(simulation, energy);
    recorder.write_series_row();
    recorder.write_probes();
    recorder.write_frame();
    recorder.progress(step + 1 == setup.steps);
  }
}

}  // namespace sunder::shell
