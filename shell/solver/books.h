#pragma once
// The energy book of a shell: where its energy went.

namespace sunder::shell {

/// Energies that left the mechanics, each with its cause [J].
struct EnergyBook {
  double fracture = 0.0;       // released by new cracks; dissipated by irreversible damage
  double injected = 0.0;       // added by the force discontinuity of new cracks, beyond what they released
  double face_friction = 0.0;  // of crack faces that slide on each other, and held by those that came apart
  double face_crushing = 0.0;  // of crack faces pressed beyond the crushing strength
  double contact = 0.0;        // inelastic and frictional contact with bodies
  double handoff = 0.0;        // kinetic and elastic energy that a rigid piece cannot carry
  double external = 0.0;       // work of loads, moving supports and driven bodies, counted as a gain
  double healing = 0.0;        // lost in cycles of damage and healing; negative: gained
  double plastic = 0.0;        // dissipated by yielding
  double damping = 0.0;        // Rayleigh damping
  double transfer = 0.0;       // lost by the transfer through the background grid; negative: gained
  double frozen = 0.0;         // of the held part, when the shell is frozen

  /// Returns the energy that the mechanics have lost in total [J].
  double lost() const {
    return fracture - injected + face_friction + face_crushing + contact + handoff - external + healing + plastic +
           transfer + damping + frozen;
  }
  EnergyBook& operator+=(const EnergyBook& o) {
    fracture += o.fracture, injected += o.injected, face_friction += o.face_friction, face_crushing += o.face_crushing,
        contact += o.contact, handoff += o.handoff, external += o.external;
    healing += o.healing, plastic += o.plastic, damping += o.damping, transfer += o.transfer, frozen += o.frozen;
    return *this;
  }
};

}  // namespace sunder::shell
