#pragma once
// An engine in units of the scene's size: engines have lengths of their own (margins, gaps), which suit what a hand can
// hold.
#include "coupler/link/engine.h"

namespace sunder::link {

/// The unit of length [m] for shells of this thickness [m]: 1 for an eighth of a millimetre to an eighth of a metre,
/// and where there is none (0); else the power of two that makes it about 4 mm. Units of time [s] and mass [kg] are the
/// same number and its cube: speeds and densities stay, and powers of two lose no digit.
double length_unit(double thickness);

/// The engine `inner` as if it counted in units of `unit`. Caches are `inner`'s own.
class InUnits final : public Engine {
 public:
  explicit InUnits(Engine& inner) : inner_(inner) {}
  /// Before the first body.
  void set_unit(double unit) { unit_ = unit; }

  EngineInfo info() const override { return inner_.info(); }
  void add(const RigidBody& body) override;
  void set_contact_laws(const std::vector<ContactLaw>& laws) override { inner_.set_contact_laws(laws); }
  void advance(double window_s, const std::vector<Motion>& predicted, const std::vector<BodyId>& solved) override;
  std::vector<State> states() const override;
  void add_joint(const Joint& joint) override;
  void release_joint(std::uint32_t id) override { inner_.release_joint(id); }
  std::vector<ContactRow> rows(double window_s, const std::vector<Motion>& motions,
                               const std::vector<BodyId>& bodies) override;
  std::string save() override { return inner_.save(); }
  void restore(const std::string& caches, const std::vector<Motion>& motions) override;

 private:
  template <class F>
  void in_units(F&& call) const;
  BodyMotion inward(BodyMotion m) const;
  std::vector<Motion> inward(std::vector<Motion> motions) const;
  Engine& inner_;
  double unit_ = 1.0;
};

}  // namespace sunder::link
