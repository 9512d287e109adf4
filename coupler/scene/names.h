#pragma once
// Names by which parts of a scene refer to one another.
#include <string>
#include <vector>

#include "coupler/core/nearest.h"
#include "coupler/scene/load.h"

namespace sunder::scene {

/// Names of a repeated field's entries, in the file's order.
template <class List>
std::vector<std::string> names_in(const List& list) {
  std::vector<std::string> names;
  for (const auto& entry : list) names.push_back(entry.name());
  return names;
}

/// Values of an enum that a scene may name, as "A, B or C"; UNSPECIFIED is none.
std::string one_of(const google::protobuf::EnumDescriptor& type);

/// What is wrong where a message has no such field: the nearest right names, and all that it has.
std::string unknown_field(const std::string& name, const google::protobuf::Descriptor& type);

/// What is wrong where an enum has no such value: the nearest right ones, and all that it has.
std::string unknown_value(const std::string& name, const google::protobuf::EnumDescriptor& type);

/// Refuses a reference to a part that the scene does not have, with the nearest right names. `kind`: what `names` are,
/// "material" or "shell or body". `remedy`: what else helps, or empty.
[[noreturn]] void refuse_name(const LoadedScene& scene, const std::string& field, const std::string& name,
                              const std::string& kind, const std::vector<std::string>& names,
                              const std::string& remedy = "");

}  // namespace sunder::scene
