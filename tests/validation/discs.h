#pragma once
// Exact results of Kirchhoff plates that are discs or rings with free edges.
#include <vector>

namespace sunder::validation {

/// A disc of radius `outer`, with a hole of radius `inner` where that is above 0.
struct Disc {
  double outer = 0.0, inner = 0.0;  // [m]
  double poisson = 0.3;
};

/// The `count` lowest natural frequencies, as k^2 with omega = k^2 sqrt(D / (rho tau)) [1/m^2]. A mode with nodal
/// diameters counts twice.
std::vector<double> free_disc_modes(const Disc& disc, int count);

/// Deflection [m] at radius `r` below the outer edge, which is simply supported, under a pressure of 1 Pa and with a
/// bending stiffness of 1 N m.
double disc_deflection(const Disc& disc, double r);

}  // namespace sunder::validation
