#pragma once
// Exact answers for cantilevers of constant width whose depth is linear.
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

namespace sunder::shell {

/// Deflection of the free end of a cantilever under a force at that end, over force / (E width) [-]:
/// 12 / c^3 [ln(H/h) + 2 h/H - h^2 / (2 H^2) - 3/2], c = (H - h) / L, by virtual work without shear.
inline double wedge_compliance(double root, double tip, double length) {
  const double c = (root - tip) / length, share = tip / root;
  return 12.0 / (c * c * c) * (-std::log(share) + 2.0 * share - 0.5 * share * share - 1.5);
}

/// Determinant of the conditions of a truncated wedge that is clamped at x = R and free at x = r, of constant width and
/// linear depth: (x^3 w'')'' = p^2 x w has the solutions w = Z_1(2 sqrt(p x)) / sqrt(x) with Z = J, Y, I, K (Kirchhoff
/// 1879). Derivatives follow from those of Bessel functions.
inline double wedge_condition(double p, double r, double R) {
  const auto functions = [&](int n, double x) {
    const double z = 2.0 * std::sqrt(p * x);
    return std::array<double, 4>{std::cyl_bessel_j(n, z), std::cyl_neumann(n, z), std::cyl_bessel_i(n, z),
                                 std::cyl_bessel_k(n, z)};
  };
  const auto held = functions(1, R), slope = functions(2, R), moment = functions(3, r), shear = functions(2, r);
  const double sign_slope[] = {-1, -1, 1, -1}, sign_moment[] = {1, 1, 1, 1}, sign_shear[] = {1, 1, 1, -1};
  Eigen::Matrix4d a;
  for (int k = 0; k < 4; ++k)
    a.col(k) << held[k], sign_slope[k] * slope[k], sign_moment[k] * moment[k], sign_shear[k] * shear[k];
  for (int k = 0; k < 4; ++k) a.col(k) /= a.col(k).norm();
  return a.determinant();
}

/// lambda^2 = omega L^2 sqrt(12 rho / (E root^2)) of the first modes, for a tip of so many roots.
inline std::vector<double> wedge_numbers(double tip, int count) {
  const double R = 1.0 / (1.0 - tip), r = R - 1.0;  // length 1
  std::vector<double> out;
  double before = wedge_condition(0.05, r, R);
  for (double p = 0.1; static_cast<int>(out.size()) < count; p += 0.05) {
    const double now = wedge_condition(p, r, R);
    if (before * now < 0.0) {
      double low = p - 0.05, high = p, at_low = before;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high), there = wedge_condition(middle, r, R);
        (there * at_low > 0.0 ? low : high) = middle;
        if (there * at_low > 0.0) at_low = there;
      }
      out.push_back(0.5 * (low + high) / R);
    }
    before = now;
  }
  return out;
}

}  // namespace sunder::shell
