#pragma once
// An engine in units of the scene's size: engines have lengths of their own (margins, gaps), which suit what a hand can
// hold.
#include "coupler/link/engine.h"

namespace sunder::link {

/// The unit of length [m] for a scene of this typical length [m]: 1 for what is about a centimetre to ten metres, and
/// where nothing is known (0); else the power of two that makes it a third of a metre. Units of time [s] and mass [kg]
/// are the same number and its cube: speeds and densities stay, and powers of two lose no digit.
double length_unit(double typical_length);

/// The engine `inner` as if it counted in units of `unit`. Caches are `inner`'s own.
class InUnits final : public Engine {
 public:
  explicit InUnits(Engine& inner) : inner_(inner) {}
  /// Before the first body.
  void set_unit(double unit) { unit_ = unit; }

  EngineInfo info() const override { return inner_.info(); }
  void add(const RigidBody& body) override;
  void set_contact_laws(const std::vector<ContactLaw>& laws) override { inner_.set_contact_laws(laws); }
  void advance(double window_s, const std::vector<Motion>& handbacks, const std::vector<BodyId>& solved) override;
  std::vector<State> states() const override;
  void add_joint(const Joint& joint) override;
  std::vector<ContactRow> rows(double window_s, const std::vector<Motion>& motions,
                               const std::vector<BodyId>& bodies) override;
  std::string save() override { return inner_.save(); }
  void restore(const std::string& caches, const std::vector<Motion>& motions) override;

 private:
  BodyMotion inward(BodyMotion m) const;
  std::vector<Motion> inward(std::vector<Motion> motions) const;
  Engine& inner_;
  double unit_ = 1.0;
};

}  // namespace sunder::link
