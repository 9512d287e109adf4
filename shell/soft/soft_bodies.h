#pragma once
// The soft bodies of a scene. They step together, against rigid bodies, shells and one another.
#include <cstdint>
#include <vector>

#include "shell/soft/soft_contact.h"
#include "shell/soft/soft_proxy.h"
#include "shell/soft/soft_state.h"
#include "shell/solver/finite.h"

namespace sunder::shell {

/// A soft body of the scene and its initial motion.
struct SoftSetup {
  SoftModel model;
  Vec3 velocity = Vec3::Zero(), angular = Vec3::Zero();  // of its centre [m/s], [rad/s]
};

/// Model and state of all soft bodies, and their contact. A step of theirs spans several substeps of the shells.
class SoftBodies {
 public:
  SoftBodies() = default;
  /// `shells` is the number of shells; `laws` holds the friction between contact groups.
  SoftBodies(const std::vector<SoftSetup>& setups, std::size_t shells, const std::vector<ContactLaw>& laws);

  bool empty() const { return models_.empty(); }
  const std::vector<SoftModel>& models() const { return models_; }
  const std::vector<SoftState>& states() const { return states_; }
  std::vector<SoftState>& states() { return states_; }  // for tests that hold particles

  /// Stable step [s] of all soft bodies at the strongest compression so far. It never grows, because each change of the
  /// step costs leapfrog some energy.
  double stable_step() const { return stable_; }
  /// Begins a step of the soft bodies. The step spans as many of the `left` substeps of `dt` [s] as `safety` times the
  /// stable step allows; returns that number, at least 1. Call it when shells and rigid bodies are at the start of the
  /// substep and have been kicked. Rigid bodies receive their impulses now. Where even one substep is too long, the
  /// soft bodies take several steps in it.
  int begin(const Vec3& gravity, double dt, int left, double safety, std::vector<Proxy>& bodies,
            const std::vector<ShellRef>& shells, int threads);
  /// Solves contact with shells and between soft bodies; call it once in each substep of `dt` [s], after the shells'
  /// kick.
  void touch(const std::vector<ShellRef>& shells, double dt);
  /// Ends the step: grid velocities go back to the particles, which drift. Call it at the end of the last substep.
  void finish(int threads);
  /// Takes the whole step where nothing else moves meanwhile: one step of `dt` [s], or several shorter ones.
  void step(const Vec3& gravity, double dt, double safety, std::vector<Proxy>& bodies) {
    begin(gravity, dt, 1, safety, bodies, {}, 1), touch({}, dt), finish(1);
  }
  /// Throws Error (unstable) where a particle's position, velocity or deformation is not finite. The message names the
  /// body, the place where the particle was made, the time [s] and a remedy. Call it before begin().
  void check_finite(double time, const StepRule& rule) const;
  /// Makes the next step look up again which places of the shells can be touched.
  void forget() { contact_.forget(); }
  template <class A>
  void archive_state(A& a) {
    archive_one(a, stable_);
    for (SoftState& s : states_) archive_one(a, s);
  }

  /// Sums over all soft bodies: mass, energies, momenta.
  SoftSums sums(const Vec3& gravity) const;
  /// Sum of the energy books of all soft bodies [J].
  EnergyBook book() const;
  /// Upper bound of the stiffness [N/m] by which soft bodies resist a rigid body; 0 where none is near.
  double stiffness_against(const Proxy& body) const;

 private:
  double stable_now() const;
  const std::vector<SoftRef>& refs();  // valid until the next call
  std::vector<SoftModel> models_;
  std::vector<SoftState> states_;
  std::vector<std::vector<double>> friction_;  // [soft body][contact group]
  SoftContact contact_;
  std::vector<SoftRef> refs_;  // scratch of refs()
  PressScratch scratch_;
  double stable_ = 0.0;
  double open_ = 0.0, elapsed_ = 0.0;  // length of the step that has begun, and its part that is over [s]
};

}  // namespace sunder::shell
