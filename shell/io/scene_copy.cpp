#include "shell/io/scene_copy.h"

#include "shell/io/vtp.h"

namespace sunder::shell {
namespace {

constexpr const char* kCopyName = "scene_as_run.textproto";
constexpr const char* kCopyHead =
    "# The scene of this run with its settings and presets. Files that it names are beside the scene that "
    "command.json\n"
    "# names.\n";

}  // namespace

void write_scene_copy(const std::string& folder, const std::string& scene_text) {
  if (!scene_text.empty()) write_atomically(folder + "/" + kCopyName, kCopyHead + scene_text);
}

}  // namespace sunder::shell
