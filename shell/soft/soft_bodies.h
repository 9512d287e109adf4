#pragma once
// The soft bodies of a scene: all of them take a step together, against rigid bodies, shells and one another.
#include <cstdint>
#include <vector>

#include "shell/soft/soft_contact.h"
#include "shell/soft/soft_proxy.h"
#include "shell/soft/soft_state.h"

namespace sunder::shell {

/// A soft body of the scene, and how it starts.
struct SoftSetup {
  SoftModel model;
  Vec3 velocity = Vec3::Zero(), angular = Vec3::Zero();  // [m/s], [rad/s]
};

class SoftBodies {
 public:
  SoftBodies() = default;
  /// `laws` between contact groups; those of the shells are theirs.
  SoftBodies(const std::vector<SoftSetup>& setups, const std::vector<const ShellModel*>& shells,
             const std::vector<ContactLaw>& laws);

  bool empty() const { return models_.empty(); }
  const std::vector<SoftModel>& models() const { return models_; }
  const std::vector<SoftState>& states() const { return states_; }
  std::vector<SoftState>& states() { return states_; }  // for tests that hold them
  int particles() const;

  /// Of all of them [s], as far as they have been squeezed: it never grows, as every change of the step costs leapfrog
  /// some energy.
  double stable_step() const { return stable_; }
  /// All bodies from t to t + dt, in several steps where what they have become is stable for `safety` of that only.
  /// Shells and rigid bodies stand at t, velocities as kicked (shells by `shell_dt`); they take impulses and do not
  /// move.
  void step(const Vec3& gravity, double dt, double safety, std::vector<Proxy>& bodies,
            const std::vector<ShellRef>& shells, double shell_dt, int threads);
  /// What a shell may touch is looked up anew in the next step.
  void forget() { contact_.forget(); }
  template <class A>
  void archive_state(A& a) {
    archive_one(a, stable_);
    for (SoftState& s : states_) archive_one(a, s);
  }

  SoftSums sums(const Vec3& gravity) const;
  EnergyBook book() const;
  /// At most, what a body that touches one of them is held by [N/m]; 0: none is near.
  double stiffness_against(const Proxy& body) const;

 private:
  double stable_now() const;
  std::vector<SoftModel> models_;
  std::vector<SoftState> states_;
  std::vector<std::vector<double>> friction_;  // [soft body][contact group]
  SoftContact contact_;
  double stable_ = 0.0;
};

}  // namespace sunder::shell
