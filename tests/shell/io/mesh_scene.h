#pragma once
// Scenes with a shell of a mesh file.
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "shell/io/build.h"
#include "tests/shell/triangles.h"
#include "tests/temporary_folder.h"

namespace sunder::shell {

class MeshScene : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path + "/" + name) << text;
  }
  void write(const std::string& name, const Triangles& t) const {
    std::ofstream out(folder.path + "/" + name);
    for (const Vec3& x : t.points) out << fmt::format("v {:.17g} {:.17g} {:.17g}\n", x.x(), x.y(), x.z());
    for (const FileTriangle& f : t.faces)
      out << fmt::format("f {} {} {}\n", f.corners[0] + 1, f.corners[1] + 1, f.corners[2] + 1);
  }
  RunSetup setup(const std::string& mesh, const std::string& in_shell = "", const std::string& after = "",
                 const std::string& in_material = "") const {
    write("scene.textproto", R"(name: "mesh"
end_time_s: 1
window_s: 1e-4
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 )" +
                                 in_material + R"( }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.01
  mesh { )" + mesh + " }\n" + in_shell +
                                 "}\n" + after);
    return build(scene::load(folder.path + "/scene.textproto", {}));
  }
  template <class... Args>
  std::string refusal(Args&&... args) const {
    try {
      setup(std::forward<Args>(args)...);
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      return e.what();
    }
    return "accepted";
  }
  static void expect_part(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  static double area(const RunSetup& r) {
    double sum = 0.0;
    for (const ShellSetup& s : r.shells)
      for (const double part : s.model.mass) sum += part / (s.model.material.density * s.model.thickness);
    return sum;
  }

  TemporaryFolder folder;
};

}  // namespace sunder::shell
