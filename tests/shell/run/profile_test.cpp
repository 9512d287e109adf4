// Stages beside a model of their work.
#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shell/mechanics/operations.h"
#include "shell/run/profile.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Profile, CountsThePointsOfRowsAndThoseBesideACrack) {
  Rig rig(setup_of({{brittle_sheet(12)}}));
  const RowTables& t = rig.model().tables;
  const StageWork whole = force_work(rig.now());
  EXPECT_DOUBLE_EQ(whole.operations, t.gauss_points() * operations_of_row_point(t));
  EXPECT_GT(whole.bytes, 8.0 * static_cast<int>(kMetricFields) * t.gauss_points());
  insert_polyline(rig.model(), rig.state(), {{0.1, 0.013}, {0.1, 0.187}}, 0.0);
  const auto& gathered = rig.state().cracked.gathered;
  ASSERT_FALSE(gathered.empty());
  double wanted = (t.gauss_points() - static_cast<double>(gathered.size())) * operations_of_row_point(t);
  for (const GatheredPoint& g : gathered)
    if (g.kind != PointKind::kDead) wanted += operations_of_gathered_point(t, g.functions.size());
  const StageWork cut = force_work(rig.now());
  EXPECT_DOUBLE_EQ(cut.operations, wanted);
  EXPECT_GT(cut.bytes, whole.bytes);
}

TEST(Profile, OperationsGrowWithLayersAndDegree) {
  const auto tables = [](int layers, int degree) {
    return make_shell("p", plate(0.2, 0.2, 6, 6, Vec3::Zero(), Quat::Identity(), degree), 0.004, glass(), layers,
                      degree, {})
        .tables;
  };
  const RowTables four = tables(4, 2), three = tables(3, 2), two = tables(2, 2), cubic = tables(2, 3);
  const auto of = operations_of_row_point;
  EXPECT_GT(of(three), of(two));
  EXPECT_DOUBLE_EQ(of(four) - of(three), of(three) - of(two));  // a layer more is the same work more
  // along u 15 sums of a product more and 30 operations back; along v 9 sums and 18 operations of each point of a row
  EXPECT_DOUBLE_EQ(of(cubic) - of(two), 60.0 + (9.0 * 7.0 + 72.0) / cubic.gauss - (9.0 * 5.0 + 54.0) / two.gauss);
}

TEST(Profile, IsWrittenWithTheLimitsOfTheMachine) {
  const TemporaryFolder folder;
  Rig rig(setup_of({{brittle_sheet(12)}}));
  rig.run(3, 1e-8);
  Profile counted(rig.simulation());  // what came before does not count
  for (int window = 0; window < 4; ++window) rig.run(10, 1e-8), counted.count(10);
  counted.write(folder.path);
  nlohmann::json found;
  std::ifstream(folder.path + "/profile.json") >> found;
  EXPECT_EQ(found["substeps"], 40.0);
  EXPECT_GT(found["fma_peak_gflops"], 0.1);
  bool force = false;
  for (const auto& stage : found["stages"]) {
    EXPECT_GT(stage["seconds"], 0.0);
    if (stage["stage"] != "internal_force") continue;
    force = true;
    EXPECT_EQ(stage["passes"], 44.0);
    EXPECT_DOUBLE_EQ(stage["operations"], force_work(rig.now()).operations);
    const double memory = stage["memory_s"], operations = stage["operations_s"], seconds = stage["seconds"];
    EXPECT_NEAR(memory, 44.0 * stage["bytes"].get<double>() / (1e9 * stage["memory_gb_per_s"].get<double>()),
                1e-9 * memory);
    EXPECT_EQ(stage["limit"], memory > operations ? "memory" : "operations");
    EXPECT_DOUBLE_EQ(stage["times_limit"], seconds / std::max(memory, operations));
    EXPECT_GT(stage["times_limit"], 0.5);  // no stage is faster than the machine, but the machine may be slow meanwhile
  }
  EXPECT_TRUE(force);
}

// Of a megabyte the second cache holds all, and the start of a parallel region takes little of the time. Other programs
// may take the processor in any one measurement: the fastest of up to thirty decides.
TEST(Profile, MemoryIsSlowerThanACache) {
  const double memory = measure_bandwidth(1, 2e8);
  double cache = 0.0;
  for (int k = 0; k < 30 && cache <= memory; ++k) cache = std::max(cache, measure_bandwidth(1, 1e6));
  EXPECT_GT(cache, memory);
}
