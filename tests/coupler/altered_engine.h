#pragma once
// An engine that flies freely and changes what it tells.
#include <functional>
#include <string>
#include <vector>

#include "rigid/engine/free_flight.h"

namespace sunder {

struct AlteredEngine final : link::Engine {
  std::function<void(std::vector<link::State>&)> alter;  // what states() tells after the first window
  rigid::FreeFlight whole;
  bool advanced = false;

  explicit AlteredEngine(std::function<void(std::vector<link::State>&)> by) : alter(std::move(by)) {}
  link::EngineInfo info() const override { return whole.info(); }
  void add(const RigidBody& body) override { whole.add(body); }
  void set_contact_laws(const std::vector<ContactLaw>& laws) override { whole.set_contact_laws(laws); }
  void advance(double window_s, const std::vector<link::Motion>& predicted,
               const std::vector<BodyId>& solved) override {
    whole.advance(window_s, predicted, solved), advanced = true;
  }
  std::vector<link::State> states() const override {
    auto states = whole.states();
    if (advanced) alter(states);
    return states;
  }
  std::vector<link::ContactRow> rows(double window_s, const std::vector<link::Motion>& motions,
                                     const std::vector<BodyId>& bodies) override {
    return whole.rows(window_s, motions, bodies);
  }
  std::string save() override { return whole.save(); }
  void restore(const std::string& caches, const std::vector<link::Motion>& motions) override {
    whole.restore(caches, motions);
  }
};

}  // namespace sunder
