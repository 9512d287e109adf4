#pragma once
// Shells with fibres, one over the other, stepped together.
#include <memory>
#include <vector>

#include "shell/solver/contact/fibres.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {

struct Pile {
  std::vector<std::unique_ptr<ShellModel>> models;
  std::vector<std::unique_ptr<ShellState>> states;
  std::vector<ShellRef> shells;
  std::unique_ptr<Fibres> fibres;
  Vec3 gravity = Vec3::Zero();

  Pile() = default;
  Pile(const Pile&) = delete;
  void add(ShellModel model, const FibreLaw& law, const Vec3& velocity = Vec3::Zero()) {
    model.fibres = law;
    models.push_back(std::make_unique<ShellModel>(std::move(model)));
    states.push_back(std::make_unique<ShellState>(make_state(*models.back(), velocity, 0)));
    shells.push_back({models.back().get(), states.back().get()});
  }
  std::vector<const ShellModel*> pointers() const {
    std::vector<const ShellModel*> out;
    for (const auto& m : models) out.push_back(m.get());
    return out;
  }
  void join(double spacing) { fibres = std::make_unique<Fibres>(pointers(), std::vector<Seam>{}, spacing); }
  /// Stable step of the least stable one, with fibres [s].
  double step() {
    double least = 1e300;
    for (const ShellRef& r : shells) least = std::min(least, stable_step(*r.model, *r.state, 80, 1, false));
    return stable_step_with_fibres(least, pointers());
  }
  void forces() {
    for (const ShellRef& r : shells) compute_forces(*r.model, *r.state, false, 0.0, 1);
    fibres->add_forces(shells);
  }
  template <class F>
  void run(int steps, double dt, F&& look) {
    for (int k = 0; k < steps; ++k) {
      forces();
      for (const ShellRef& r : shells) kick(*r.model, *r.state, gravity, dt), constrain(*r.model, *r.state, dt);
      for (const ShellRef& r : shells) drift(*r.model, *r.state, dt);
      fibres->advance(shells, dt);
      look();
    }
  }
  void run(int steps, double dt) {
    run(steps, dt, [] {});
  }
  /// With its books [J].
  double energy(double dt) {
    double sum = 0.0;
    for (const ShellRef& r : shells) sum += compute_forces(*r.model, *r.state, true, 0.0, 1);
    fibres->add_forces(shells);
    for (const ShellRef& r : shells) sum += kinetic_energy(*r.model, *r.state, dt) + r.state->book.lost();
    return sum + fibres->energy();
  }
  Totals sums() const {
    Totals t = totals(*models[0], *states[0]);
    for (std::size_t k = 1; k < models.size(); ++k) t += totals(*models[k], *states[k]);
    return t;
  }
};

}  // namespace sunder::shell
