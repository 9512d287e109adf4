#pragma once
// Where the energy of a shell went.

namespace sunder::shell {

/// Energies that left the mechanics, each booked where it went [J].
struct EnergyBook {
  double fracture = 0.0;  // released by new cracks and by crack faces that let go; taken by irreversible damage
  double injected = 0.0;  // added by the force discontinuity of new cracks, beyond what they released
  double contact = 0.0;   // inelastic and frictional, shell against bodies
  double handoff = 0.0;   // kinetic and elastic energy that a rigid piece cannot carry
  double external = 0.0;  // work of loads and of moving supports, counted as gained
  double healing = 0.0;   // lost by cycles of damage and healing; made where negative
  double plastic = 0.0;   // dissipated by yielding
  double damping = 0.0;   // Rayleigh
  double transfer = 0.0;  // lost on the way through the background grid; made where negative
  double frozen = 0.0;    // of the part that a support holds when the shell is frozen

  /// Energy that the mechanics have lost to all of these [J].
  double lost() const {
    return fracture - injected + contact + handoff - external + healing + plastic + transfer + damping + frozen;
  }
  EnergyBook& operator+=(const EnergyBook& o) {
    fracture += o.fracture, injected += o.injected, contact += o.contact, handoff += o.handoff, external += o.external;
    healing += o.healing, plastic += o.plastic, damping += o.damping, transfer += o.transfer, frozen += o.frozen;
    return *this;
  }
};

}  // namespace sunder::shell
