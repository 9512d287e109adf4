// Reads PLY files: a header in text, then elements with properties, in text or in binary.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  bool is_list = false;
  Type count = Type::kUint8, value = Type::kFloat;
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

class Ply {
 public:
  explicit Ply(MeshFile& mesh) : mesh_(mesh), in_(mesh.file, std::ios::binary) {}

  void read() {
    mesh_.place = "number";
    header();
    for (const Element& e : elements_)
      for (std::size_t i = 0; i < e.count; ++i) {
        place_ = fmt::format("{} {}", e.name, i);
        if (e.name == "vertex")
          vertex(e);
        else
          other(e, e.name == "face" && mesh_.with_faces, static_cast<int>(i) + 1);
      }
  }

 private:
  Type type(const std::string& word) {
    static constexpr std::array<std::array<const char*, 2>, 8> names{{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
    for (std::size_t k = 0; k < names.size(); ++k)
      if (word == names[k][0] || word == names[k][1]) return static_cast<Type>(k);
    mesh_.fail(fmt::format("has a property of type '{}' in its header, which PLY files do not have", word));
  }

  void header() {
    std::string line, word, format;
    bool ended = false;
    for (int number = 1; !ended && std::getline(in_, line); ++number) {
      std::istringstream words(line);
      words >> word;
      if (number == 1 && word != "ply") break;
      if (word == "format") words >> format;
      if (word == "element") {
        Element e;
        if (!(words >> e.name >> e.count))
          mesh_.fail_at(fmt::format("line {}", number), fmt::format("'{}' is no element", line));
        elements_.push_back(std::move(e));
      }
      if (word == "property") {
        Property p;
        std::string name, count;
        words >> name;
        p.is_list = name == "list";
        if (p.is_list && words >> count >> name) p.count = type(count);
        p.value = type(name);
        if (elements_.empty() || !(words >> p.name))
          mesh_.fail_at(fmt::format("line {}", number), fmt::format("'{}' is no property", line));
        elements_.back().properties.push_back(std::move(p));
      }
      ended = word == "end_header";
    }
    is_text_ = format == "ascii", swapped_ = format == "binary_big_endian";
    if (!ended || (!is_text_ && !swapped_ && format != "binary_little_endian"))
      mesh_.fail(
          "does not start as a PLY file does: the word ply, a format (ascii, binary_little_endian or "
          "binary_big_endian), elements, end_header");
    for (const Element& e : elements_)
      if (e.properties.empty()) mesh_.fail(fmt::format("has an element '{}' without a property in its header", e.name));
    if (std::none_of(elements_.begin(), elements_.end(), [](const Element& e) { return e.name == "vertex"; }))
      mesh_.fail("has no element 'vertex' in its header; export a mesh");
  }

  template <class T>
  double binary() {
    std::array<char, sizeof(T)> bytes{};
    in_.read(bytes.data(), bytes.size());
    if (swapped_) std::reverse(bytes.begin(), bytes.end());
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  static constexpr std::array<const char*, 3> kColours{"red", "green", "blue"};
  // The number of a full colour.
  static double full(Type t) {
    return t == Type::kUint8 || t == Type::kInt8 ? 255.0 : t == Type::kUint16 || t == Type::kInt16 ? 65535.0 : 1.0;
  }

  double number(Type t) {
    double x = 0.0;
    if (is_text_) {
      in_ >> x;
    } else {
      switch (t) {
        case Type::kInt8:
          x = binary<std::int8_t>();
          break;
        case Type::kUint8:
          x = binary<std::uint8_t>();
          break;
        case Type::kInt16:
          x = binary<std::int16_t>();
          break;
        case Type::kUint16:
          x = binary<std::uint16_t>();
          break;
        case Type::kInt32:
          x = binary<std::int32_t>();
          break;
        case Type::kUint32:
          x = binary<std::uint32_t>();
          break;
        case Type::kFloat:
          x = binary<float>();
          break;
        case Type::kDouble:
          x = binary<double>();
          break;
      }
    }
    if (!in_) mesh_.fail(fmt::format("ends, or has no number, in {} (counted from 0); is the copy whole?", place_));
    return x;
  }

  // Reads the numbers of a property into values_.
  void values(const Property& p) {
    values_.clear();
    const double count = p.is_list ? number(p.count) : 1.0;
    if (!(count >= 0.0 && count <= static_cast<double>(kMostPoints) && count == std::floor(count)))
      mesh_.fail_at(place_, fmt::format("it has a list of {} numbers; elements count from 0", count));
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) values_.push_back(number(p.value));
  }

  void vertex(const Element& e) {
    Vec3 point = Vec3::Constant(std::nan(""));  // refused where a coordinate is missing
    Vec3 rgb = point;
    for (const Property& p : e.properties) {
      values(p);
      for (int d = 0; d < 3; ++d)
        if (p.name == std::string(1, "xyz"[d]) && !values_.empty()) point[d] = values_[0];
      for (int d = 0; d < 3; ++d)
        if (p.name == kColours[d] && !values_.empty()) rgb[d] = values_[0] / full(p.value);
    }
    mesh_.add(point, place_);
    if (rgb.allFinite()) mesh_.colour(rgb);
  }

  void other(const Element& e, bool is_face, int ordinal) {
    Polygon polygon{{}, ordinal};
    for (const Property& p : e.properties) {
      values(p);
      if (!is_face || (p.name != "vertex_indices" && p.name != "vertex_index")) continue;
      for (const double v : values_) {
        if (!(v >= 0.0 && v < static_cast<double>(kMostPoints) && v == std::floor(v)))
          mesh_.fail_at(place_, fmt::format("it names point {}; elements count from 0", v));
        polygon.corners.push_back(static_cast<int>(v));
      }
    }
    if (is_face) mesh_.polygons.push_back(std::move(polygon));
  }

  MeshFile& mesh_;
  std::ifstream in_;
  std::vector<Element> elements_;
  bool is_text_ = false, swapped_ = false;
  std::string place_;
  std::vector<double> values_;
};

}  // namespace

void read_ply(MeshFile& mesh) { Ply(mesh).read(); }

}  // namespace sunder::scene
