#pragma once
// A patch laid out for the row kernel: constant tables, unit stride along u.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/geometry/quadrature.h"
#include "shell/mechanics/plane_stress.h"

namespace sunder::shell {

/// Through-thickness rule: zeta [m] from -thickness/2 to thickness/2, weights sum to the thickness.
struct Layers {
  std::vector<double> zeta, weight;
  // Factor of each layer's reference metric, which makes stress at rest; empty: none.
  std::vector<double> growth;
  // thickness^3 / 12 where bending is linear and elastic [m^3]: one layer then bears the membrane's part; 0: layers
  // bear bending.
  double bending = 0.0;
};
Layers gauss_layers(int count, double thickness);
/// Two plies on either side of a core of `inner` [m], `count` layers in each.
Layers plies(int count, double thickness, double inner);
/// One layer in the middle, bending by Hooke's law.
Layers linear_bending(double thickness);
/// Stress at rest as in tempered glass: a parabola of zeta, `surface_compression` [Pa] at both faces and half as much
/// tension in the middle, the same in all directions of the plane and, where the shell is flat, without resultant.
/// `layers` must be three at least: two of Gauss lie where the parabola is zero.
void prestress(Layers& layers, double thickness, double surface_compression, const Elasticity& elasticity);

/// Fields of the reference state of a Gauss point, in this order.
enum MetricField { kA11, kA22, kA12, kB11, kB22, kB12, kArea, kMetricFields };
/// The rational denominator and its derivatives, where the patch is rational.
enum RationalField { kInvW, kWu, kWv, kWuu, kWvv, kWuv, kRationalFields };

/// Where everything sits:
///   control point (i, j)       slot j * stride + i of a plane of x, y or z
///   Gauss point (span e along u, point a; span f along v, point b)
///                              row r = f * gauss + b, block q = r * gauss + a, lane e
/// Rows are padded to whole packs, with an odd number of cache lines so that planes do not alias.
struct RowTables {
  int columns = 0, rows = 0;  // control points
  int spans_u = 0, spans_v = 0;
  int degree = 2;
  int gauss = 0;              // points per span and direction
  int stride = 0, plane = 0;  // of control point arrays
  int lanes = 0;              // of Gauss point arrays
  bool rational = false;
  Layers layers;
  Elasticity elasticity;
  std::vector<double> basis_u;      // [a][derivative][k][lane]
  std::vector<double> basis_v;      // [row][derivative][k]
  std::vector<double> metric;       // [block][MetricField][lane]; area 0: the point is not summed here
  std::vector<double> denominator;  // [block][RationalField][lane]
  std::vector<double> weight;       // [slot]

  int slot(int control_point) const { return (control_point / columns) * stride + control_point % columns; }
  int control_point(int slot) const { return slot / stride * columns + slot % stride; }
  int support() const { return degree + 1; }  // functions of a span, per direction
  int gauss_rows() const { return spans_v * gauss; }
  int blocks() const { return gauss_rows() * gauss; }
  int gauss_points() const { return spans_u * spans_v * gauss * gauss; }
  /// Index of Gauss point arrays with `fields` values a point.
  std::size_t at(int block, int fields, int field, int lane) const {
    return (static_cast<std::size_t>(block) * fields + field) * lanes + lane;
  }
};

/// Builds the tables. Throws Error with the parameter where the surface is degenerate at a Gauss point.
RowTables make_row_tables(const Patch& patch, int gauss, const Layers& layers, const Elasticity& elasticity,
                          const std::string& field);

/// Parameter point and quadrature weight (parameter area) of a Gauss point.
struct GaussPoint {
  Vec2 parameter;
  double weight;
};
GaussPoint gauss_point(const Patch& patch, const RowTables& t, int block, int lane);

/// Its parameter along one direction: point k of a span.
inline double gauss_parameter(const KnotVector& knots, const GaussRule& rule, int span, int k) {
  return knots.span_begin(span) + 0.5 * (1.0 + rule.point[k]) * knots.span_length(span);
}

}  // namespace sunder::shell
