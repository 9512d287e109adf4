#pragma once
// Names of bodies and layers in a STEP or IGES file. For cad_file.cpp alone: it needs OpenCASCADE.
#include <map>
#include <set>
#include <string>

#include <TopTools_IndexedMapOfShape.hxx>
#include <XSControl_Reader.hxx>

namespace sunder::shell {

/// Faces by the name of what they belong to, numbered from 0.
struct CadNames {
  std::map<std::string, std::set<int>> bodies, layers;
};

/// Names of a file that has been transferred; `faces` are all of it. Bodies are products, solids and shells of STEP,
/// and entities of IGES that have a name. Layers are those of STEP, and levels of IGES by their numbers.
CadNames names_of(const XSControl_Reader& reader, const TopTools_IndexedMapOfShape& faces);

}  // namespace sunder::shell
