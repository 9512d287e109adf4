#pragma once
// Scenes of two plates, for seams between them.
#include <string>

#include "tests/coupler/small_scene.h"

namespace small_scene {

/// Two plates side by side, additional fields of the second one, and seams.
inline std::string two_plates(const std::string& seams, const std::string& shell = "", double x = 0.5) {
  std::string text = replaced("bodies {", "# bodies: none\nbodies {");
  text.resize(text.find("# bodies"));
  return text + fmt::format(R"(shells {{
  name: "wing"
  material: "glass"
  thickness_m: 0.004
  plate {{ size_x_m: 0.5 size_y_m: 0.5 elements_x: 16 elements_y: 16 pose {{ position {{ x: {} }} }} }}
  {}
}}
{}
)",
                            x, shell, seams);
}

}  // namespace small_scene
