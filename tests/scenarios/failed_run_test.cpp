// A run that fails keeps a frame of the last window whose start was sound.
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>

#include <fmt/format.h>
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

constexpr double kLongWindow = 1.5e-4;  // [s]: a hundred substeps
constexpr int kBadWindow = 3;

// True where no frame of the folder has a number that is not one.
bool frames_are_sound(const std::string& folder) {
  const std::string nan("\0\0\0\0\0\0\xf8\x7f", 8);  // as frames store it
  for (const auto& file : std::filesystem::directory_iterator(folder + "/frames"))
    if (contents(file).find(nan) != std::string::npos) return false;
  return true;
}

}  // namespace

// A pressure that begins shortly after the start of a window of a hundred substeps, and is so large that strains
// overflow.
TEST(FailedRun, ThatFindsABadNumberEarlyInALongWindowKeepsAFrameOfItsStart) {
  const TemporaryFolder folder;
  std::string text = scene_of("1e9");
  const std::string end = "elements_y: 8 }";
  text.insert(
      text.find(end) + end.size(),
      fmt::format("\n  loads {{ pressure: 1 factor {{ time_s: {} value: 0 }} factor {{ time_s: {} value: 1e300 }} }}",
                  kBadWindow * kLongWindow, (kBadWindow + 0.01) * kLongWindow));
  std::ofstream(folder.path + "/scene.textproto") << text;
  const auto scene = scene::load(folder.path + "/scene.textproto", {fmt::format("window_s={}", kLongWindow),
                                                                    fmt::format("end_time_s={}", 10 * kLongWindow)});
  rigid::FreeFlight engine;
  shell::RunOptions options;
  options.out = folder.path, options.quiet = true, options.scene_hash = scene.hash;
  options.connect = [&](const shell::RunOptions&) { return std::make_unique<link::EngineHost>(engine); };
  const std::atomic<bool> never{false};
  try {
    shell::Run(shell::build(scene), options).execute(never);
    FAIL() << "nothing was found";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "unstable") << e.what();
    EXPECT_EQ(e.window, kBadWindow);
    double u = 0.0, v = 0.0, time = 0.0;
    ASSERT_EQ(
        std::sscanf(e.what(), "window 3: shell 'pane' is unstable: at (u, v) = (%lf, %lf) and %lf s", &u, &v, &time), 3)
        << e.what();
    // eight substeps of a hundred until the numbers are looked at, after a few in which they overflow
    EXPECT_GT(time, kBadWindow * kLongWindow);
    EXPECT_LT(time, (kBadWindow + 0.2) * kLongWindow);
    EXPECT_TRUE(u >= 0.0 && u <= 0.08 && v >= 0.0 && v <= 0.08) << e.what();
  }
  const std::string list = contents(folder.path + "/frames.pvd");
  const std::size_t last = list.rfind("timestep=\"");
  ASSERT_NE(last, std::string::npos) << list;
  EXPECT_NEAR(std::stod(list.substr(last + 10)), kBadWindow * kLongWindow, 1e-15) << list;
  EXPECT_TRUE(frames_are_sound(folder.path));
}

TEST(FailedRun, KeepsAFrameOfTheStartOfItsLastWindow) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_in(folder.path), "ledger");
  const std::string list = contents(folder.path + "/frames.pvd");
  const std::size_t last = list.rfind("timestep=\"");
  ASSERT_NE(last, std::string::npos) << list;
  EXPECT_NEAR(std::stod(list.substr(last + 10)), 4 * 2e-6, 1e-15) << list;
  EXPECT_NE(contents(folder.path + "/run.json").find("\"failed\""), std::string::npos);
  EXPECT_TRUE(frames_are_sound(folder.path));
  const std::filesystem::directory_iterator frames(folder.path + "/frames");
  EXPECT_GE(std::distance(begin(frames), end(frames)), 4);  // shell and bodies, at the start and now
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
