#pragma once
// Internal forces at Gauss points with shape functions of their own: those that a crack has touched.
#include <array>
#include <vector>

#include "shell/mechanics/row_force.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {

/// One control point's part in a gathered point: value and derivatives of its shape function.
struct GatheredFunction {
  int slot;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class PointKind { kQuadratic, kLinear, kDead };  // linear: membrane only; dead: carries nothing

struct GatheredPoint {
  int block = 0, lane = 0;
  PointKind kind = PointKind::kDead;
  double area = 0.0;                 // reference area [m^2]
  ReferenceMetric<double> metric{};  // with these shape functions, so that the rest state has no strain
  std::vector<GatheredFunction> functions;
};

/// Adds the points' forces to `force` [3][plane]; returns their elastic energy [J] if `energy`.
/// Deterministic: a fixed number of chunks, summed in order. Stress as in row_forces.
double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const std::vector<double>& x,
                        bool energy, SurfaceStress stress, int threads, std::vector<double>& scratch,
                        std::vector<double>& force);

/// Elastic energy of one point [J].
double point_energy(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x);

Derivatives<double> gather(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x);

}  // namespace sunder::shell
