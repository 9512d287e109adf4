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
  /// `laws` between contact groups; `shells`: how many there are.
  SoftBodies(const std::vector<SoftSetup>& setups, std::size_t shells, const std::vector<ContactLaw>& laws);

  bool empty() const { return models_.empty(); }
  const std::vector<SoftModel>& models() const { return models_; }
  const std::vector<SoftState>& states() const { return states_; }
  std::vector<SoftState>& states() { return states_; }  // for tests that hold them

  /// Of all of them [s], as far as they have been squeezed: it never grows, as every change of the step costs leapfrog
  /// some energy.
  double stable_step() const { return stable_; }
  /// A step of theirs, over as many of the `left` substeps of `dt` [s] as are stable for `safety` of that: returns how
  /// many. It begins when shells and rigid bodies stand where they do and are kicked; rigid bodies take their impulses
  /// now. Where a substep is too long for them, they take several steps in it.
  int begin(const Vec3& gravity, double dt, int left, double safety, std::vector<Proxy>& bodies,
            const std::vector<ShellRef>& shells, int threads);
  /// In each of these substeps: against shells, kicked by `dt`, and one another.
  void touch(const std::vector<ShellRef>& shells, double dt);
  /// As the last of these substeps ends.
  void finish(int threads);
  /// All of that where nothing else moves meanwhile: one step of `dt` or several.
  void step(const Vec3& gravity, double dt, double safety, std::vector<Proxy>& bodies) {
    begin(gravity, dt, 1, safety, bodies, {}, 1), touch({}, dt), finish(1);
  }
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
  const std::vector<SoftRef>& refs();  // until the next call
  std::vector<SoftModel> models_;
  std::vector<SoftState> states_;
  std::vector<std::vector<double>> friction_;  // [soft body][contact group]
  SoftContact contact_;
  std::vector<SoftRef> refs_;  // scratch of refs()
  PressScratch scratch_;
  double stable_ = 0.0;
  double open_ = 0.0, elapsed_ = 0.0;  // length of the step that has begun, and how much of it is over [s]
};

}  // namespace sunder::shell
