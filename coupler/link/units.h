#pragma once
// An engine in units of the scene's size. Engines have fixed lengths, such as margins and gaps, that suit bodies of
// some centimetres.
#include "coupler/link/engine.h"

namespace sunder::link {

/// Unit of length [m] for shells of a thickness [m]. It is 1 for thicknesses from an eighth of a millimetre to an
/// eighth of a metre, and for 0 (not known). Otherwise it is the power of two that makes the thickness about 4 mm. The
/// units of time [s] and mass [kg] are the same number and its cube, so speeds and densities keep their values. Scaling
/// by powers of two is exact.
double length_unit(double thickness);

/// Converts between SI and the units of an engine `inner`. Saved state is passed on as it is.
class InUnits final : public Engine {
 public:
  explicit InUnits(Engine& inner) : inner_(inner) {}
  /// Sets the unit of length [m], before the first body.
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
