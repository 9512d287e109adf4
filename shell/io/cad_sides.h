#pragma once
// Which faces of a CAD file look to another side than their neighbours.
#include <vector>

#include "shell/io/cad_file.h"

namespace sunder::shell {

/// The faces among `faces` that have to be turned over so that all normals look to one side: along each edge that two
/// of them share, and along free edges that run together, as between the loose faces of an IGES file. Of connected
/// faces the fewer are turned; of two halves, the one without the lowest number. Faces that have no two sides, as a
/// Moebius strip, stay.
std::vector<int> faces_to_turn(const std::vector<CadEdge>& edges, const std::vector<int>& faces);

}  // namespace sunder::shell
