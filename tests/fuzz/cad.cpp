// STEP and IGES files. OpenCASCADE reads them, so they are no part of the fuzzers with sanitizers, which build all they
// read.
#ifdef SUNDER_CAD
#include "shell/io/cad_file.h"
#include "tests/fuzz/targets.h"

namespace sunder::fuzz {

/// First byte: the format.
void run_cad(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  const std::string name = data[0] % 2 ? "part.igs" : "part.step";
  scene::LoadedScene scene;
  scene.path = file_with(name, data + 1, size - 1);
  proto::CadFace cad;
  cad.set_path(name);
  refuses_by_name([&] {
    const shell::CadFile file(scene, "shells[0].cad", cad);
    file.edges(), file.box();
    for (int k = 0; k < std::min(file.faces(), 4); ++k) {
      cad.set_face(k);
      for (const shell::CadSurface& surface : file.surfaces(scene, "shells[0].cad", cad)) {
        demand(surface.area > 0.0, "a face without an area");
        for (const Vec3& x : surface.patch.control_points) demand(x.allFinite(), "a control point that is not finite");
      }
    }
  });
}

}  // namespace sunder::fuzz
#endif
