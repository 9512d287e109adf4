// A run that fails keeps a frame of the last window whose start was sound.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "coupler/link/host.h"
#include "coupler/scene/load.h"
#include "rigid/engine/free_flight.h"
#include "shell/run/run.h"
#include "tests/temporary_folder.h"

using namespace sunder;

namespace {

std::string scene_of(const std::string& frame_interval) {
  return "name: \"doomed\" end_time_s: 1e-3 window_s: 2e-6 gravity {}\n"
         "materials { name: \"pane\" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }\n"
         "shells { name: \"pane\" material: \"pane\" thickness_m: 0.003\n"
         "  plate { size_x_m: 0.08 size_y_m: 0.08 elements_x: 8 elements_y: 8 } }\n"
         "bodies { name: \"ball\" material: \"pane\" sphere { radius_m: 0.02 } pose { position { z: 0.05 } }\n"
         "  twist { linear { z: -1 } } }\n"
         "output { frame_interval_s: " +
         frame_interval + " checkpoint_interval_s: 0 }\n";
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The kind of the error with which the run ends, in whose window 4 a speed becomes NaN. `then` happens there too.
std::string run_in(
    const std::string& folder, const std::string& frame_interval = "1e9", const std::function<void()>& then = [] {}) {
  std::ofstream(folder + "/scene.textproto") << scene_of(frame_interval);
  const auto scene = scene::load(folder + "/scene.textproto", {});
  rigid::FreeFlight engine;
  shell::RunOptions options;
  options.out = folder, options.quiet = true, options.scene_hash = scene.hash;
  options.connect = [&](const shell::RunOptions&) { return std::make_unique<link::EngineHost>(engine); };
  options.tamper = [&](std::int64_t window, std::vector<shell::Proxy>& bodies) {
    if (window != 4) return;
    bodies[0].body.motion.velocity.x() = std::numeric_limits<double>::quiet_NaN();
    then();
  };
  const std::atomic<bool> never{false};
  try {
    shell::Run(shell::build(scene), options).execute(never);
  } catch (const Error& e) {
    return e.kind;
  }
  return "";
}

}  // namespace

TEST(FailedRun, KeepsAFrameOfTheStartOfItsLastWindow) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_in(folder.path), "ledger");
  const std::string list = contents(folder.path + "/frames.pvd");
  const std::size_t last = list.rfind("timestep=\"");
  ASSERT_NE(last, std::string::npos) << list;
  EXPECT_NEAR(std::stod(list.substr(last + 10)), 4 * 2e-6, 1e-15) << list;
  EXPECT_NE(contents(folder.path + "/run.json").find("\"failed\""), std::string::npos);
  const std::string nan("\0\0\0\0\0\0\xf8\x7f", 8);  // as frames store it
  int frames = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder.path + "/frames")) {
    EXPECT_EQ(contents(file).find(nan), std::string::npos) << file.path();
    ++frames;
  }
  EXPECT_GE(frames, 4);  // shell and bodies, at the start and now
}

TEST(FailedRun, LeavesAFrameThatIsThereAsItIs) {
  const TemporaryFolder folder;
  std::string before;
  const std::string shell = folder.path + "/frames/shell_000004.vtp";
  EXPECT_EQ(run_in(folder.path, "2e-6", [&] { before = contents(shell); }), "ledger");
  EXPECT_FALSE(before.empty());
  EXPECT_EQ(contents(shell), before);
  EXPECT_FALSE(std::filesystem::exists(folder.path + "/frames/shell_000005.vtp"));
}

TEST(FailedRun, SaysSoWhereItsFrameCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_in(folder.path, "1e9",
                   [&] {
                     std::filesystem::remove_all(folder.path + "/frames");
                     std::ofstream(folder.path + "/frames") << "in the way";
                   }),
            "ledger");
  EXPECT_NE(contents(folder.path + "/run.json").find("\"failed\""), std::string::npos);
}
