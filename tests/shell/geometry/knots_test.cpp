// Knot vectors and their basis functions.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "shell/geometry/knots.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(CubicBasis, SumsToOneReproducesLinesAndHasTheDerivativesOfItsValues) {
  const KnotVector k({-1, -1, -1, -1, -0.2, 0.1, 0.1, 0.7, 2, 2, 2, 2}, 3, "k");
  ASSERT_EQ(k.control_points(), 8);
  const double e = 1e-4;
  for (int span = 0; span < k.spans(); ++span) {
    if (k.span_length(span) == 0.0) continue;
    for (const double share : {0.0, 0.1, 0.5, 0.93, 1.0}) {
      const double u = k.span_begin(span) + share * k.span_length(span);
      // the polynomials of a span go on beyond it, so that its ends can be tested too
      const Basis b = k.basis(span, u), low = k.basis(span, u - e), high = k.basis(span, u + e);
      double sum = 0.0, first = 0.0, second = 0.0, line = 0.0;
      for (int i = 0; i < 4; ++i) {
        EXPECT_GE(b.value[i], -1e-30);  // at a span's end a knot may be missed by round-off
        sum += b.value[i], first += b.first[i], second += b.second[i], line += b.value[i] * k.greville(span + i);
        // central differences of cubics: exact to e^2 of the third derivative, below 6/0.3^3, and round-off
        EXPECT_NEAR(b.first[i], (high.value[i] - low.value[i]) / (2 * e), 1e-6);
        EXPECT_NEAR(b.second[i], (high.first[i] - low.first[i]) / (2 * e), 1e-9);
      }
      EXPECT_NEAR(sum, 1.0, 1e-15);
      EXPECT_NEAR(first, 0.0, 1e-13);
      EXPECT_NEAR(second, 0.0, 1e-12);
      EXPECT_NEAR(line, u, 1e-15);
    }
  }
  // across the double knot slopes are continuous, across a simple one curvature too
  const auto jump = [&](int left, int right, auto member) {
    const double u = k.span_begin(right);
    double most = 0.0;
    for (int i = 0; i < k.control_points(); ++i) {
      const auto at = [&](int span) {
        return i < span || i > span + 3 ? 0.0 : (k.basis(span, u).*member)[static_cast<std::size_t>(i - span)];
      };
      most = std::max(most, std::abs(at(left) - at(right)));
    }
    return most;
  };
  EXPECT_LT(jump(0, 1, &Basis::second), 1e-12);
  EXPECT_LT(jump(1, 3, &Basis::first), 1e-13);
  EXPECT_GT(jump(1, 3, &Basis::second), 1.0);
}

TEST(CubicBasis, RefusesOtherDegreesAndKnotsThatAreNotOpenOrFold) {
  EXPECT_THROW(KnotVector({0, 0, 0, 0, 0, 1, 1, 1, 1, 1}, 4, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 1, 1}, 1, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 0, 1, 1, 1}, 3, "u"), Error);                       // too few
  EXPECT_THROW(KnotVector({0, 0, 0, 0.5, 1, 1, 1, 1}, 3, "u"), Error);               // not open
  EXPECT_THROW(KnotVector({0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1}, 3, "u"), Error);  // a fold
  EXPECT_THROW(KnotVector({0, 0, 0, 0, 0, 1, 1, 1, 1}, 3, "u"), Error);              // one too many at the end
  EXPECT_NO_THROW(KnotVector({0, 0, 0, 0, 0.5, 0.5, 1, 1, 1, 1}, 3, "u"));
  Patch mixed{KnotVector::uniform(2, 1.0, 3), KnotVector::uniform(2, 1.0, 2), {}, {}};
  mixed.control_points.assign(20, Vec3::Zero()), mixed.weights.assign(20, 1.0);
  EXPECT_THROW(validate(mixed, "patch"), Error);
}

TEST(KnotVector, RefusesWhatIsNoOpenQuadratic) {
  EXPECT_THROW(KnotVector({0, 0, 0, 1, 0.5, 2, 2, 2}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 1, 1, 1}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1}, 2, "u"), Error);
  EXPECT_THROW(KnotVector({0, 0, 0, std::nan(""), 1, 1, 1}, 2, "u"), Error);
}
