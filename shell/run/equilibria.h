#pragma once
// The equilibria in which shells start, and those of a scene in which nothing moves.
#include <functional>

#include "shell/run/recorder.h"

namespace sunder::shell {

/// Finds equilibria and records them. What it refers to must outlive it.
struct Equilibria {
  const RunSetup& setup;
  Clock& clock;
  Simulation& simulation;
  Pieces& pieces;
  Books& books;
  Recorder& recorder;

  /// Starts all shells, in equilibrium where the scene asks for it. Throws Error (equilibrium) after a frame has
  /// recorded how far it came. `look` is called now and then; it may throw.
  void find_first(const std::function<void()>& look) const;
  /// Finds those of all load steps, where nothing moves: each is a window of the run. Throws the same.
  void find_all(const std::function<void()>& look) const;
};

}  // namespace sunder::shell
