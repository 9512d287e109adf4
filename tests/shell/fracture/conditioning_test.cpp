// Which supports are sound.
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "shell/fracture/conditioning.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Conditioning, AnswersAsEigenvaluesDo) {
  constexpr int kAll = 8;
  const SupportChoice choices[kAll] = {{2.0, 200.0}, {2.25, 200.0}, {2.5, 200.0},  {3.0, 200.0},
                                       {3.5, 200.0}, {4.5, 200.0},  {5.5, 2500.0}, {4.5, 2500.0}};
  const auto window = [](double x) {
    const double r = std::abs(x);
    return r <= 0.5 ? 2.0 / 3.0 - 4.0 * r * r + 4.0 * r * r * r : r <= 1.0 ? 4.0 / 3.0 * std::pow(1.0 - r, 3) : 0.0;
  };
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int count[3] = {}, loose = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec2 at(uniform(random), uniform(random)), n = Vec2(uniform(random), uniform(random)).normalized();
    const double crack = 0.5 * uniform(random), other = 1.0 + 4.0 * std::abs(uniform(random));
    std::vector<Vec2> offsets;  // of a lattice, between two cracks
    View view;
    view.columns = view.rows = 13, view.seen.fill(0);
    for (int y = 0; y < 13; ++y)
      for (int x = 0; x < 13; ++x) {
        const Vec2 q = Vec2(x - 6, y - 6) + 0.5 * at;
        view.x[x] = q.x(), view.y[y] = q.y();
        if (q.cwiseAbs().maxCoeff() >= 5.5 || q.dot(n) <= crack || q.dot(n) >= crack + other) continue;
        offsets.push_back(q), view.seen[y] = static_cast<std::uint16_t>(view.seen[y] | 1u << x);
      }
    Conditioning<6> conditioning;
    bool found = false;
    for (int k = 0; k < kAll; ++k) {
      if (k % kChoices == 0) conditioned(view, choices + k, 9, conditioning), found = false;
      const Conditioned answer = conditioning.answer[k % kChoices];
      const auto& [size, limit] = choices[k];
      Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Zero();
      int within = 0;
      for (const Vec2& q : offsets) {
        const double x = q.x() / size, y = q.y() / size;
        Eigen::Matrix<double, 6, 1> p;
        p << 1.0, x, y, x * x, x * y, y * y;
        a += window(x) * window(y) * p * p.transpose();
        within += q.cwiseAbs().maxCoeff() < size;
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(a, Eigen::EigenvaluesOnly);
      const double low = eigen.eigenvalues()[0], high = eigen.eigenvalues()[5];
      ++count[static_cast<int>(answer)];
      switch (answer) {
        case Conditioned::kYes:
          EXPECT_TRUE(within >= 9 && high <= limit * low);
          found = true;
          break;
        case Conditioned::kNo:
          EXPECT_TRUE(within < 9 || high > limit * low);
          break;
        case Conditioned::kUnsure:
          if (found) --count[2], ++loose;
          EXPECT_GT(high / low / limit, found ? 1.0 / 6.0 : 0.4);
          EXPECT_LT(high / low / limit, found ? 6.0 : 1.6);  // 6^(1/4) at the worst
      }
    }
  }
  for (const int answer : {0, 1}) EXPECT_GT(count[answer], 200);
  EXPECT_LT(count[2], 100);  // of 4000, the others decided
  EXPECT_GT(loose, 0);
}
