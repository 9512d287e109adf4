#pragma once
// Faces of a STEP or IGES file whose border meets itself. For cad_file.cpp alone: it needs OpenCASCADE.
#include <map>
#include <string>

#include <TopTools_IndexedMapOfShape.hxx>
#include <XSControl_Reader.hxx>

namespace sunder::shell {

/// What is said of faces of a file that has been transferred, by number from 0, where the border of an entry meets
/// itself: OpenCASCADE divides such a face there. `faces` are all of the file; `factor` takes it to millimetres.
std::map<int, std::string> crossed_faces(const XSControl_Reader& reader, const TopTools_IndexedMapOfShape& faces,
                                         double factor);

}  // namespace sunder::shell
