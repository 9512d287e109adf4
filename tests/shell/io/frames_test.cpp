// Frames: what is torn stays torn.
#include "shell/io/frames.h"

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include "shell/solver/cracking/polyline.h"
#include "tests/coupler/small_scene.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// Triangles in frame `number` of the folder.
int triangles(const std::string& folder, int number) {
  std::ifstream file(fmt::format("{}/frames/shell_{:06d}.vtp", folder, number), std::ios::binary);
  std::stringstream all;
  all << file.rdbuf();
  std::smatch found;
  const std::string text = all.str();
  if (!std::regex_search(text, found, std::regex("NumberOfPolys=\"([0-9]+)\""))) return -1;
  return std::stoi(found[1]);
}

/// A pane of 0.2 m with a crack through its middle, and a folder for its frames.
struct Drawn {
  ShellModel model =
      make_shell("pane", plate(0.2, 0.2, 8, 8, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2, {});
  ShellState state = make_state(model, Vec3::Zero(), 0);
  std::string folder = small_scene::own_file("frames");

  Drawn() { insert_polyline(model, state, {{0.03, 0.1}, {0.17, 0.1}}, 0.0); }
  ~Drawn() { std::filesystem::remove_all(folder); }

  void write(FrameWriter& frames, double time) const {
    const std::vector<BodyId> ids(model.control_points(), 1);
    frames.write(time, {{&model, &state}}, {ids}, {}, {}, 100);
  }
  /// Moves the control point next to the middle of the crack along the crack [m].
  void pull(double by) {
    int nearest = 0;
    const Vec2 middle(0.1, 0.11);
    for (int i = 0; i < model.control_points(); ++i)
      if ((model.parameter_of_slot[model.tables.slot(i)] - middle).norm() <
          (model.parameter_of_slot[model.tables.slot(nearest)] - middle).norm())
        nearest = i;
    state.motion.x[model.tables.slot(nearest)] += by;
  }
};

}  // namespace

TEST(Frames, WhatIsTornStaysTorn) {
  Drawn pane;
  FrameWriter frames(pane.folder);
  pane.write(frames, 0.0);
  const int whole = triangles(pane.folder, 0);
  ASSERT_GT(whole, 2 * 64);
  pane.pull(1.0);  // forty elements
  pane.write(frames, 1.0);
  const int torn = triangles(pane.folder, 1);
  EXPECT_LT(torn, whole);
  EXPECT_GT(torn, whole / 2);
  pane.pull(-1.0);
  pane.write(frames, 2.0);
  EXPECT_EQ(triangles(pane.folder, 2), torn);

  // One that takes over what a checkpoint saves leaves out the same; one that never saw it torn draws it.
  FrameWriter resumed(pane.folder);
  frames.saved([&](auto&... from) { resumed.saved([&](auto&... to) { ((to = from), ...); }); });
  pane.write(resumed, 3.0);
  EXPECT_EQ(triangles(pane.folder, 3), torn);
  FrameWriter fresh(pane.folder + "/fresh");
  pane.write(fresh, 0.0);
  EXPECT_EQ(triangles(pane.folder + "/fresh", 0), whole);
}

TEST(Frames, CracksThatDivideWhatIsTornDrawNothingOfIt) {
  Drawn pane;
  FrameWriter frames(pane.folder);
  pane.write(frames, 0.0);
  pane.pull(1.0);
  pane.write(frames, 1.0);
  pane.pull(-1.0);
  const int torn = triangles(pane.folder, 0) - triangles(pane.folder, 1);
  ASSERT_GT(torn, 4);
  insert_polyline(pane.model, pane.state, {{0.06, 0.108}, {0.14, 0.112}}, 0.0);  // from end to end of what is torn
  pane.write(frames, 2.0);
  FrameWriter fresh(pane.folder + "/fresh");
  pane.write(fresh, 0.0);
  const int divided = triangles(pane.folder + "/fresh", 0) - triangles(pane.folder, 2);
  EXPECT_GT(divided, torn);  // each of them, or more parts of it
}

TEST(Frames, HaveTheDamageOfFibresWhereTheyMayTear) {
  for (const bool tear : {false, true}) {
    Drawn pane;
    pane.model.fibres = {1e6, 1e5, 0.5};
    if (tear) pane.model.fibres.shear_strength = 1e4, pane.model.fibres.brittleness = 0.5;
    pane.state = make_state(pane.model, Vec3::Zero(), 0);
    FrameWriter frames(pane.folder);
    pane.write(frames, 0.0);
    std::ifstream file(pane.folder + "/frames/shell_000000.vtp", std::ios::binary);
    std::stringstream all;
    all << file.rdbuf();
    EXPECT_EQ(all.str().find("Name=\"fibre_damage\"") != std::string::npos, tear);
    EXPECT_NE(all.str().find("Name=\"damage\""), std::string::npos);
  }
}
