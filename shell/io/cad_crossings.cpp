// With cad_file, the only files that use OpenCASCADE.
#ifdef SUNDER_CAD

#include "shell/io/cad_crossings.h"

#include <optional>
#include <vector>

#include <BRep_Tool.hxx>
#include <Interface_InterfaceModel.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Pnt.hxx>

#include "shell/io/cad_face.h"

namespace sunder::shell {
namespace {

// A face of a file whose border meets itself. OpenCASCADE divides it there, without a word.
struct Crossing {
  TopTools_IndexedMapOfShape faces;  // that it becomes
  std::string entry;                 // of the file
  gp_Pnt at;                         // in the axes of its part
};

// A corner that two faces without a common edge have in one place.
std::optional<gp_Pnt> touching_corner(const TopoDS_Shape& one, const TopoDS_Shape& other) {
  for (TopExp_Explorer a(one, TopAbs_EDGE); a.More(); a.Next())
    for (TopExp_Explorer b(other, TopAbs_EDGE); b.More(); b.Next())
      if (a.Current().IsSame(b.Current())) return std::nullopt;
  for (TopExp_Explorer a(one, TopAbs_VERTEX); a.More(); a.Next())
    for (TopExp_Explorer b(other, TopAbs_VERTEX); b.More(); b.Next()) {
      const TopoDS_Vertex v = TopoDS::Vertex(a.Current()), w = TopoDS::Vertex(b.Current());
      const gp_Pnt at = BRep_Tool::Pnt(v);
      if (at.Distance(BRep_Tool::Pnt(w)) <= BRep_Tool::Tolerance(v) + BRep_Tool::Tolerance(w)) return at;
    }
  return std::nullopt;
}

// The faces of a file that became several which touch at a corner.
std::vector<Crossing> crossings_of(const XSControl_Reader& reader) {
  std::vector<Crossing> out;
  const auto model = reader.WS()->Model();
  const auto results = reader.WS()->TransferReader()->TransientProcess();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto entry = model->Value(i);
    const std::string type = entry->DynamicType()->Name();
    if (type != "StepShape_AdvancedFace" && type != "StepShape_FaceSurface" && type != "IGESGeom_TrimmedSurface" &&
        type != "IGESGeom_BoundedSurface" && type != "IGESSolid_Face")
      continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(results, entry);
    if (shape.IsNull() || shape.ShapeType() == TopAbs_FACE) continue;
    Crossing found;
    TopExp::MapShapes(shape, TopAbs_FACE, found.faces);
    std::optional<gp_Pnt> at;
    for (int a = 1; a <= found.faces.Extent() && !at; ++a)
      for (int b = 1; b < a && !at; ++b) at = touching_corner(found.faces(a), found.faces(b));
    if (!at) continue;
    found.entry = model->StringLabel(entry)->ToCString(), found.at = *at;
    out.push_back(std::move(found));
  }
  return out;
}

}  // namespace

std::map<int, std::string> crossed_faces(const XSControl_Reader& reader, const TopTools_IndexedMapOfShape& faces,
                                         double factor) {
  std::map<int, std::string> out;
  const double metres = kMetresPerUnit * factor;
  for (const Crossing& c : crossings_of(reader))
    for (int i = 1; i <= faces.Extent(); ++i)
      for (int k = 1; k <= c.faces.Extent(); ++k)
        if (faces(i).TShape() == c.faces(k).TShape())
          out[i - 1] = fmt::format(
              "is a part of entry {} of the file, whose border crosses or touches itself at ({:.4g}, "
              "{:.4g}, {:.4g}) m; mend it in the CAD program, or leave its {} faces out by `faces`",
              c.entry, metres * c.at.X(), metres * c.at.Y(), metres * c.at.Z(), c.faces.Extent());
  return out;
}

}  // namespace sunder::shell

#endif
