#pragma once
// What pieces are handed over as: prisms whose points come in pairs, lower and upper.
#include <cstddef>

#include "coupler/core/body.h"

namespace sunder::test {

/// Sum over the parts [m^3], each upright: its base as a fan of triangles times its height.
inline double volume_of_prisms(const ConvexShape& shape) {
  double volume = 0.0;
  for (const auto& part : shape.parts) {
    double base = 0.0;
    for (std::size_t k = 2; k + 2 < part.size(); k += 2)
      base += 0.5 * (part[k] - part[0]).cross(part[k + 2] - part[0]).norm();
    volume += base * (part[1] - part[0]).norm();
  }
  return volume;
}

}  // namespace sunder::test
