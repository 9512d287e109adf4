#pragma once
// Which fields of shells a scene asks for (scene.proto, Output.Field).
#include <cstdint>

namespace sunder::shell {

/// A set of fields.
struct FieldSet {
  /// In the order of Output.Field.
  enum Field {
    kStress = 1,
    kStrain,
    kMembraneForce,
    kBendingMoment,
    kPlasticStrain,
    kThickness,
    kContactPressure,
    kBodyMotion
  };
  std::uint32_t bits = 0;

  bool has(Field f) const { return (bits >> f & 1U) != 0; }
  void add(int field) { bits |= 1U << field; }
  bool empty() const { return bits == 0; }
  /// True where a field of shells is in it.
  bool of_shells() const { return (bits & ~(1U << kBodyMotion)) != 0; }
};

}  // namespace sunder::shell
