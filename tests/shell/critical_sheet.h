#pragma once
// A sheet whose cracks need a length for their energy.
#include <numbers>

#include "tests/shell/fixtures.h"

namespace sunder::shell {

// 40 x 40 elements of 5 mm; a stretched crack needs a half-length of `spacings` for its energy at a strength of 10 MPa.
inline ShellModel sheet_that_needs(double spacings) {
  ShellMaterial material = glass();
  material.strength = 10e6;
  material.fracture_energy = std::numbers::pi * 1e14 * spacings * 0.005 / material.youngs_modulus;
  return make_shell("p", plate(0.2, 0.2, 40, 40, Vec3::Zero(), Quat::Identity()), 0.004, material, 2, 2, {});
}

}  // namespace sunder::shell
