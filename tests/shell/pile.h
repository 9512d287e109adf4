#pragma once
// Shells with fibres, one over the other.
#include <algorithm>
#include <utility>
#include <vector>

#include "shell/solver/contact/fibres.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"

namespace sunder::shell {

struct Layer {
  ShellModel model;
  FibreLaw law;
  Vec3 velocity = Vec3::Zero();  // [m/s]
};

/// Layers on a grid of fibres of this spacing [m].
struct Pile : Rig {
  Pile(std::vector<Layer> layers, double spacing) : Pile(piled(std::move(layers), spacing)) {}
  explicit Pile(RunSetup setup) : Rig(std::move(setup)) {}

  static RunSetup piled(std::vector<Layer> layers, double spacing) {
    RunSetup out;
    for (Layer& l : layers) {
      l.model.fibres = l.law;
      out.shells.push_back({std::move(l.model), l.velocity});
    }
    out.fibre_spacing = spacing;
    return out;
  }
  Fibres& fibres() { return *now().fibres; }
  /// Stable step of the least stable one, with fibres [s].
  double stable() {
    double least = 1e300;
    for (std::size_t k = 0; k < size(); ++k) least = std::min(least, stable_step(model(k), state(k), 80, 1, false));
    return stable_step_with_fibres(least, setup().models());
  }
  void forces() {
    for (std::size_t k = 0; k < size(); ++k) compute_forces(model(k), state(k), false, 0.0, 1);
    fibres().add_forces(refs());
  }
  /// With its books [J].
  double energy(double dt) {
    double sum = 0.0;
    for (std::size_t k = 0; k < size(); ++k) sum += compute_forces(model(k), state(k), true, 0.0, 1);
    fibres().add_forces(refs());
    if (!now().stitching.empty()) now().stitching.move_forces(refs());
    for (std::size_t k = 0; k < size(); ++k) sum += kinetic_energy(model(k), state(k), dt) + state(k).book.lost();
    return sum + fibres().energy();
  }
  double contact() const {  // energy that slipping took [J]
    double sum = 0.0;
    for (std::size_t k = 0; k < size(); ++k) sum += state(k).book.contact;
    return sum;
  }
  Totals sums() const {
    Totals t = totals(model(0), state(0));
    for (std::size_t k = 1; k < size(); ++k) t += totals(model(k), state(k));
    return t;
  }
};

}  // namespace sunder::shell
