// Applies --set: one field of a scene, by its path.
#include <algorithm>
#include <sstream>

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "coupler/scene/names.h"

namespace sunder::scene {
namespace pb = google::protobuf;
namespace {

std::string name_of(const pb::Message& m) {
  const auto* f = m.GetDescriptor()->FindFieldByName("name");
  return f ? m.GetReflection()->GetString(m, f) : std::string();
}

/// What a field's value is, in words.
const char* kind_of(const pb::FieldDescriptor& f) {
  switch (f.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
      return "number";
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return "truth value; give true or false";
    case pb::FieldDescriptor::CPPTYPE_STRING:
      return "text";
    default:
      return "whole number";
  }
}

}  // namespace

// Walks the steps of the path, field by field; an element of a list goes by its name or number.
void apply_setting(proto::Scene& scene, const std::string& setting) {
  const auto fail = [&](const std::string& why) {
    throw Error(Exit::kBadInput, "bad_setting", fmt::format("--set {}: {}", setting, why));
  };
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos) fail("no '='; write name.path=value, as in bodies[ball].twist.linear.z=-20");
  pb::Message* at = &scene;
  std::istringstream steps(setting.substr(0, equals));
  std::string step, next;
  std::getline(steps, step, '.');
  while (true) {
    const bool more = static_cast<bool>(std::getline(steps, next, '.'));
    std::string element;
    if (const auto bracket = step.find('['); bracket != std::string::npos && step.back() == ']') {
      element = step.substr(bracket + 1, step.size() - bracket - 2);
      step.resize(bracket);
    }
    const auto* f = at->GetDescriptor()->FindFieldByName(step);
    if (!f) fail(unknown_field(step, *at->GetDescriptor()));
    const auto* r = at->GetReflection();
    if (!more) {
      if (f->is_repeated() || f->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE)
        fail(f->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE
                 ? fmt::format("'{0}' has fields: name one, as in {1}{2}.{3}", step, setting.substr(0, equals),
                               f->is_repeated() ? "[0]" : "", f->message_type()->field(0)->name())
                 : fmt::format("'{}' is a list, which a setting does not change; write it into the scene", step));
      const std::string value = setting.substr(equals + 1);
      const std::string literal = f->cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING ? "\"" + value + "\"" : value;
      r->ClearField(at, f);
      pb::TextFormat::Parser parser;
      struct Quiet : pb::io::ErrorCollector {
        void AddError(int, pb::io::ColumnNumber, const std::string&) override {}
      } quiet;
      parser.RecordErrorsTo(&quiet);
      if (!parser.ParseFieldValueFromString(literal, f, at))
        fail(f->enum_type() ? unknown_value(value, *f->enum_type()) : fmt::format("'{}' is no {}", value, kind_of(*f)));
      return;
    }
    if (f->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) fail("'" + step + "' has no fields of its own");
    if (!f->is_repeated()) {
      at = r->MutableMessage(at, f);
    } else {
      pb::Message* found = nullptr;
      std::vector<std::string> names;
      const bool number = !element.empty() && element.find_first_not_of("0123456789") == std::string::npos;
      for (int i = 0; i < r->FieldSize(*at, f); ++i) {
        pb::Message* candidate = r->MutableRepeatedMessage(at, f, i);
        names.push_back(name_of(*candidate));
        if (name_of(*candidate) == element || (number && std::to_string(i) == element)) found = candidate;
      }
      if (element.empty()) {
        const bool named = std::find(names.begin(), names.end(), next) != names.end();
        const bool counted = next.size() < 9 && next.find_first_not_of("0123456789") == std::string::npos &&
                             std::stoul(next) < names.size();
        const std::string which = named || counted ? next : names.empty() || names[0].empty() ? "0" : names[0];
        fail(fmt::format("'{0}' is a list; write {0}[{1}], by name or number from 0; it has {2}", step, which,
                         names.size()));
      }
      if (!found && f->message_type()->FindFieldByName("name"))
        fail(fmt::format("{}[{}] is not there; {}", step, element, did_you_mean(element, names)));
      if (!found) fail(fmt::format("{}[{}] is not there; it has {}, counted from 0", step, element, names.size()));
      at = found;
    }
    step = next;
  }
}

}  // namespace sunder::scene
