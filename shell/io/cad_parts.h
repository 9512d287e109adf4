#pragma once
// Shells of several CAD faces.
#include <vector>

#include "coupler/scene/load.h"
#include "shell/io/build.h"
#include "shell/io/cad_file.h"

namespace sunder::shell {

/// A shell of a run: the index of the scene's shell, the message that it is made of, and the part of its CAD face.
/// Where the face is turned over, `cad.faces` of the message has it too.
struct ScenePart {
  int shell = 0;
  proto::Shell message;
  int part = 0;
  double apart = 0.0;  // how far the file lets its border be from that of another face [m]
};

/// The shells of a run, in the order of the scene. A shell of several CAD faces becomes one for each face, or more
/// where a face is divided. Throws Error for a file that cannot be read or lacks the face. Throws it as well for more
/// than kMostFaces, for three faces that share an edge, and for a name of the scene that fits no shell.
std::vector<ScenePart> scene_parts(const scene::LoadedScene& scene, CadFiles& files);

/// Which parts may meet. Parts of different shells may. Two parts of one file may if an edge of the file lies between
/// their faces. They may as well if both faces have edges of their own, as in a file without topology.
std::vector<std::vector<char>> may_meet(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                                        CadFiles& files);

/// Throws Error where two faces of a shell have an edge of the file in common and are not joined in `setup`.
void check_joined(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                  const RunSetup& setup);

}  // namespace sunder::shell
