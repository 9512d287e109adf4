#include "tests/validation/discs.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Dense>

namespace sunder::validation {
namespace {

constexpr int kMostDiameters = 8;
constexpr double kRootStep = 0.01, kMostK = 12.0;  // of k times the outer radius

// A radial function, with its first derivative.
struct Radial {
  double f, slope;
};

// J, I, Y, K of order n at k r; `k` multiplies slopes. Slopes follow from f_n' = f_{n-1} - n/x f_n (K: -K_{n-1}).
Radial radial(int kind, int n, double k, double r) {
  const double x = k * r;
  const auto value = [&](int order) {
    switch (kind) {
      case 0:
        return std::cyl_bessel_j(order, x);
      case 1:
        return std::cyl_bessel_i(order, x);
      case 2:
        return std::cyl_neumann(order, x);
      default:
        return std::cyl_bessel_k(order, x);
    }
  };
  const double here = value(n);
  const double sign = kind == 0 || kind == 2 ? -1.0 : kind == 1 ? 1.0 : -1.0;
  const double slope = n == 0 ? sign * value(1) : (kind == 3 ? -1.0 : 1.0) * value(n - 1) - n / x * here;
  return {here, k * slope};
}

// Moment and effective shear of f(r) cos(n theta) at radius r, over the bending stiffness. J and Y have the Laplacian
// -k^2 f, I and K have k^2 f.
std::pair<double, double> edge_forces(int kind, int n, double k, double r, double poisson) {
  const auto [f, slope] = radial(kind, n, k, r);
  const double laplace = kind == 0 || kind == 2 ? -k * k : k * k;
  const double second = laplace * f - slope / r + n * n * f / (r * r);
  return {second + poisson * (slope / r - n * n * f / (r * r)),
          laplace * slope - (1.0 - poisson) * n * n / (r * r) * (slope - f / r)};
}

// The determinant whose zeros are the natural frequencies with n nodal diameters.
double determinant_of(const Disc& d, int n, double k) {
  const int kinds = d.inner > 0.0 ? 4 : 2;
  Eigen::MatrixXd a(kinds, kinds);
  for (int kind = 0; kind < kinds; ++kind) {
    std::tie(a(0, kind), a(1, kind)) = edge_forces(kind, n, k, d.outer, d.poisson);
    if (kinds == 4) std::tie(a(2, kind), a(3, kind)) = edge_forces(kind, n, k, d.inner, d.poisson);
    a.col(kind).normalize();
  }
  return a.determinant();
}

}  // namespace

std::vector<double> free_disc_modes(const Disc& d, int count) {
  std::vector<double> out;
  for (int n = 0; n <= kMostDiameters; ++n) {
    double before = determinant_of(d, n, 0.5 / d.outer);
    for (double x = 0.5 + kRootStep; x < kMostK; x += kRootStep) {
      const double now = determinant_of(d, n, x / d.outer);
      if (before * now < 0.0) {
        double low = (x - kRootStep) / d.outer, high = x / d.outer;
        for (int k = 0; k < 60; ++k) {
          const double middle = 0.5 * (low + high);
          (determinant_of(d, n, middle) * now < 0.0 ? low : high) = middle;
        }
        out.insert(out.end(), n == 0 ? 1 : 2, low * low);
      }
      before = now;
    }
  }
  std::sort(out.begin(), out.end());
  out.resize(count);
  return out;
}

double disc_deflection(const Disc& d, double r) {
  // w = r^4/64 + A + B r^2 + C ln r + D r^2 ln r, upwards with the pressure; the shear at the inner edge is 0.
  const auto row = [&](double at) {  // moments of the terms with B, C, D and the particular one
    const double nu = d.poisson, ln = std::log(at);
    return Eigen::Vector4d(2.0 * (1.0 + nu), (nu - 1.0) / (at * at), 2.0 * ln + 3.0 + nu * (2.0 * ln + 1.0),
                           (12.0 + 4.0 * nu) / 64.0 * at * at);
  };
  // shear: d/dr of the Laplacian; r^2 ln r has 4 / r, r^4/64 has r / 2
  const double c4 = d.inner > 0.0 ? -0.5 * d.inner * d.inner / 4.0 : 0.0;
  Eigen::Vector2d bc = Eigen::Vector2d::Zero();
  const Eigen::Vector4d outer = row(d.outer);
  if (d.inner > 0.0) {
    const Eigen::Vector4d inner = row(d.inner);
    Eigen::Matrix2d a;
    a << outer[0], outer[1], inner[0], inner[1];
    bc = a.inverse() * -Eigen::Vector2d(outer[2] * c4 + outer[3], inner[2] * c4 + inner[3]);
  } else {
    bc[0] = -outer[3] / outer[0];
  }
  const auto at = [&](double x) {
    const double ln = x > 0.0 ? std::log(x) : 0.0;
    return std::pow(x, 4) / 64.0 + bc[0] * x * x + bc[1] * ln + c4 * x * x * ln;
  };
  return at(r) - at(d.outer);
}

}  // namespace sunder::validation
