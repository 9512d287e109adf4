// Constants of fracture that are derived by a calculation.
#include "shell/fracture/constants.h"

#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

using namespace sunder::shell;

namespace {

using Point = std::complex<double>;

struct Element {
  Point from, to;
  Point centre() const { return 0.5 * (from + to); }
  double half() const { return 0.5 * std::abs(to - from); }
  double direction() const { return std::arg(to - from); }
};

// Ends of elements from 0 to `length`, which grow by `ratio` from `least` on up to the middle and shrink again.
std::vector<double> graded(double length, double least, double ratio) {
  std::vector<double> half = {0.0};
  for (double h = least; half.back() < 0.5 * length; h *= ratio) half.push_back(half.back() + h);
  const double scale = 0.5 * length / half.back();
  for (double& x : half) x *= scale;
  std::vector<double> all = half;
  for (std::size_t i = half.size() - 1; i-- > 0;) all.push_back(length - half[i]);
  return all;
}

// Ratio of the stress intensities K_II / K_I at the tip of either of two straight arms of length `arm`, which leave the
// end of a straight crack of length 1 by `angle` [rad] to either side, in tension across that crack. Discontinuities of
// displacement, constant over each element (Crouch and Starfield, Boundary Element Methods in Solid Mechanics, 1983).
double shear_at_arm(double angle, double arm, int elements) {
  constexpr double kPoisson = 0.25;  // without influence where the tractions are given
  std::vector<Element> e;
  const std::vector<double> main = graded(1.0, arm / elements, 1.1);
  for (std::size_t i = 0; i + 1 < main.size(); ++i) e.push_back({-main[i + 1], -main[i]});
  for (const double side : {-1.0, 1.0})
    for (int i = 0; i < elements; ++i)
      e.push_back({std::polar(arm * i / elements, side * angle), std::polar(arm * (i + 1) / elements, side * angle)});
  const auto n = static_cast<Eigen::Index>(e.size());
  Eigen::MatrixXd m(2 * n, 2 * n);
  Eigen::VectorXd load(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double at = e[i].direction();
    load[i] = -std::sin(at) * std::cos(at), load[n + i] = -std::cos(at) * std::cos(at);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Point p = (e[i].centre() - e[j].centre()) * std::polar(1.0, -e[j].direction());
      const double x = p.real(), y = p.imag(), a = e[j].half(), k = 1.0 / (4.0 * M_PI * (1.0 - kPoisson));
      const double left = x - a, right = x + a, l = left * left + y * y, r = right * right + y * y;
      // second and third derivatives of the stress function of one element
      const double xy = k * (y / l - y / r), yy = -k * (left / l - right / r);
      const double xyy = k * ((left * left - y * y) / (l * l) - (right * right - y * y) / (r * r));
      const double yyy = 2.0 * k * y * (left / (l * l) - right / (r * r));
      const double turn = at - e[j].direction(), c = std::cos(turn), s = std::sin(turn);
      const auto put = [&](Eigen::Index column, double sxx, double syy, double sxy) {
        m(i, column) = (syy - sxx) * s * c + sxy * (c * c - s * s);
        m(n + i, column) = sxx * s * s - 2.0 * sxy * s * c + syy * c * c;
      };
      put(j, 2.0 * xy + y * xyy, -y * xyy, yy + y * yyy);  // a unit of sliding
      put(n + j, yy + y * yyy, yy - y * yyy, -y * xyy);    // a unit of opening
    }
  }
  const Eigen::VectorXd jump = m.partialPivLu().solve(load);
  return jump[n - 1] / jump[2 * n - 1];
}

// Angle [rad] of arms of this length without shear at their tips.
double angle_without_shear(double arm) {
  constexpr int kElements = 24;
  double a = 0.35, b = 0.5, at_a = shear_at_arm(a, arm, kElements), at_b = shear_at_arm(b, arm, kElements);
  for (int i = 0; i < 4; ++i) {  // secants: nearly a straight line
    const double next = b - at_b * (b - a) / (at_b - at_a);
    a = b, at_a = at_b, b = next, at_b = shear_at_arm(b, arm, kElements);
  }
  return b;
}

}  // namespace

// Both arms follow the principle of local symmetry from the first on: the limit of short arms. What long arms miss of
// it grows with the square root of their length.
TEST(FractureConstants, ArmsOfADivisionStartWithoutShear) {
  constexpr double kDegree = M_PI / 180.0;
  // With ten times as many elements, found once: the elements are fine enough.
  EXPECT_NEAR(angle_without_shear(0.1) / kDegree, 14.2, 0.3);
  const double short_arm = 1e-3, shorter = 1e-4, at_short = angle_without_shear(short_arm),
               at_shorter = angle_without_shear(shorter);
  const double slope = (at_shorter - at_short) / (std::sqrt(short_arm) - std::sqrt(shorter));
  // a quarter of a degree: the constant is rounded to a whole one, and two lengths leave a tenth
  EXPECT_NEAR(kBranchAngle / kDegree, (at_shorter + slope * std::sqrt(shorter)) / kDegree, 0.25);
}
