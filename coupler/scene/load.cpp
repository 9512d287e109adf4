#include "coupler/scene/load.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "coupler/core/hash.h"

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

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row.back();
}

// 'Message type "sunder.proto.Shell" has no field named "thicknes_m".' -> the nearest one that it has
std::string remedy(const std::string& message) {
  const auto quoted = [&](std::size_t from) {
    const std::size_t a = message.find('"', from), b = message.find('"', a + 1);
    return a == std::string::npos || b == std::string::npos ? std::string() : message.substr(a + 1, b - a - 1);
  };
  if (message.find("has no field named") == std::string::npos) return "see proto/scene.proto for fields and types";
  const auto* type = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(quoted(0));
  const std::string name = quoted(message.find("named"));
  std::string best, all;
  for (int i = 0; type && i < type->field_count(); ++i) {
    const std::string candidate = type->field(i)->name();
    all += (i ? ", " : "") + candidate;
    if (best.empty() || edit_distance(name, candidate) < edit_distance(name, best)) best = candidate;
  }
  return "did you mean '" + best + "'? It has: " + all;
}

struct Collector : pb::io::ErrorCollector {
  const std::string& path;
  explicit Collector(const std::string& path) : path(path) {}
  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    Error e(Exit::kBadInput, "bad_scene",
            fmt::format("{}:{}:{}: {} {}", path, line + 1, column + 1, message, remedy(message)));
    e.file = path, e.line = line + 1, e.column = column + 1;
    const std::size_t at = message.find("named \"");
    if (at != std::string::npos) e.field = message.substr(at + 7, message.rfind('"') - at - 7);
    throw e;  // the first error is the one to mend
  }
};

// A field's path without its indices or names.
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
  // walk the field as far as the file has it
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
  for (const std::string& setting : settings)  // the file is right then: the command says so
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

std::string names_of(const pb::EnumDescriptor& type) {
  std::string names;
  for (int k = 0, last = type.value_count() - 1; k <= last; ++k)
    if (!type.value(k)->name().ends_with("UNSPECIFIED"))
      names += (names.empty() ? "" : k == last ? " or " : ", ") + type.value(k)->name();
  return names;
}

// A number in the place of an enumerator's name is accepted by the parser, whatever it is.
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
          scene.fail(field, fmt::format("is {}; {}", value, names_of(*f->enum_type())));
      }
      if (f->cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE)
        check_enumerators(scene, f->is_repeated() ? r.GetRepeatedMessage(m, f, i) : r.GetMessage(m, f), field);
    }
  }
}

// Adds what is in the files that a message names, each beside the scene: with another image or mesh it is another
// scene.
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
      if (beside && fs::is_regular_file(file, none)) {  // else it is refused where it is used
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
  require(text.str().size() <= kMaxSceneBytes, "{}: {} bytes; a scene has at most {}", path, text.str().size(),
          kMaxSceneBytes);
  Collector collector(path);
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&scene.places_->tree);
  require(parser.ParseFromString(text.str(), &scene.message), "{}: is no scene", path);
  scene.settings = settings;
  for (const std::string& setting : settings) apply_setting(scene.message, setting);
  std::string canonical;
  pb::TextFormat::PrintToString(scene.message, &canonical);
  Sha256 hash;
  hash.add(canonical);
  add_files(scene.message, std::filesystem::weakly_canonical(std::filesystem::absolute(path)).parent_path(), hash);
  scene.hash = hash.hex();
  check_enumerators(scene, scene.message, "");
  validate(scene);
  return scene;
}

}  // namespace sunder::scene
