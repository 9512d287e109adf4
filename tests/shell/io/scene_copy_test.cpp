// The copy of a scene in the folder of its run: a scene itself, and the same one.
#include "shell/io/scene_copy.h"

#include <filesystem>

#include "tests/coupler/small_scene.h"
#include "tests/temporary_folder.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr const char* kSceneCopy = "/scene_as_run.textproto";

std::string copied_text(const TemporaryFolder& folder) {
  std::ifstream in(folder.path + kSceneCopy, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST(SceneCopy, IsTheSceneWithItsSettings) {
  const TemporaryFolder folder;
  const std::string path = folder.path + "/small.textproto";
  std::ofstream(path) << small_scene::kScene;
  const scene::LoadedScene scene = scene::load(path, {"bodies[ball].sphere.radius_m=0.03", "window_s=2e-4"});
  write_scene_copy(folder.path, scene.text);
  const std::string copy = copied_text(folder);
  EXPECT_EQ(copy.rfind("# The scene of this run with its settings and presets. ", 0), 0u) << copy;
  const scene::LoadedScene again = scene::load(folder.path + kSceneCopy, {});
  EXPECT_EQ(again.text, scene.text);
  EXPECT_EQ(again.hash, scene.hash);
  EXPECT_EQ(again.message.bodies(0).sphere().radius_m(), 0.03);
  EXPECT_EQ(again.message.window_s(), 2e-4);
}

TEST(SceneCopy, ReplacesAnOlderOne) {
  const TemporaryFolder folder;
  write_scene_copy(folder.path, "name: \"a name that is longer\"\n");
  write_scene_copy(folder.path, "name: \"b\"\n");
  const std::string copy = copied_text(folder), end = "\n# names.\nname: \"b\"\n";
  ASSERT_GT(copy.size(), end.size());
  EXPECT_EQ(copy.substr(copy.size() - end.size()), end);
}

TEST(SceneCopy, OfNoTextIsNone) {
  const TemporaryFolder folder;
  write_scene_copy(folder.path, "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  write_scene_copy(folder.path + "/absent", "");  // nothing to write, nothing to refuse
}

TEST(SceneCopy, ThatCannotBeWrittenIsTold) {
  const TemporaryFolder folder;
  try {
    write_scene_copy(folder.path + "/absent", "name: \"a\"\n");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.kind, "bad_output");
    EXPECT_EQ(e.what(), folder.path + "/absent" + kSceneCopy + ": cannot be written; is there room and permission?");
  }
}
