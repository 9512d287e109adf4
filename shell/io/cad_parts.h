#pragma once
// Shells of several CAD faces.
#include <vector>

#include "coupler/scene/load.h"
#include "shell/io/build.h"
#include "shell/io/cad_file.h"

namespace sunder::shell {

constexpr int kMostFaces = 2000;  // of a file that one shell takes: each is a shell of the run

/// A shell of a run: the index of the scene's shell, the message that it is made of, and the part of its CAD face.
struct ScenePart {
  int shell = 0;
  proto::Shell message;
  int part = 0;
  double apart = 0.0;  // how far the file lets its border be from that of another face [m]
};

/// The shells of a run, in the order of the scene. A shell of several CAD faces becomes one for each face, or more
/// where a face is divided. Throws Error where a file cannot be read or has no such face, where the shell would be of
/// more than kMostFaces, where three of the faces share an edge, and where a name of the scene fits no shell.
std::vector<ScenePart> scene_parts(const scene::LoadedScene& scene, CadFiles& files);

/// Which parts may meet: all of different shells; those of one file where it has an edge between their faces, or where
/// both faces have edges that no other face of the shell has, as in a file without topology.
std::vector<std::vector<char>> may_meet(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts,
                                        CadFiles& files);

/// Throws Error where two faces of a shell have an edge of the file in common and are not joined in `setup`.
void check_joined(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                  const RunSetup& setup);

}  // namespace sunder::shell
