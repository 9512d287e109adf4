#pragma once
// A small scene that is accepted, and helpers that change it.
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "coupler/scene/load.h"
#include "shell/io/build.h"
#include "shell/io/check.h"

namespace small_scene {

inline const std::string kScene = R"(name: "small"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.004
  plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 }
}
bodies {
  name: "ball"
  material: "glass"
  sphere { radius_m: 0.02 }
  pose { position { z: 0.1 } }
}
)";

inline std::string replaced(const std::string& from, const std::string& to) {
  std::string text = kScene;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// The small scene with additional fields of the shell (line 10), the material and the scene.
inline std::string with_fields(const std::string& shell, const std::string& material = "",
                               const std::string& more = "") {
  std::string text = replaced("poisson_ratio: 0.22 }", "poisson_ratio: 0.22 " + material + "}");
  text.insert(text.find("elements_y: 16 }\n") + 17, "  " + shell + "\n");
  return text + more;
}

inline const std::string kStrong = "strength: 6e7 fracture_energy: 8 ";

/// The same with a material that breaks.
inline std::string strong(const std::string& shell, const std::string& more = "",
                          const std::string& material = kStrong) {
  return with_fields(shell, material, more);
}

/// A second plate, beside the first.
inline const std::string kWing =
    "shells { name: \"wing\" material: \"glass\" thickness_m: 0.004 "
    "plate { size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 pose { position { x: 0.5 } } } }\n";

// A path of this process alone, because tests run in parallel.
inline std::string own_file(const std::string& name) {
  return fmt::format("{}/{}_{}", testing::TempDir(), getpid(), name);
}

inline sunder::shell::RunSetup built(const std::string& text, const std::vector<std::string>& settings = {}) {
  const std::string path = own_file("built_test.textproto");
  std::ofstream(path) << text;
  const auto scene = sunder::scene::load(path, settings);
  std::remove(path.c_str());
  return sunder::shell::build(scene);
}

inline sunder::Error refusal(const std::string& text, const std::vector<std::string>& settings = {}) {
  const std::string path = own_file("scene_test.textproto");
  std::ofstream(path) << text;
  struct Remover {
    const std::string& path;
    ~Remover() { std::remove(path.c_str()); }
  } const remover{path};
  try {
    const auto scene = sunder::scene::load(path, settings);
    sunder::shell::check_report(scene, sunder::shell::build(scene));
  } catch (const sunder::Error& e) {
    return e;
  }
  return sunder::Error(sunder::Exit::kDone, "accepted", "");
}

/// The report of `sunder check` for an accepted scene.
inline std::string report(const std::string& text) {
  const std::string path = own_file("scene_test.textproto");
  std::ofstream(path) << text;
  const auto scene = sunder::scene::load(path, {});
  std::remove(path.c_str());
  return sunder::shell::check_report(scene, sunder::shell::build(scene));
}

/// Expects that the scene is refused as bad input at `field`, with all of `says` in the message.
inline void expect_refusal(const std::string& text, const std::string& field, const std::vector<std::string>& says,
                           const std::vector<std::string>& settings = {}) {
  const sunder::Error e = refusal(text, settings);
  EXPECT_EQ(e.status, sunder::Exit::kBadInput) << e.what();
  EXPECT_EQ(e.field, field) << e.what();
  if (settings.empty()) {  // a setting has no line
    EXPECT_GT(e.line, 0) << e.what();
  }
  for (const std::string& part : says) EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
}

}  // namespace small_scene
