// The loop over windows: where it ends, what it leaves, and how it fails.
#include <filesystem>

#include <gtest/gtest.h>

#include "shell/io/checkpoint_file.h"
#include "tests/shell/free_run.h"

using namespace sunder;
using namespace sunder::shell;

TEST(Run, TakesAllWindowsAndEndsTheSession) {
  FreeRun run;
  int windows = 0;
  double last = 0.0;
  run.options.observe = [&](const sunder::shell::Run& now) { ++windows, last = now.time(); };
  EXPECT_EQ(run.execute(), Exit::kDone);
  EXPECT_EQ(windows, 10);
  EXPECT_DOUBLE_EQ(last, 1e-3);
  EXPECT_EQ(run.asked.tasks.size(), 10u);
  EXPECT_TRUE(run.asked.ended);
  EXPECT_EQ(run.asked.aborted, "");
  EXPECT_EQ(run.summary()["status"], "done");
  EXPECT_NE(run.content("scene_as_run.textproto").find("name: \"free_run\""), std::string::npos);
}

TEST(Run, EndsEarlierWhereThatIsAsked) {
  FreeRun run;
  run.options.until = 3e-4;
  EXPECT_EQ(run.execute(), Exit::kDone);
  EXPECT_EQ(run.asked.tasks.size(), 3u);
  EXPECT_DOUBLE_EQ(run.summary()["time"]["simulated_s"].get<double>(), 3e-4);
}

TEST(Run, AnInterruptionLeavesACheckpointAndItsStatus) {
  FreeRun run;
  EXPECT_EQ(run.execute(true), Exit::kInterrupted);
  EXPECT_TRUE(run.asked.tasks.empty());
  EXPECT_EQ(run.summary()["status"], "interrupted");
  EXPECT_TRUE(std::filesystem::exists(checkpoint_path(run.folder->path)));
}

TEST(Run, AnErrorIsToldToTheEngineAndToRunJsonWithItsWindow) {
  FreeRun run;
  run.options.tamper = [](std::int64_t window, std::vector<Proxy>& bodies) {
    if (window == 4) bodies[0].body.motion.velocity.x() += 1e-6;
  };
  try {
    run.execute();
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "ledger");
    EXPECT_EQ(std::string(e.what()).rfind("window 4: what the shell lost, body 'ball' did not gain", 0), 0u)
        << e.what();
  }
  EXPECT_EQ(run.asked.aborted, "ledger");
  EXPECT_FALSE(run.asked.ended);
  const auto summary = run.summary();
  EXPECT_EQ(summary["status"], "failed");
  EXPECT_EQ(summary["error"]["kind"], "ledger");
  EXPECT_EQ(summary["error"]["window"], 4);
  EXPECT_EQ(summary["error"]["body"], "ball");
}
