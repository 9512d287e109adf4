// How many threads a force evaluation takes.
#include "shell/run/pace.h"

#include <random>

#include <gtest/gtest.h>

namespace sunder::shell {
namespace {

// The time of an evaluation by its number of threads.
struct Machine {
  double wall[5];   // [s] by threads
  double share[5];  // of its processors that the program gets
};
constexpr Machine kAlone{{0, 1e-3, 5.2e-4, 0, 3e-4}, {0, 1.0, 0.99, 0, 0.99}};
constexpr Machine kBesideAnother{{0, 1e-3, 2.1e-3, 0, 2.5e-3}, {0, 0.99, 0.7, 0, 0.7}};
constexpr Machine kHalfTaken{{0, 1e-3, 5.2e-4, 0, 9e-4}, {0, 1.0, 0.99, 0, 0.6}};

// Speed beside that of one thread.
double speed_on(const Machine& m, Pace& pace, int evaluations) {
  double wall = 0.0;
  for (int i = 0; i < evaluations; ++i) {
    const int n = pace.threads();
    wall += m.wall[n];
    pace.took(m.wall[n], n * m.share[n] * m.wall[n]);
  }
  return evaluations * m.wall[1] / wall;
}

TEST(Pace, TakesAllThreadsAndTriesNothingWhileAlone) {
  Pace pace(2);
  for (int i = 0; i < 5000; ++i) {
    ASSERT_EQ(pace.threads(), 2);
    pace.took(5.2e-4, 2 * 0.99 * 5.2e-4);
  }
}

TEST(Pace, IsNotSlowerThanOneThreadBesideAnotherProgram) {
  Pace pace(2);
  speed_on(kBesideAnother, pace, 1000);                    // the first second is for trials
  EXPECT_GT(speed_on(kBesideAnother, pace, 20000), 0.98);  // a trial in each 256 blocks or less costs 0.5 %
}

// Two threads are fast in a block of 30 ms where the other program happens to be elsewhere, and very slow in the
// others.
TEST(Pace, IsNotSlowerThanOneThreadWhereSomeBlocksAreLucky) {
  Pace pace(2);
  std::mt19937_64 random(1);
  double wall = 0.0, block = 0.0;
  bool lucky = true;
  int n = 0;
  for (; wall < 20.0; ++n) {
    if (block > 0.03) block = 0.0, lucky = random() % 2 == 0;
    const double took = pace.threads() == 1 ? 1e-3 : lucky ? 5.2e-4 : 2e-2;
    pace.took(took, 0.7 * pace.threads() * took);
    wall += took, block += took;
  }
  EXPECT_GT(1e-3 * n / wall, 0.9);
}

TEST(Pace, ReturnsToAllThreadsOnceAlone) {
  Pace pace(4);
  speed_on(kBesideAnother, pace, 20000);
  EXPECT_EQ(pace.threads(), 1);
  speed_on(kAlone, pace, 20000);  // patience ends after 256 blocks of 30 ms
  EXPECT_EQ(pace.threads(), 4);
}

TEST(Pace, SettlesBetweenOneAndAll) {
  Pace pace(4);
  speed_on(kHalfTaken, pace, 2000);
  EXPECT_GT(speed_on(kHalfTaken, pace, 20000), 1.85);  // 1.92 with two threads
}

TEST(Pace, OfOneThreadHasNoChoice) {
  Pace pace(1);
  EXPECT_FALSE(pace.chooses());
  EXPECT_EQ(pace.threads(), 1);
}

}  // namespace
}  // namespace sunder::shell
