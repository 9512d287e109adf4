#include "coupler/scene/names.h"

#include <google/protobuf/descriptor.h>

namespace sunder::scene {

namespace {

std::vector<std::string> values_of(const google::protobuf::EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i)
    if (!type.value(i)->name().ends_with("UNSPECIFIED")) names.push_back(type.value(i)->name());
  return names;
}

}  // namespace

std::string one_of(const google::protobuf::EnumDescriptor& type) {
  const std::vector<std::string> names = values_of(type);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

std::string unknown_field(const std::string& name, const google::protobuf::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  if (name == "interlock_strength")  // as scenes of version 0.1 have it
    return "'interlock_strength' is no field any more: crack faces slide by the material's crack_friction and crush at "
           "its "
           "crushing_strength; leave it out";
  const bool near = !nearest_names(name, names).empty();
  return fmt::format("'{}' is no field of {}; {}: {}", name, type.name(),
                     near ? did_you_mean(name, names) + " It has" : "it has", fmt::join(names, ", "));
}

std::string unknown_value(const std::string& name, const google::protobuf::EnumDescriptor& type) {
  const std::vector<std::string> names = values_of(type);
  const bool near = !nearest_names(name, names).empty();
  return fmt::format("'{}' is none of its values; {} {}", name,
                     near ? did_you_mean(name, names) + " They are" : "they are", one_of(type));
}

void refuse_name(const LoadedScene& scene, const std::string& field, const std::string& name, const std::string& kind,
                 const std::vector<std::string>& names, const std::string& remedy) {
  scene.fail(field, fmt::format("'{}' is no {} of this scene ({}){}", name, kind, did_you_mean(name, names),
                                remedy.empty() ? "" : "; " + remedy));
}

}  // namespace sunder::scene
