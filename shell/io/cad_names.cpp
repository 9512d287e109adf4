#ifdef SUNDER_CAD

#include "shell/io/cad_names.h"

#include <vector>

#include <fmt/format.h>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_LevelListEntity.hxx>
#include <IGESData_NameEntity.hxx>
#include <Interface_InterfaceModel.hxx>
#include <StepBasic_Product.hxx>
#include <StepBasic_ProductDefinition.hxx>
#include <StepBasic_ProductDefinitionFormation.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepShape_ConnectedFaceSet.hxx>
#include <StepShape_ShellBasedSurfaceModel.hxx>
#include <StepShape_SolidModel.hxx>
#include <StepVisual_HArray1OfLayeredItem.hxx>
#include <StepVisual_LayeredItem.hxx>
#include <StepVisual_PresentationLayerAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopoDS_Shape.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

namespace sunder::shell {
namespace {

using Entity = opencascade::handle<Standard_Transient>;

// Blanks fill the names of IGES files up to 8 characters, at either end.
std::string text_of(const opencascade::handle<TCollection_HAsciiString>& text) {
  if (text.IsNull()) return {};
  const std::string all = text->ToCString();
  const std::size_t begin = all.find_first_not_of(' ');
  const std::string out =
      begin == std::string::npos ? std::string() : all.substr(begin, all.find_last_not_of(' ') + 1 - begin);
  return out == "NONE" ? std::string() : out;
}

// The name of an entity's property, else its label with a number behind it, as "RIB(2)"; a number of 0 is none.
std::string name_of(const IGESData_IGESEntity& entity) {
  if (!entity.HasShortLabel() || entity.NbTypedProperties(STANDARD_TYPE(IGESData_NameEntity)) > 0)
    return text_of(entity.NameValue());
  const std::string label = text_of(entity.ShortLabel());
  const int number = entity.HasSubScriptNumber() ? entity.SubScriptNumber() : 0;
  return label.empty() || number == 0 ? label : fmt::format("{}({})", label, number);
}

// Finds faces of what was transferred. Instances of an assembly share the faces of their part.
class Faces {
 public:
  Faces(const XSControl_Reader& reader, const TopTools_IndexedMapOfShape& faces)
      : results_(reader.WS()->TransferReader()->TransientProcess()) {
    for (int i = 1; i <= faces.Extent(); ++i) numbers_[faces(i).TShape().get()].push_back(i - 1);
  }
  void add(const std::string& name, const Entity& entity, std::map<std::string, std::set<int>>& to) const {
    if (name.empty() || entity.IsNull()) return;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(results_, entity);
    if (shape.IsNull()) return;
    TopTools_IndexedMapOfShape own;
    TopExp::MapShapes(shape, TopAbs_FACE, own);
    for (int k = 1; k <= own.Extent(); ++k)
      if (const auto found = numbers_.find(own(k).TShape().get()); found != numbers_.end())
        to[name].insert(found->second.begin(), found->second.end());
  }

 private:
  opencascade::handle<Transfer_TransientProcess> results_;
  std::map<const TopoDS_TShape*, std::vector<int>> numbers_;
};

void add_step(const Entity& entry, const Faces& faces, CadNames& out) {
  if (const auto product = opencascade::handle<StepBasic_ProductDefinition>::DownCast(entry); !product.IsNull()) {
    if (product->Formation().IsNull() || product->Formation()->OfProduct().IsNull()) return;
    const auto of = product->Formation()->OfProduct();
    const std::string name = text_of(of->Name());
    faces.add(name.empty() ? text_of(of->Id()) : name, entry, out.bodies);
    return;
  }
  if (entry->IsKind(STANDARD_TYPE(StepShape_SolidModel)) ||
      entry->IsKind(STANDARD_TYPE(StepShape_ShellBasedSurfaceModel)) ||
      entry->IsKind(STANDARD_TYPE(StepShape_ConnectedFaceSet)))
    faces.add(text_of(opencascade::handle<StepRepr_RepresentationItem>::DownCast(entry)->Name()), entry, out.bodies);
  const auto layer = opencascade::handle<StepVisual_PresentationLayerAssignment>::DownCast(entry);
  if (layer.IsNull() || layer->AssignedItems().IsNull()) return;
  for (int i = 1; i <= layer->NbAssignedItems(); ++i) {
    Entity item = layer->AssignedItemsValue(i).Value();
    if (const auto styled = opencascade::handle<StepVisual_StyledItem>::DownCast(item); !styled.IsNull())
      item = styled->Item();
    faces.add(text_of(layer->Name()), item, out.layers);
  }
}

void add_iges(const opencascade::handle<IGESData_IGESEntity>& entry, const Faces& faces, CadNames& out) {
  if (entry->HasName()) faces.add(name_of(*entry), entry, out.bodies);
  if (entry->DefLevel() == IGESData_DefOne) faces.add(std::to_string(entry->Level()), entry, out.layers);
  if (entry->DefLevel() == IGESData_DefSeveral && !entry->LevelList().IsNull())
    for (int k = 1; k <= entry->LevelList()->NbLevelNumbers(); ++k)
      faces.add(std::to_string(entry->LevelList()->LevelNumber(k)), entry, out.layers);
}

}  // namespace

CadNames names_of(const XSControl_Reader& reader, const TopTools_IndexedMapOfShape& all) {
  CadNames out;
  const Faces faces(reader, all);
  const auto model = reader.WS()->Model();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Entity entry = model->Value(i);
    if (const auto iges = opencascade::handle<IGESData_IGESEntity>::DownCast(entry); !iges.IsNull())
      add_iges(iges, faces, out);
    else
      add_step(entry, faces, out);
  }
  return out;
}

}  // namespace sunder::shell

#endif
