#include "coupler/scene/load.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include "coupler/core/hash.h"
#include "coupler/scene/names.h"
#include "coupler/scene/presets.h"

namespace sunder::scene {
namespace pb = google::protobuf;

struct LoadedScene::Places {
  pb::TextFormat::ParseInfoTree tree;
};
LoadedScene::LoadedScene() : places_(std::make_unique<Places>()) {}
LoadedScene::~LoadedScene() = default;
LoadedScene::LoadedScene(LoadedScene&&) noexcept = default;

namespace {

constexpr std::size_t kMaxSceneBytes = 64u << 20;

/// Ignores what the tokenizer says: the parser has said it already.
struct Quiet : pb::io::ErrorCollector {
  void AddError(int, pb::io::ColumnNumber, const std::string&) override {}
};

/// A word of the text, and the message type that it stands in; null where that is unknown.
struct Place {
  int line, column;  // from 0
  const pb::Descriptor* inside = nullptr;
};

/// The last place of `word` at or before an error that the parser reports. The parser names the token after the wrong
/// one, which may be on another line.
Place place_of(const std::string& word, const std::string& text, int line, int column) {
  struct Level {
    const pb::Descriptor* type;
    std::string field;  // whose message begins here: in a list the next one is of the same field
  };
  Quiet quiet;
  pb::io::ArrayInputStream in(text.data(), static_cast<int>(text.size()));
  pb::io::Tokenizer tokens(&in, &quiet);
  tokens.set_comment_style(pb::io::Tokenizer::SH_COMMENT_STYLE);
  std::vector<Level> levels{{proto::Scene::descriptor(), ""}};
  std::string name;
  Place place{line, column, nullptr};
  while (tokens.Next()) {
    const auto& token = tokens.current();
    if (token.line > line || (token.line == line && token.column > column)) break;
    if (token.text == word) place = {token.line, token.column, levels.back().type};
    if (token.type == pb::io::Tokenizer::TYPE_IDENTIFIER) name = token.text;
    if (token.text == "{" || token.text == "<") {
      const auto* field = levels.back().type ? levels.back().type->FindFieldByName(name) : nullptr;
      levels.push_back({field ? field->message_type() : nullptr, name});
    }
    if ((token.text == "}" || token.text == ">") && levels.size() > 1) {
      name = levels.back().field;
      levels.pop_back();
    }
  }
  return place;
}

/// The `number`-th text in double quotes of a parser's message, from 0; empty: there are fewer.
std::string quoted_part(const std::string& message, int number) {
  std::size_t begin = message.find('"');
  for (; number > 0 && begin != std::string::npos; --number)
    begin = message.find('"', message.find('"', begin + 1) + 1);
  const std::size_t end = begin == std::string::npos ? begin : message.find('"', begin + 1);
  return end == std::string::npos ? "" : message.substr(begin + 1, end - begin - 1);
}

/// Turns the parser's first error into an Error with file, line, column, field and remedy.
struct Collector : pb::io::ErrorCollector {
  const std::string &path, &text;
  Collector(const std::string& path, const std::string& text) : path(path), text(text) {}

  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    std::string field, problem = message + " see proto/scene.proto for fields and types";
    Place place{line, column, nullptr};
    if (message.find("Need space between number and identifier") != std::string::npos) {
      problem =
          "a number with a unit behind it; numbers are in SI units and have none: 4 mm are 0.004, 70 GPa are 70e9";
    } else if (message.find("has no field named") != std::string::npos) {
      const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(quoted_part(message, 0));
      field = quoted_part(message, 1);
      place = place_of(field, text, line, column);
      if (type) problem = unknown_field(field, *type);
    } else if (message.find("Unknown enumeration value") != std::string::npos) {
      const std::string value = quoted_part(message, 0);
      field = quoted_part(message, 1);
      place = place_of(value, text, line, column);
      const auto* f = place.inside ? place.inside->FindFieldByName(field) : nullptr;
      if (f && f->enum_type()) problem = field + ": " + unknown_value(value, *f->enum_type());
    }
    Error e(Exit::kBadInput, "bad_scene", fmt::format("{}:{}:{}: {}", path, place.line + 1, place.column + 1, problem));
    e.file = path, e.line = place.line + 1, e.column = place.column + 1, e.field = field;
    throw e;  // one error at a time: the others may follow from the first
  }
};

// A field's path without its indices and names in brackets.
std::string plain(const std::string& path) {
  std::string out;
  int depth = 0;
  for (const char c : path) {
    depth += c == '[';
    if (depth == 0) out += c;
    depth -= c == ']';
  }
  return out;
}

}  // namespace

void LoadedScene::fail(const std::string& field, const std::string& problem) const {
  // Follow the path as far as the file has it.
  const pb::TextFormat::ParseInfoTree* tree = &places_->tree;
  const pb::Descriptor* type = proto::Scene::descriptor();
  pb::TextFormat::ParseLocation place(-1, -1);
  std::istringstream steps(field);
  for (std::string step; tree && type && std::getline(steps, step, '.');) {
    int index = -1;
    if (const auto bracket = step.find('['); bracket != std::string::npos) {
      index = std::atoi(step.c_str() + bracket + 1);
      step.resize(bracket);
    }
    const auto* f = type->FindFieldByName(step);
    if (!f) break;
    const auto here = tree->GetLocation(f, f->is_repeated() ? std::max(index, 0) : -1);
    if (here.line >= 0) place = here;
    type = f->message_type();
    tree = type ? tree->GetTreeForNested(f, f->is_repeated() ? std::max(index, 0) : -1) : nullptr;
  }
  std::string source = problem;
  for (const std::string& setting : settings)  // the value may come from the command line, not from the file
    if (plain(setting.substr(0, setting.find('='))).rfind(plain(field), 0) == 0 ||
        plain(field).rfind(plain(setting.substr(0, setting.find('='))), 0) == 0)
      source += fmt::format(" (set by --set {})", setting);
  Error e(Exit::kBadInput, "bad_scene",
          place.line >= 0 ? fmt::format("{}:{}:{}: {}: {}", path, place.line + 1, place.column + 1, field, source)
                          : fmt::format("{}: {}: {}", path, field, source));
  e.file = path, e.field = field, e.line = place.line + 1, e.column = place.column + 1;
  throw e;
}

std::string LoadedScene::file_beside(const std::string& field, const std::string& name) const {
  namespace fs = std::filesystem;
  const fs::path folder = fs::weakly_canonical(fs::absolute(path)).parent_path();
  const fs::path file = fs::weakly_canonical(folder / name);
  const auto [end, unused] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  check(end == folder.end(), field, "'{}' lies outside the scene's folder; put the file beside the scene", name);
  check(fs::is_regular_file(file) && std::ifstream(file).good(), field, "'{}' cannot be read; is the name right?",
        name);
  return file;
}

namespace {

// Refuses numbers that are no value of their enum: the parser accepts any number there.
void check_enumerators(const LoadedScene& scene, const pb::Message& m, const std::string& inside) {
  const pb::Reflection& r = *m.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  r.ListFields(m, &fields);
  for (const pb::FieldDescriptor* f : fields) {
    const int count = f->is_repeated() ? r.FieldSize(m, f) : 1;
    for (int i = 0; i < count; ++i) {
      std::string field = inside.empty() ? f->name() : inside + "." + f->name();
      if (f->is_repeated()) field += fmt::format("[{}]", i);
      if (f->cpp_type() == pb::FieldDescriptor::CPPTYPE_ENUM) {
        const int value = f->is_repeated() ? r.GetRepeatedEnumValue(m, f, i) : r.GetEnumValue(m, f);
        if (f->enum_type()->FindValueByNumber(value) == nullptr)
          scene.fail(field, fmt::format("is {}; {}", value, one_of(*f->enum_type())));
      }
      if (f->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE)
        check_enumerators(scene, f->is_repeated() ? r.GetRepeatedMessage(m, f, i) : r.GetMessage(m, f), field);
    }
  }
}

// Adds the contents of all files that a message names: a scene with another image or mesh has another hash.
void add_files(const pb::Message& m, const std::filesystem::path& folder, Sha256& hash) {
  namespace fs = std::filesystem;
  std::error_code none;
  const pb::Reflection& r = *m.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  r.ListFields(m, &fields);
  for (const pb::FieldDescriptor* f : fields) {
    if (f->cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING && !f->is_repeated() && f->name() == "path") {
      const fs::path file = fs::weakly_canonical(folder / r.GetString(m, f), none);
      const bool beside = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
      if (beside && fs::is_regular_file(file, none)) {  // otherwise validation refuses it
        std::ifstream in(file, std::ios::binary);
        for (std::string part(1 << 16, '\0'); in.read(part.data(), part.size()) || in.gcount() > 0;)
          hash.add(part.data(), static_cast<std::size_t>(in.gcount()));
      }
    }
    if (f->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const int count = f->is_repeated() ? r.FieldSize(m, f) : 1;
    for (int i = 0; i < count; ++i)
      add_files(f->is_repeated() ? r.GetRepeatedMessage(m, f, i) : r.GetMessage(m, f), folder, hash);
  }
}

}  // namespace

LoadedScene load(const std::string& path, const std::vector<std::string>& settings) {
  LoadedScene scene;
  scene.path = path;
  std::ifstream in(path, std::ios::binary);
  require(in.good(), "{}: cannot be read; is the path right?", path);
  std::stringstream text;
  text << in.rdbuf();
  const std::string content = text.str();
  require(content.size() <= kMaxSceneBytes, "{}: {} bytes; a scene has at most {}", path, content.size(),
          kMaxSceneBytes);
  Collector collector(path, content);
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&scene.places_->tree);
  require(parser.ParseFromString(content, &scene.message), "{}: is no scene", path);
  scene.settings = settings;
  for (const std::string& setting : settings) apply_setting(scene.message, setting);
  check_enumerators(scene, scene.message, "");
  fill_presets(scene.message);  // their values belong to the hash
  pb::TextFormat::PrintToString(scene.message, &scene.text);
  Sha256 hash;
  hash.add(scene.text);
  add_files(scene.message, std::filesystem::weakly_canonical(std::filesystem::absolute(path)).parent_path(), hash);
  scene.hash = hash.hex();
  validate(scene);
  return scene;
}

}  // namespace sunder::scene
