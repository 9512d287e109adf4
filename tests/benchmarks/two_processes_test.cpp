// What the benchmarks of two processes rest on. How fast anything is decides nothing here.
#include "tests/benchmarks/two_processes.h"

#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "coupler/core/error.h"

namespace sunder::bench {
namespace {

TEST(Percentile, IsTheSampleOfNearestRank) {
  std::vector<double> hundred(100);
  std::iota(hundred.rbegin(), hundred.rend(), 1.0);  // 100 ... 1: order does not matter
  EXPECT_EQ(percentile(hundred, 0.5), 50.0);
  EXPECT_EQ(percentile(hundred, 0.99), 99.0);
  EXPECT_EQ(percentile(hundred, 1.0), 100.0);
  EXPECT_EQ(percentile(hundred, 1e-9), 1.0);
  EXPECT_EQ(percentile({3.0, 1.0, 2.0}, 0.5), 2.0);
}

TEST(Percentile, RefusesWhatHasNone) {
  EXPECT_THROW(percentile({}, 0.5), std::logic_error);
  EXPECT_THROW(percentile({1.0}, 0.0), std::logic_error);
  EXPECT_THROW(percentile({1.0}, 1.1), std::logic_error);
}

TEST(ProcessBenchmarks, PromiseTheKeysThatHaveGoals) {
  std::set<std::string> keys;
  for (const ProcessBenchmark& b : process_benchmarks())
    for (const std::string key : b.keys) {
      EXPECT_TRUE(keys.insert(key).second) << key;
      EXPECT_EQ(key.rfind(b.name, 0), 0u) << "--filter with the key's beginning must find it";
    }
  EXPECT_EQ(keys,
            (std::set<std::string>{"window_roundtrip_us_4k_p50", "window_roundtrip_us_4k_p99",
                                   "window_roundtrip_us_1000_fragments_p50", "process_boundary_overhead_percent"}));
}

TEST(RoundTrips, AreThoseOfARealExchange) {
  const RoundTrips few = measure_round_trips(31, 2, 5), many = measure_round_trips(62, 1, 5);
  EXPECT_EQ(few.us.size(), 10u);
  EXPECT_EQ(few.bare_us.size(), 10u);
  EXPECT_EQ(few.asleep_us.size(), 10u);
  for (const double us : few.us) EXPECT_GT(us, 0.0);
  EXPECT_NEAR(static_cast<double>(few.request_bytes), 4096.0, 0.1 * 4096.0);
  EXPECT_NEAR(static_cast<double>(few.reply_bytes), 4096.0, 0.1 * 4096.0);
  // every body is in it, with all its numbers: twice as many take twice the bytes, but for a frame of some 20
  EXPECT_NEAR(static_cast<double>(many.request_bytes), 2.0 * static_cast<double>(few.request_bytes), 30.0);
  EXPECT_NEAR(static_cast<double>(many.reply_bytes), 2.0 * static_cast<double>(few.reply_bytes), 30.0);
}

TEST(ProcessBoundary, ChangesNothingButTheTime) {
  const RunCost one = run_glass(false, "5e-5"), two = run_glass(true, "5e-5");
  EXPECT_EQ(one.state_hash, two.state_hash);
  EXPECT_EQ(one.state_hash.size(), 64u);
  EXPECT_GT(one.wall_s, one.coupling_s);
  EXPECT_GT(two.coupling_s, 0.0);
}

}  // namespace
}  // namespace sunder::bench
