#pragma once
// A soft body of particles (the paper's type I): what does not change during a run.
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/core/body.h"

namespace sunder::shell {

/// Compressible neo-Hookean: psi = mu/2 (tr b - 3) - mu ln J + lambda/2 ln^2 J.
struct SoftMaterial {
  double density = 0.0, youngs_modulus = 0.0, poisson_ratio = 0.0;  // [kg/m^3], [Pa], [-]
  double mu() const { return 0.5 * youngs_modulus / (1.0 + poisson_ratio); }
  double lambda() const {
    return youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
  double wave_speed() const;  // of compression, undeformed [m/s]
};

/// A face of the surface as one particle beside it carries it: an edge has several.
struct SoftSurface {
  int particle = 0;
  Vec3 normal = Vec3::Zero();  // outward, at rest
  double depth = 0.0;          // of the particle below it, at rest [m]
};

struct SoftModel {
  std::string name;
  SoftMaterial material;
  std::uint32_t contact_group = 0;
  double spacing = 0.0;        // of particles, at most [m]
  double grid = 0.0;           // spacing of its background grid [m]
  std::vector<Vec3> rest{};    // [m], world
  std::vector<double> mass{};  // [kg]
  std::vector<SoftSurface> surface{};

  int particles() const { return static_cast<int>(rest.size()); }
};

/// Particles a spacing or less apart along the shape's own axes; those that the surface cuts carry what is left of
/// their cell, at its centroid. `pose`: of the shape's axes; `volume` [m^3]: the shape's, which the masses add up to;
/// 0: what the cells add up to. Half spaces have none.
SoftModel make_soft(const std::string& name, const SoftMaterial& material, const Shape& shape, const BodyMotion& pose,
                    double spacing, double grid, double volume = 0.0);

/// Particles that `make_soft` would make at most.
double soft_cells(const Shape& shape, double spacing);

}  // namespace sunder::shell
