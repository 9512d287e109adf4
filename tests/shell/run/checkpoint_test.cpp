// A run that is resumed goes on as one that was never interrupted.
#include <filesystem>

#include <gtest/gtest.h>

#include "shell/io/checkpoint_file.h"
#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// A run until 0.6 ms, whose checkpoint is of a window before its end.
FreeRun stopped() {
  FreeRun run;
  run.options.until = 6e-4;
  run.execute();
  return run;
}

Error refused(FreeRun& run) {
  try {
    run.execute();
  } catch (const Error& e) {
    return e;
  }
  return {Exit::kDone, "accepted", ""};
}

}  // namespace

TEST(Checkpoint, AResumedRunIsTheSameToTheBit) {
  FreeRun whole;
  whole.execute();
  const FreeRun first = stopped();
  FreeRun second;
  second.folder = first.folder, second.options.resume = true;
  EXPECT_EQ(second.execute(), Exit::kDone);
  EXPECT_EQ(second.asked.restored, "caches of the engine");
  EXPECT_LT(second.asked.tasks.size(), 10u);  // not from the start
  EXPECT_GT(second.asked.tasks.size(), 0u);
  EXPECT_EQ(second.asked.tasks.back().tick, whole.asked.tasks.back().tick);
  EXPECT_EQ(second.summary()["state_hash"], whole.summary()["state_hash"]);
  EXPECT_EQ(second.summary()["energy"], whole.summary()["energy"]);
  EXPECT_EQ(second.content("series.csv"), whole.content("series.csv"));
  EXPECT_EQ(second.content("probes.csv"), whole.content("probes.csv"));
}

TEST(Checkpoint, ARunThatWritesNoneIsTheSameToTheBit) {
  FreeRun with, without;
  without.text.replace(without.text.find("checkpoint_interval_s: 2e-4"), 27, "checkpoint_interval_s: 0");
  with.execute();
  without.execute();
  EXPECT_TRUE(std::filesystem::exists(checkpoint_path(with.folder->path)));
  EXPECT_FALSE(std::filesystem::exists(checkpoint_path(without.folder->path)));
  EXPECT_EQ(with.summary()["state_hash"], without.summary()["state_hash"]);
}

TEST(Checkpoint, ThatOfAnotherSceneOrOfMoreBytesIsRefused) {
  const FreeRun first = stopped();
  FreeRun other;
  other.folder = first.folder, other.options.resume = true, other.options.scene_hash = std::string(64, 'a');
  EXPECT_EQ(refused(other).kind, "bad_checkpoint");
  FreeRun longer;
  longer.folder = first.folder, longer.options.resume = true;
  const std::string path = checkpoint_path(first.folder->path);
  const std::string hash = scene::load(first.folder->path + "/given.textproto", {}).hash;
  write_checkpoint(path, hash, read_checkpoint(path, hash) + "more");
  const Error e = refused(longer);
  EXPECT_EQ(e.kind, "bad_checkpoint");
  EXPECT_NE(std::string(e.what()).find("has 4 bytes too many"), std::string::npos) << e.what();
}
