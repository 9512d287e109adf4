#pragma once
// Faces of STEP and IGES files as patches with trim loops.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "coupler/scene/load.h"
#include "shell/geometry/patch.h"
#include "shell/geometry/plane_curves.h"

namespace sunder::shell {

constexpr int kMostFaces = 2000;  // of a file that one shell takes: each is a shell of the run

/// A stretch of a face's border, along one edge of the file.
struct CadBorder {
  PlaneCurve curve;  // in the parameters of the patch
  int sides = 0;     // EdgeBits of the edges of the patch on which it runs as a whole
};

/// A closed loop of borders, each beginning where the one before ends.
struct CadLoop {
  std::vector<CadBorder> borders;
  bool hole = false;
};

/// A face of a file, or a part of one.
struct CadSurface {
  Patch patch;                 // [m]
  std::vector<CadLoop> loops;  // empty: the whole patch
  double area = 0.0;           // of the whole face, as OpenCASCADE has it [m^2]
  double error = 0.0;          // of a surface of higher degree that is approximated [m]
};

/// An edge of a file.
struct CadEdge {
  std::vector<int> faces;      // that it bounds: one for a free edge, two for one that they share, or the same twice
  double length = 0.0;         // [m]
  double tolerance = 0.0;      // as the file or its reader has it: how far faces may be apart [m]
  Vec3 middle = Vec3::Zero();  // [m]
  std::vector<Vec3> points{};  // along it, evenly in its parameter, from end to end [m]
  // For each of `faces`: 1 where its border, seen from its normal counter-clockwise, runs along the points, -1 against
  // them, 0 where a face meets itself.
  std::vector<int> senses{};
};

/// Faces of a file by the name of a body or of a layer.
struct NamedCadFaces {
  std::string name;
  std::vector<int> faces;
};

/// A file that has been read. OpenCASCADE does all of it in a process of its own first (cad_trial.h): no file ends or
/// holds this one.
class CadFile {
 public:
  /// Reads the file `cad.path`. Throws Error where OpenCASCADE is missing or does not come through, the file cannot be
  /// read, has no face that `cad` names, or neither the file nor `cad.unit_m` says its unit.
  CadFile(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad);

  /// Number of faces.
  int faces() const;
  /// Face `cad.face` in metres times `cad.scale`, with its loops. A face that closes on itself, has a crease or an arc
  /// of 150 degrees is divided; one of a higher degree than shells have is approximated. With `cad.faces` beside
  /// `cad.face`, which no scene has, the face is turned over. Throws Error where there is no such face, or where no
  /// approximation is near enough.
  std::vector<CadSurface> surfaces(const scene::LoadedScene& scene, const std::string& field,
                                   const proto::CadFace& cad) const;
  /// Bodies and layers that have a name and a face, in the order of their names (cad_names.h).
  const std::vector<NamedCadFaces>& bodies() const;
  const std::vector<NamedCadFaces>& layers() const;
  /// Faces that `cad` takes: `face`, `faces`, those of `body` or `layer`, or all. Throws Error with the right names or
  /// numbers where the file has none such; `face` is not checked.
  std::vector<int> chosen(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) const;
  /// All edges, in the file's size; poles are none.
  std::vector<CadEdge> edges() const;
  /// Kind of a face's surface, for example "plane".
  std::string kind(int face) const;
  /// Unit of length, as the file has it, or the given one.
  const std::string& unit() const;
  /// Lower and upper corner of a box around all faces [m].
  std::pair<Vec3, Vec3> box() const;

 private:
  struct Shape;
  static std::shared_ptr<const Shape> shape_of(const scene::LoadedScene& scene, const std::string& field,
                                               const proto::CadFace& cad);
  // Asks OpenCASCADE for all that a scene with `cad` needs.
  void ask_all(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) const;
  std::vector<CadSurface> converted(const scene::LoadedScene& scene, const std::string& field,
                                    const proto::CadFace& cad, int face, bool turned) const;
  std::shared_ptr<const Shape> shape_;
};

struct MeshShells;

/// The files of a scene, CAD and meshes. Each is read once.
class CadFiles {
 public:
  const CadFile& of(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) {
    const std::pair<std::string, double> key{cad.path(), cad.unit_m()};
    const auto known = files_.find(key);
    return known != files_.end() ? known->second : files_.emplace(key, CadFile(scene, field, cad)).first->second;
  }

  /// The shells of the mesh of a shell, or of a part of it (mesh_parts.h); `field` is that of the mesh.
  const MeshShells& mesh(const scene::LoadedScene& scene, const std::string& field, const proto::Shell& shell);

 private:
  std::map<std::pair<std::string, double>, CadFile> files_;  // by path and unit_m
  std::map<std::string, std::shared_ptr<const MeshShells>> meshes_;
};

}  // namespace sunder::shell
