#pragma once
// The engine without contacts and joints, as an exact reference.
#include <map>

#include "rigid/engine/engine.h"

namespace sunder::rigid {

/// Each body ends a window in its predicted state, to the bit.
class FreeFlight final : public Engine {
 public:
  EngineInfo info() const override;
  void add(const RigidBody& body) override;
  void set_contact_laws(const std::vector<ContactLaw>&) override {}
  void advance(double window_s, const std::vector<PredictedState>& predicted,
               const std::vector<BodyId>& solved) override;
  std::vector<EngineState> states() const override;
  std::vector<ContactRow> rows(double, const std::vector<PredictedState>&, const std::vector<BodyId>&) override {
    return {};
  }
  std::string save() override { return {}; }
  void restore(const std::string& caches, const std::vector<PredictedState>& motions) override;

 private:
  void move(const std::vector<PredictedState>& motions);
  std::map<BodyId, RigidBody> bodies_;
};

}  // namespace sunder::rigid
