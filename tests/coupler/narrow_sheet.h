#pragma once
// A sheet with two columns of narrow elements, which dictate the step.
#include <string>
#include <vector>

#include <fmt/format.h>

namespace narrow_sheet {

constexpr double kLength = 2.0, kWidth = 1.0;  // [m]

/// Knots of a flat quadratic sheet along x: `columns` elements of equal width, two of them narrow ones in the middle
/// when `narrow` is their width over that of the others.
inline std::vector<double> knots_x(int columns, double narrow) {
  const double wide = kLength / (columns + 2.0 * narrow);
  std::vector<double> knots(2, 0.0);
  double at = 0.0;
  for (int i = 0; i <= columns; ++i) {
    knots.push_back(at);
    if (i == columns / 2) knots.push_back(at += narrow * wide), knots.push_back(at += narrow * wide);
    at += wide;
  }
  knots.insert(knots.end(), 2, knots.back());
  return knots;
}

inline std::vector<double> even_knots(double length, int elements) {
  std::vector<double> knots(2, 0.0);
  for (int i = 0; i <= elements; ++i) knots.push_back(length * i / elements);
  knots.insert(knots.end(), 2, length);
  return knots;
}

/// The text of a scene with that sheet of steel, clamped at one end, and with these fields of mass_scaling; empty:
/// none.
inline std::string scene(const std::string& scaling, int columns = 20, int rows = 10, double narrow = 0.1,
                         const std::string& more = "") {
  const std::vector<double> u = knots_x(columns, narrow), v = even_knots(kWidth, rows);
  std::string points;
  for (std::size_t j = 0; j + 3 < v.size(); ++j)
    for (std::size_t i = 0; i + 3 < u.size(); ++i)
      points += fmt::format("    control_points {{ x: {:.17g} y: {:.17g} }}\n", 0.5 * (u[i + 1] + u[i + 2]),
                            0.5 * (v[j + 1] + v[j + 2]));
  return fmt::format(
             "name: \"narrow\"\nend_time_s: 0.2\nwindow_s: 1e-3\ngravity {{}}\n"
             "materials {{ name: \"steel\" density: 7800 youngs_modulus: 2e11 poisson_ratio: 0.3 }}\n"
             "shells {{\n  name: \"sheet\" material: \"steel\" thickness_m: 0.004 layers: 2\n"
             "  nurbs {{\n    knots_u: [{}]\n    knots_v: [{}]\n{}  }}\n"
             "  supports {{ edges: U_MIN kind: CLAMPED }}\n{}}}\n",
             fmt::join(u, ", "), fmt::join(v, ", "), points, more) +
         (scaling.empty() ? "" : "mass_scaling { " + scaling + " }\n");
}

}  // namespace narrow_sheet
