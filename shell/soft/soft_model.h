#pragma once
// The constant model of a soft body of particles (the paper's type I).
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::shell {

/// Compressible neo-Hookean solid: psi = mu/2 (tr b - 3) - mu ln J + lambda/2 ln^2 J [J/m^3].
struct SoftMaterial {
  double density = 0.0, youngs_modulus = 0.0, poisson_ratio = 0.0;  // [kg/m^3], [Pa], [-]
  double mu() const { return 0.5 * youngs_modulus / (1.0 + poisson_ratio); }
  double lambda() const {
    return youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
  double wave_speed() const;  // speed of compression waves in the undeformed solid [m/s]
};

/// A face of the surface, carried by one particle beside it. A particle at an edge carries several.
struct SoftSurface {
  int particle = 0;
  Vec3 normal = Vec3::Zero();  // outward, undeformed
  double depth = 0.0;          // distance of the particle below the face, undeformed [m]
};

/// Particles, masses and surface of a soft body.
struct SoftModel {
  std::string name;
  SoftMaterial material;
  std::uint32_t contact_group = 0;
  double spacing = 0.0;        // of particles, the widest direction [m]
  double grid = 0.0;           // spacing of its background grid [m]
  std::vector<Vec3> rest{};    // [m], world
  std::vector<double> mass{};  // [kg]
  std::vector<SoftSurface> surface{};

  int particles() const { return static_cast<int>(rest.size()); }
};

/// Fills a shape with particles at most `spacing` [m] apart along the shape's own axes. A particle of a cell that the
/// surface cuts has the mass of the part inside, and stands at its centroid. `pose` places the shape's axes. Masses add
/// up to density times `volume` [m^3]; with 0, to density times the sum of the cells. A half space gives no usable
/// particles.
SoftModel make_soft(const std::string& name, const SoftMaterial& material, const Shape& shape, const BodyMotion& pose,
                    double spacing, double grid, double volume = 0.0);

/// Upper bound of the number of particles that `make_soft` makes.
double soft_cells(const Shape& shape, double spacing);

}  // namespace sunder::shell
