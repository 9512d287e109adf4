// the counting type must be known before the templates that it runs
#include "shell/mechanics/counting.h"
// then the templates
#include "shell/mechanics/operations.h"

#include "shell/mechanics/layers_elastic.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {
namespace {

// By the quotient rule: the surface point of 15 + 3 operations, nine sums of two vectors, five vectors times a number;
// back the same sums and products, and the forces on the value at three places along u.
constexpr double kQuotient = 18 + 9 * 6 + 5 * 3, kQuotientBack = 9 * 6 + 6 * 3;

// Forms, layers and forces of a point. Which branch is taken depends on the strain alone, so any surface near rest
// will do.
double of_section(const RowTables& t) {
  const auto vector = [](double x, double y, double z) { return Vector<Counting>{x, y, z}; };
  const ReferenceMetric<Counting> ref{{1.0, 1.0, 0.0}, {0.0, 0.0, 0.0}};
  const Derivatives<Counting> d{vector(1.00001, 0, 0), vector(0, 1, 0), vector(0, 0, 0.01), vector(0, 0, 0.01),
                                vector(0, 0, 0)};
  Counting::operations = 0;
  const Forms<Counting> f = surface_forms(d);
  const Resultants<Counting> r = integrate_layers<Counting, false>(f, ref, t.layers, t.elasticity);
  section_forces(d, f, r, Counting(1.0));
  return static_cast<double>(Counting::operations);
}

}  // namespace

double operations_of_row_point(const RowTables& t) {
  const int n = t.support();
  const double sum = 2.0 * n - 1.0;  // of n products
  // Along u fifteen sums; back, on n control points, 5 derivatives of 3 components are added. Along v nine sums of the
  // row's net; back nine numbers are added to each of n control rows. The points of a row share what is along v.
  const double along_u = 15.0 * sum + 3.0 * 5.0 * 2.0 * n, along_v = 9.0 * sum + 9.0 * 2.0 * n;
  const double rational = t.rational ? kQuotient + kQuotientBack + 6.0 * n : 0.0;
  return of_section(t) + along_u + along_v / t.gauss + rational;
}

double operations_of_gathered_point(const RowTables& t, std::size_t functions) {
  // 5 derivatives of 3 components; back 5 for the second derivatives along the normal, and 5 a component
  return of_section(t) + static_cast<double>(functions) * (5.0 * 3.0 * 2.0 + 5.0 + 3.0 * 6.0);
}

}  // namespace sunder::shell
