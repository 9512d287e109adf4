#pragma once
// Constant tables of a patch for the row kernel, with unit stride along u.
#include <functional>
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/geometry/quadrature.h"
#include "shell/geometry/trim_loops.h"
#include "shell/mechanics/laws.h"

namespace sunder::shell {

/// Quadrature rule through the thickness: zeta [m] from -thickness/2 to thickness/2. The weights sum to the thickness.
struct Layers {
  std::vector<double> zeta, weight;
  // Factor on the reference metric of each layer, which makes stress at rest; empty: no stress at rest.
  std::vector<double> growth;
  // thickness^3 / 12 for linear elastic bending [m^3], where one layer has the membrane part; 0: layers have the
  // bending.
  double bending = 0.0;
};
/// [m]
inline double thickness_of(const Layers& layers) {
  double sum = 0.0;
  for (const double w : layers.weight) sum += w;
  return sum;
}
/// Height of the outer face above the middle surface [m].
double half_height(const Layers& layers);
/// The outer faces of a section. Elastic stress is linear through the plies, also across a core: by resultants n [N/m]
/// and m [N] of the plies the faces have n / thickness +- 6 m / squared.
struct SectionFaces {
  double half = 0.0;       // height above the middle surface [m]
  double thickness = 0.0;  // without a core [m]
  double squared = 0.0;    // thickness^2; in a laminate 6 times the section modulus per width [m^2]
};
SectionFaces section_faces(const Layers& layers);
Layers gauss_layers(int count, double thickness);
/// Two plies beside a core of thickness `inner` [m], with `count` layers in each ply.
Layers plies(int count, double thickness, double inner);
/// One layer in the middle, and bending by Hooke's law.
Layers linear_bending(double thickness);
/// Adds stress at rest as in tempered glass: a parabola in zeta with `surface_compression` [Pa] at both faces and half
/// as much tension in the middle. It is the same in all directions of the plane, and on a flat shell it has no
/// resultant. `layers` needs three points at least, since two Gauss points lie at the zeros of the parabola. Throws
/// Error where no strain makes that stress.
void prestress(Layers& layers, double thickness, double surface_compression, const Elasticity& elasticity);

/// Thickness at a place of a patch, over that of its layers [-]; empty: 1 everywhere.
using ThicknessFactor = std::function<double(const Patch&, const Vec2&)>;

/// Fields of the reference state of a Gauss point, in this order. Where the thickness varies by a factor, the area and
/// the curvature are multiplied by it.
enum MetricField { kA11, kA22, kA12, kB11, kB22, kB12, kArea, kMetricFields };
/// The denominator of a rational patch: its inverse, and its derivatives.
enum RationalField { kInvW, kWu, kWv, kWuu, kWvv, kWuv, kRationalFields };

/// Parameter point and quadrature weight (parameter area) of a Gauss point; weight 0: the point does not exist.
struct GaussPoint {
  Vec2 parameter;
  double weight;
};

/// Layout of the arrays:
///   control point (i, j)       slot j * stride + i; components x, y, z stand `component_stride` numbers apart
///   Gauss point (span e along u, point a; span f along v, point b)
///                              row r = f * gauss + b, block q = r * gauss + a, lane e
/// Rows are padded to whole packs, with an odd number of cache lines so that components do not alias.
struct RowTables {
  int columns = 0, rows = 0;  // control points
  int spans_u = 0, spans_v = 0;
  int degree = 2;
  int gauss = 0;                         // points per span and direction
  int stride = 0, component_stride = 0;  // row stride and component stride of control point arrays
  int lanes = 0;                         // row stride of Gauss point arrays
  bool rational = false;                 // or varying: the denominator is then 1
  // [block][lane]: factor of the thickness; empty: 1. Layers stand at zeta times the factor, so their strain is that of
  // layers at zeta with the curvature, and so the second derivatives, times the factor.
  std::vector<double> thickness;
  Layers layers;
  Elasticity elasticity;
  std::vector<double> basis_u;      // [a][derivative][k][lane]
  std::vector<double> basis_v;      // [row][derivative][k]
  std::vector<double> metric;       // [block][MetricField][lane]; area 0: the row kernel leaves the point out
  std::vector<double> denominator;  // [block][RationalField][lane]
  std::vector<double> weight;       // [slot]
  // [block][lane]: Gauss points of a trimmed patch; in elements that a loop cuts they stand elsewhere than the basis of
  // the rows. Empty: the patch is whole.
  std::vector<GaussPoint> trimmed;

  bool varies() const { return !thickness.empty(); }
  double thickness_factor(int block, int lane) const {
    return thickness.empty() ? 1.0 : thickness[static_cast<std::size_t>(block) * lanes + lane];
  }
  int slot(int control_point) const { return (control_point / columns) * stride + control_point % columns; }
  int control_point(int slot) const { return slot / stride * columns + slot % stride; }
  int support() const { return degree + 1; }  // functions per direction
  int gauss_rows() const { return spans_v * gauss; }
  int blocks() const { return gauss_rows() * gauss; }
  int gauss_points() const { return spans_u * spans_v * gauss * gauss; }
  /// Index in Gauss point arrays with `fields` values per point.
  std::size_t at(int block, int fields, int field, int lane) const {
    return (static_cast<std::size_t>(block) * fields + field) * lanes + lane;
  }
};

/// Builds the tables, of the part of the patch that `trim` leaves. Throws Error with the parameters of a Gauss point
/// where the surface is degenerate or `factor` is not positive.
RowTables make_row_tables(const Patch& patch, int gauss, const Layers& layers, const Elasticity& elasticity,
                          const std::string& field, const TrimLoops& trim = {}, const ThicknessFactor& factor = {});

GaussPoint gauss_point(const Patch& patch, const RowTables& t, int block, int lane);
/// Whether trims leave all of an element: its Gauss points are those of the rule.
bool is_whole_element(const Patch& patch, const RowTables& t, int span_u, int span_v);

/// Parameter of Gauss point k of a span, along one direction.
inline double gauss_parameter(const KnotVector& knots, const GaussRule& rule, int span, int k) {
  return knots.span_begin(span) + 0.5 * (1.0 + rule.point[k]) * knots.span_length(span);
}

}  // namespace sunder::shell
