// --set: one field of a scene by name.
#include <sstream>

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "coupler/scene/load.h"

namespace sunder::scene {
namespace pb = google::protobuf;
namespace {

std::string name_of(const pb::Message& m) {
  const auto* f = m.GetDescriptor()->FindFieldByName("name");
  return f ? m.GetReflection()->GetString(m, f) : std::string();
}

}  // namespace

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
    if (!f) {
      std::string has;
      for (int i = 0; i < at->GetDescriptor()->field_count(); ++i)
        has += (i ? ", " : "") + at->GetDescriptor()->field(i)->name();
      fail(fmt::format("'{}' is no field of {}; it has: {}", step, at->GetDescriptor()->name(), has));
    }
    const auto* r = at->GetReflection();
    if (!more) {
      if (f->is_repeated() || f->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE)
        fail("'" + step + "' is not a single value");
      const std::string value = setting.substr(equals + 1);
      const std::string literal = f->cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING ? "\"" + value + "\"" : value;
      r->ClearField(at, f);
      pb::TextFormat::Parser parser;
      struct Quiet : pb::io::ErrorCollector {
        void AddError(int, pb::io::ColumnNumber, const std::string&) override {}
      } quiet;
      parser.RecordErrorsTo(&quiet);
      if (!parser.ParseFieldValueFromString(literal, f, at))
        fail(fmt::format("'{}' is no {}", value, f->cpp_type_name()));
      return;
    }
    if (f->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) fail("'" + step + "' has no fields of its own");
    if (!f->is_repeated()) {
      at = r->MutableMessage(at, f);
    } else {
      pb::Message* found = nullptr;
      std::string has;
      const bool number = !element.empty() && element.find_first_not_of("0123456789") == std::string::npos;
      for (int i = 0; i < r->FieldSize(*at, f); ++i) {
        pb::Message* candidate = r->MutableRepeatedMessage(at, f, i);
        has += (i ? ", " : "") + name_of(*candidate);
        if (name_of(*candidate) == element || (number && std::to_string(i) == element)) found = candidate;
      }
      if (!found) fail(fmt::format("{}[{}] is not there; there are: {}", step, element, has));
      at = found;
    }
    step = next;
  }
}

}  // namespace sunder::scene
