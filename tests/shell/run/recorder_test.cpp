// The files that a run leaves, beside run.json.
#include <filesystem>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    out.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) out.back().push_back(cell);
  }
  return out;
}

}  // namespace

TEST(Recorder, HasARowOfTheSeriesForEachWindow) {
  FreeRun run;
  run.execute();
  const auto rows = rows_of(run.content("series.csv"));
  ASSERT_EQ(rows.size(), 11u);
  EXPECT_EQ(rows[0][0], "time [s]");
  for (std::size_t k = 1; k < rows.size(); ++k) {
    ASSERT_EQ(rows[k].size(), rows[0].size());
    EXPECT_NEAR(std::stod(rows[k][0]), 1e-4 * static_cast<double>(k), 1e-12);
  }
  const auto energy = run.summary()["energy"];  // of the same moment; the table has nine digits
  EXPECT_NEAR(std::stod(rows.back()[1]), energy["kinetic"].get<double>(), 1e-8 * energy["kinetic"].get<double>());
  EXPECT_NEAR(std::stod(rows.back()[2]), energy["elastic"].get<double>(), 1e-8 * energy["elastic"].get<double>());
}

TEST(Recorder, WritesAFrameAtTheStartAtEachIntervalAndAtTheEnd) {
  for (const auto& [interval, frames] : {std::pair{"5e-4", 3}, std::pair{"4e-4", 4}, std::pair{"1", 2}}) {
    FreeRun run;
    run.text.replace(run.text.find("frame_interval_s: 5e-4"), 22, std::string("frame_interval_s: ") + interval);
    run.execute();
    int found = 0;
    for (const auto& file : std::filesystem::directory_iterator(run.folder->path + "/frames"))
      found += file.path().filename().string().rfind("shell", 0) == 0;
    EXPECT_EQ(found, frames) << interval;
  }
}

TEST(Recorder, HasARowOfProbesForEachWindowAndNoShards) {
  FreeRun run;
  run.execute();
  const auto rows = rows_of(run.content("probes.csv"));
  EXPECT_EQ(rows.size(), 12u);  // a head, the start and ten windows
  EXPECT_EQ(rows_of(run.content("shards.csv")).size(), 1u);
}

TEST(Recorder, WritesATraceWhereThatIsAsked) {
  FreeRun run;
  run.options.trace = run.folder->path + "/trace.json";
  run.execute();
  const std::string text = run.content("trace.json");
  EXPECT_TRUE(nlohmann::json::accept(text));
  EXPECT_NE(text.find("\"window\""), std::string::npos);
  FreeRun without;
  without.execute();
  EXPECT_EQ(without.content("trace.json"), "");
}
