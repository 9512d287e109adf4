#pragma once
// One face of OpenCASCADE as a spline and loops. Included by files that are built with OpenCASCADE only.
#include <string>

#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Face.hxx>

#include "shell/io/cad_file.h"

namespace sunder::shell {

constexpr double kMetresPerUnit = 1e-3;  // OpenCASCADE's tolerances fit millimetres, so it converts to them

/// The place that messages refer to.
struct CadPlace {
  const scene::LoadedScene& scene;
  std::string field, path;  // field of the message; path of the file
  int face = 0;

  template <class... Args>
  void check(bool good, fmt::format_string<Args...> format, Args&&... args) const {
    if (!good)
      scene.fail(field + ".path",
                 fmt::format("'{}': face {} ", path, face) + fmt::format(format, std::forward<Args>(args)...));
  }
};

/// Converts a face, in metres times `scale`. Holes no wider than `filled` [m] are left out. A face that closes on
/// itself, has a crease or a wide arc is divided along its parameters; others are one surface. Throws Error where the
/// face has no end, no width, a degree above `kHighestDegree`, or borders that are no closed loops.
std::vector<CadSurface> convert_face(const CadPlace& place, const TopoDS_Face& face, double scale, double filled);

}  // namespace sunder::shell
