// Reads glTF 2.0 files, text (.gltf) and binary (.glb): triangles of all meshes of the scene, where its nodes put them.
// A glTF file is JSON beside arrays of numbers, and all that shells need of it is in its core. So no library is used:
// compressed arrays, which are extensions, are refused by name.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "coupler/scene/gltf_uri.h"
#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

using Json = nlohmann::json;

constexpr std::uint32_t kGlb = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of a file, and of all buffers together
constexpr std::size_t kMostNodes = 100000;                // that are visited
// Triangles of all nodes, counted again for each node that shows them: those that are kept, and with those that have
// two corners in one place, of which a strip has some.
constexpr std::size_t kMostKept = kMostSurfaceTriangles, kMostSeen = 10 * kMostKept;
// Extensions that a file may require: those that are read (integers as positions, moved textures), and those that
// change what shells do not look at, as kinds of pictures.
constexpr std::array<const char*, 7> kFit = {"KHR_mesh_quantization", "KHR_texture_transform", "KHR_texture_basisu",
                                             "EXT_texture_",          "KHR_materials_",        "KHR_lights_",
                                             "KHR_animation_"};

// Which texture coordinates the picture of a material takes, and where its extension KHR_texture_transform puts them.
struct GltfPicture {
  std::size_t set = 0;
  Eigen::Affine2d place = Eigen::Affine2d::Identity();
};

class Gltf {
 public:
  explicit Gltf(MeshFile& mesh) : mesh_(mesh) {}

  void read() {
    mesh_.place = "triangle";
    const std::uintmax_t size = std::filesystem::file_size(mesh_.file);
    if (size > kMostBytes) mesh_.fail(fmt::format("has {} bytes, at most {} are read; {}", size, kMostBytes, kReduce));
    std::string text = gltf_bytes(mesh_.file);
    if (word(text, 0) == kGlb && text.size() >= 12) text = chunks_of(text);
    root_ = Json::parse(text, nullptr, false);
    if (root_.is_discarded() || !root_.is_object())
      mesh_.fail("is no glTF file: its text is no JSON; export it again, as .glb");
    const std::string version = root_.value("/asset/version"_json_pointer, Json("")).is_string()
                                    ? root_.value("/asset/version"_json_pointer, std::string())
                                    : std::string();
    if (version.rfind("2.", 0) != 0)
      mesh_.fail(fmt::format("has asset.version '{}'; glTF 2.0 is read: export it as that", version));
    check_extensions();
    for (const auto& [node, matrix] : roots()) visit(node, matrix);
    if (mesh_.points.empty()) mesh_.fail("has no mesh in its scene; export one");
  }

 private:
  static std::uint32_t word(const std::string& bytes, std::size_t at) {
    std::uint32_t out = 0;
    if (at + 4 <= bytes.size()) std::memcpy(&out, bytes.data() + at, 4);
    return out;
  }

  // The JSON of a binary file; keeps its other chunk.
  std::string chunks_of(const std::string& bytes) {
    if (word(bytes, 4) != 2) mesh_.fail(fmt::format("is glTF {}; glTF 2.0 is read: export it as that", word(bytes, 4)));
    if (word(bytes, 8) != bytes.size())
      mesh_.fail(
          fmt::format("says that it has {} bytes, and has {}; is the copy whole?", word(bytes, 8), bytes.size()));
    std::string json;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
      const std::uint32_t length = word(bytes, at), kind = word(bytes, at + 4);
      if (length > bytes.size() - at - 8) mesh_.fail("has a chunk that goes on beyond its end; is the copy whole?");
      if (kind == kJsonChunk && json.empty()) json = bytes.substr(at + 8, length);
      if (kind == kBinaryChunk && !has_binary_) binary_ = bytes.substr(at + 8, length), has_binary_ = true;
      at += 8 + static_cast<std::size_t>(length);
    }
    if (json.empty()) mesh_.fail("has no chunk of JSON; export it again");
    return json;
  }

  void check_extensions() {
    if (!root_.contains("extensionsRequired")) return;
    for (const Json& name : list("extensionsRequired")) {
      const std::string own = name.is_string() ? name.get<std::string>() : name.dump();
      if (std::none_of(kFit.begin(), kFit.end(), [&](const char* h) { return own.rfind(h, 0) == 0; }))
        mesh_.fail(fmt::format(
            "needs the extension {}, which is not read; export it without {}", own,
            own.find("draco") != std::string::npos || own.find("meshopt") != std::string::npos ? "compression" : "it"));
    }
  }

  // A list of the root, empty where it is missing.
  const Json& list(const char* name) const {
    static const Json empty = Json::array();
    const auto found = root_.find(name);
    if (found == root_.end()) return empty;
    if (!found->is_array()) mesh_.fail(fmt::format("has a '{}' that is no list; export it again", name));
    return *found;
  }
  // Element `index` of a list of the root; `of` says what names it.
  const Json& element(const char* name, std::size_t index, const std::string& of) const {
    const Json& all = list(name);
    if (index >= all.size() || !all[index].is_object())
      mesh_.fail(
          fmt::format("has {}[{}] named by {}, and has {} of them; export it again", name, index, of, all.size()));
    return all[index];
  }
  // A whole number that is not negative.
  std::size_t number(const Json& from, const char* name, const std::string& of, std::size_t otherwise) const {
    const auto found = from.find(name);
    if (found == from.end()) return otherwise;
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() > kMostBytes)
      mesh_.fail(fmt::format("has {}.{} of {}, which is no such number; export it again", of, name, found->dump()));
    return found->get<std::size_t>();
  }
  static constexpr std::size_t kMissing = static_cast<std::size_t>(-1);
  std::size_t needed(const Json& from, const char* name, const std::string& of) const {
    const std::size_t out = number(from, name, of, kMissing);
    if (out == kMissing) mesh_.fail(fmt::format("has no {}.{}; export it again", of, name));
    return out;
  }
  static std::string name_of(const Json& from, const std::string& otherwise) {
    const auto found = from.find("name");
    return found != from.end() && found->is_string() && !found->get<std::string>().empty() ? found->get<std::string>()
                                                                                           : otherwise;
  }

  // Nodes of the scene; those without a parent where there is none.
  std::vector<std::pair<std::size_t, Eigen::Affine3d>> roots() const {
    std::vector<std::pair<std::size_t, Eigen::Affine3d>> out;
    const Json& scenes = list("scenes");
    if (!scenes.empty()) {
      const Json& scene = element("scenes", number(root_, "scene", "the file", 0), "scene");
      for (const std::size_t node : indices(scene, "nodes", "scenes"))
        out.emplace_back(node, Eigen::Affine3d::Identity());
      return out;
    }
    const Json& nodes = list("nodes");
    std::vector<char> child(nodes.size(), 0);
    for (const Json& node : nodes)
      for (const std::size_t k : indices(node, "children", "nodes"))
        if (k < child.size()) child[k] = 1;
    for (std::size_t k = 0; k < child.size(); ++k)
      if (child[k] == 0) out.emplace_back(k, Eigen::Affine3d::Identity());
    return out;
  }
  std::vector<std::size_t> indices(const Json& from, const char* name, const std::string& of) const {
    std::vector<std::size_t> out;
    const auto found = from.is_object() ? from.find(name) : from.end();
    if (!from.is_object() || found == from.end()) return out;
    for (const Json& k : *found) {
      if (!k.is_number_unsigned()) mesh_.fail(fmt::format("has {}.{} of {}; export it again", of, name, k.dump()));
      out.push_back(k.get<std::size_t>());
    }
    return out;
  }

  std::vector<double> numbers(const Json& from, const char* name, std::size_t count, const std::string& of) const {
    const auto found = from.find(name);
    if (found == from.end()) return {};
    std::vector<double> out;
    for (const Json& x : *found)
      if (x.is_number()) out.push_back(x.get<double>());
    if (out.size() != count || found->size() != count ||
        std::any_of(out.begin(), out.end(), [](double x) { return !std::isfinite(x); }))
      mesh_.fail(fmt::format("has {}.{} that are not {} numbers; export it again", of, name, count));
    return out;
  }

  Eigen::Affine3d placed(const Json& node, const std::string& of) const {
    Eigen::Affine3d out = Eigen::Affine3d::Identity();
    if (const auto m = numbers(node, "matrix", 16, of); !m.empty()) {
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r) out(r, c) = m[4 * c + r];
      return out;
    }
    if (const auto t = numbers(node, "translation", 3, of); !t.empty()) out.translate(Vec3(t[0], t[1], t[2]));
    if (const auto q = numbers(node, "rotation", 4, of); !q.empty()) {
      const Quat turn(q[3], q[0], q[1], q[2]);
      if (std::abs(turn.norm() - 1.0) > 1e-3)
        mesh_.fail(fmt::format("has {}.rotation of length {:.4g}; 1", of, turn.norm()));
      out.rotate(turn.normalized());
    }
    if (const auto s = numbers(node, "scale", 3, of); !s.empty()) out.scale(Vec3(s[0], s[1], s[2]));
    return out;
  }

  void visit(std::size_t index, const Eigen::Affine3d& parent) {
    const std::string of = fmt::format("nodes[{}]", index);
    if (++visited_ > kMostNodes || path_.size() > 1000)
      mesh_.fail(fmt::format("has more than {} nodes, or nodes that have themselves as children; export it again",
                             kMostNodes));
    const Json& node = element("nodes", index, "a parent or the scene");
    const Eigen::Affine3d here = parent * placed(node, of);
    path_.push_back(name_of(node, ""));
    if (const std::size_t mesh = number(node, "mesh", of, kMissing); mesh != kMissing) {
      if (node.contains("skin"))  // its points are where the joints put them, not its node
        mesh_.fail(
            fmt::format("has a mesh with a skin at '{}', so an armature says where its points are; apply the "
                        "armature and export it again",
                        name_of(node, of)));
      add_mesh(mesh, here);
    }
    for (const std::size_t child : indices(node, "children", of)) visit(child, here);
    path_.pop_back();
  }

  void add_mesh(std::size_t index, const Eigen::Affine3d& here) {
    const std::string of = fmt::format("meshes[{}]", index);
    const Json& mesh = element("meshes", index, "a node");
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array()) mesh_.fail(fmt::format("has no {}.primitives", of));
    std::vector<std::string> groups;
    for (const std::string& name : path_)
      if (!name.empty()) groups.push_back(name);
    const std::string own = name_of(mesh, "");
    if (!own.empty() && std::find(groups.begin(), groups.end(), own) == groups.end()) groups.push_back(own);
    for (std::size_t k = 0; k < primitives->size(); ++k)
      add_primitive((*primitives)[k], fmt::format("{}.primitives[{}]", of, k), groups, here);
  }

  void add_primitive(const Json& primitive, const std::string& of, const std::vector<std::string>& groups,
                     const Eigen::Affine3d& here) {
    bound(++seen_, kMostSeen);
    const std::size_t mode = primitive.is_object() ? number(primitive, "mode", of, 4) : 7;
    if (mode > 6) mesh_.fail(fmt::format("has {} of a kind that is none; export it again", of));
    if (mode < 4) return;  // points and lines
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object() || !attributes->contains("POSITION")) return;
    const auto first = static_cast<int>(mesh_.points.size());
    const Array at = array(needed(*attributes, "POSITION", of), of, 3);
    for (std::size_t k = 0; k < at.count; ++k) {
      const Vec3 x = here * Vec3(at.values[3 * k], at.values[3 * k + 1], at.values[3 * k + 2]);
      mesh_.add(Vec3(x.x(), -x.z(), x.y()), fmt::format("point {} of {}", k, of));  // y is up in the file
    }
    if (const std::size_t colour = number(*attributes, "COLOR_0", of, kMissing); colour != kMissing)
      add_colours(array(colour, of, 0), first, of);
    if (!mesh_.with_faces) return;
    FaceTag tag{groups, {}};
    GltfPicture picture;
    if (const std::size_t k = number(primitive, "material", of, kMissing); k != kMissing) {
      const Json& material = element("materials", k, of);
      tag.usemtl = name_of(material, fmt::format("material_{}", k));
      if (mesh_.with_texture) picture = picture_of(material, fmt::format("materials[{}]", k));
    }
    const std::string coordinates = fmt::format("TEXCOORD_{}", picture.set);
    const std::size_t texture = mesh_.with_texture ? number(*attributes, coordinates.c_str(), of, kMissing) : kMissing;
    if (texture != kMissing)
      add_texture(array(texture, of, 2), picture.place, at.count, fmt::format("{} in {}", coordinates, of));
    else if (picture.set > 0)
      mesh_.fail(fmt::format("has no {} in {}, which the picture of its material '{}' takes; export it again",
                             coordinates, of, tag.usemtl));
    const int texture_first = texture == kMissing ? 0 : static_cast<int>(mesh_.texture.size() - at.count) - first;
    std::vector<std::size_t> corner(at.count);
    for (std::size_t k = 0; k < at.count; ++k) corner[k] = k;
    if (const std::size_t index = number(primitive, "indices", of, kMissing); index != kMissing) {
      check_indices(element("accessors", index, of), fmt::format("accessors[{}]", index));
      const Array list = array(index, of, 1);
      corner.assign(list.values.begin(), list.values.end());
    }
    for (const std::size_t c : corner)
      if (c >= at.count)
        mesh_.fail(fmt::format("has corner {} in {}, which has {} points; export it again", c, of, at.count));
    const bool mirrored = here.linear().determinant() < 0.0;
    const std::size_t faces = mode == 4 ? corner.size() / 3 : corner.size() < 3 ? 0 : corner.size() - 2;
    bound(seen_ += faces, kMostSeen);
    for (std::size_t k = 0; k < faces; ++k) {
      std::array<std::size_t, 3> c = mode == 4   ? std::array{3 * k, 3 * k + 1, 3 * k + 2}
                                     : mode == 5 ? std::array{k, k + 1 + k % 2, k + 2 - k % 2}
                                                 : std::array{std::size_t{0}, k + 1, k + 2};
      const std::array<std::size_t, 3> p{corner[c[0]], corner[c[1]], corner[c[2]]};
      if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) continue;  // strips turn by such
      Polygon polygon{{}, static_cast<int>(mesh_.polygons.size()) + 1, number_of(tag)};
      for (const std::size_t i : {p[0], mirrored ? p[2] : p[1], mirrored ? p[1] : p[2]})
        polygon.corners.push_back(first + static_cast<int>(i));
      if (texture != kMissing)
        for (const int c : polygon.corners) polygon.texture.push_back(c + texture_first);
      mesh_.polygons.push_back(std::move(polygon));
      bound(mesh_.polygons.size(), kMostKept);
    }
  }

  void bound(std::size_t triangles, std::size_t most) const {
    if (triangles > most)
      mesh_.fail(
          fmt::format("has more than {} triangles, counted again for each node that shows them; {}", most, kReduce));
  }

  int number_of(const FaceTag& tag) {
    const auto [known, is_new] = tags_.try_emplace({tag.groups, tag.usemtl}, static_cast<int>(mesh_.tags.size()));
    if (is_new) mesh_.tags.push_back(tag);
    return known->second;
  }

  // An accessor as numbers, [element][component].
  struct Array {
    std::vector<double> values;
    std::size_t count = 0, components = 0;
  };

  void add_colours(const Array& colours, int first, const std::string& of) {
    if (colours.components < 3 || first + colours.count != mesh_.points.size())
      mesh_.fail(fmt::format("has COLOR_0 in {} that are no colours of its points; export it again", of));
    mesh_.colours.resize(mesh_.points.size(), Vec3::Constant(std::nan("")));
    for (std::size_t k = 0; k < colours.count; ++k) {
      const double* rgb = &colours.values[colours.components * k];
      mesh_.colours[first + k] = Vec3(rgb[0], rgb[1], rgb[2]);
    }
  }

  // Frames have one texture, so the picture is that of the base colour. Its v goes down: a turn to the left in the
  // picture is x' = x cos + y sin.
  GltfPicture picture_of(const Json& material, const std::string& of) const {
    const Json none = Json::object();
    const Json texture = material.value("pbrMetallicRoughness", none).value("baseColorTexture", none);
    const Json moved = texture.value("extensions", none).value("KHR_texture_transform", none);
    GltfPicture out;
    out.set = number(moved, "texCoord", of, number(texture, "texCoord", of, 0));
    if (const auto t = numbers(moved, "offset", 2, of); !t.empty()) out.place.translate(Vec2(t[0], t[1]));
    if (const auto angle = moved.find("rotation"); angle != moved.end()) {
      if (!angle->is_number())
        mesh_.fail(fmt::format("has a KHR_texture_transform.rotation of {} in {}, which is no angle; export it again",
                               angle->dump(), of));
      out.place.rotate(-angle->get<double>());
    }
    if (const auto s = numbers(moved, "scale", 2, of); !s.empty()) out.place.scale(Vec2(s[0], s[1]));
    return out;
  }

  // One for each point; the file's v goes down, and that of a MeshFile goes up as in an OBJ file.
  void add_texture(const Array& texture, const Eigen::Affine2d& place, std::size_t points, const std::string& of) {
    bool good = texture.count == points;
    for (std::size_t k = 0; k < texture.count; ++k) {
      const Vec2 uv = place * Vec2(texture.values[2 * k], texture.values[2 * k + 1]);
      good = good && uv.allFinite();
      mesh_.texture.emplace_back(uv.x(), 1.0 - uv.y());
    }
    if (!good)
      mesh_.fail("has " + of + " that are no texture coordinates of its points; export it again, or without them");
  }

  // `components`: how many the accessor must have; 0: any.
  Array array(std::size_t index, const std::string& of, std::size_t components) {
    const Json& a = element("accessors", index, of);
    const std::string own = fmt::format("accessors[{}]", index);
    static const std::map<std::string, std::size_t> kTypes = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    const auto kind = a.find("type");
    const auto known = kind != a.end() && kind->is_string() ? kTypes.find(kind->get<std::string>()) : kTypes.end();
    Array out;
    out.components = known == kTypes.end() ? 0 : known->second;
    if (out.components == 0 || (components != 0 && components != out.components))
      mesh_.fail(fmt::format("has {} of a type that does not fit {}; export it again", own, of));
    out.count = needed(a, "count", own);
    if (out.count > 3 * kMostPoints) mesh_.fail(fmt::format("has {} numbers in {}; {}", out.count, own, kReduce));
    const auto normalized = a.find("normalized");
    const bool share = normalized != a.end() && normalized->is_boolean() && normalized->get<bool>();
    const std::size_t type = needed(a, "componentType", own);
    if (const std::size_t view = number(a, "bufferView", own, kMissing); view != kMissing)
      out.values = numbers_in(view, number(a, "byteOffset", own, 0), type, share, out.count, out.components, own);
    else
      out.values.assign(out.count * out.components, 0.0);
    if (const auto sparse = a.find("sparse"); sparse != a.end()) replace(*sparse, type, share, own + ".sparse", out);
    return out;
  }

  // Indices are whole numbers without a sign: the conversion of all others to an index is undefined, or loses a part.
  void check_indices(const Json& from, const std::string& own) const {
    const std::size_t type = needed(from, "componentType", own);
    if (type != 5121 && type != 5123 && type != 5125)
      mesh_.fail(
          fmt::format("has {}.componentType of {}, and indices are of 5121, 5123 or 5125; export it again", own, type));
    if (const auto share = from.find("normalized"); share != from.end() && *share != false)
      mesh_.fail(fmt::format("has {} with indices that are normalized; export it again", own));
  }

  // Puts in the elements that differ.
  void replace(const Json& sparse, std::size_t type, bool share, const std::string& own, Array& out) {
    const auto where = sparse.is_object() ? sparse.find("indices") : sparse.end();
    const auto what = sparse.is_object() ? sparse.find("values") : sparse.end();
    if (!sparse.is_object() || where == sparse.end() || what == sparse.end() || !where->is_object() ||
        !what->is_object())
      mesh_.fail(fmt::format("has {} without indices or values; export it again", own));
    const std::size_t count = needed(sparse, "count", own);
    if (count > out.count) mesh_.fail(fmt::format("has {} elements in {}, more than there are", count, own));
    check_indices(*where, own + ".indices");
    const std::vector<double> at = numbers_in(needed(*where, "bufferView", own), number(*where, "byteOffset", own, 0),
                                              needed(*where, "componentType", own), false, count, 1, own);
    const std::vector<double> values = numbers_in(needed(*what, "bufferView", own), number(*what, "byteOffset", own, 0),
                                                  type, share, count, out.components, own);
    for (std::size_t k = 0; k < count; ++k) {
      if (!(at[k] >= 0.0 && at[k] < static_cast<double>(out.count)))
        mesh_.fail(fmt::format("has element {} in {}, which is none; export it again", at[k], own));
      for (std::size_t c = 0; c < out.components; ++c)
        out.values[static_cast<std::size_t>(at[k]) * out.components + c] = values[k * out.components + c];
    }
  }

  template <class T>
  static void decode(const char* from, std::size_t stride, std::size_t count, std::size_t components, bool share,
                     std::vector<double>& out) {
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t c = 0; c < components; ++c) {
        T value;
        std::memcpy(&value, from + k * stride + c * sizeof(T), sizeof(T));
        double x = static_cast<double>(value);
        if constexpr (std::is_integral_v<T>)
          if (share) x = std::max(x / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
        out.push_back(x);
      }
  }

  std::vector<double> numbers_in(std::size_t view_index, std::size_t offset, std::size_t type, bool share,
                                 std::size_t count, std::size_t components, const std::string& of) {
    const Json& view = element("bufferViews", view_index, of);
    const std::string own = fmt::format("bufferViews[{}]", view_index);
    if (view.contains("extensions"))
      for (const auto& [name, unused] : view["extensions"].items())
        if (name.find("meshopt") != std::string::npos)
          mesh_.fail(fmt::format("has {} compressed by {}; export it without compression", own, name));
    const std::string& bytes = buffer(needed(view, "buffer", own));
    const std::size_t begin = number(view, "byteOffset", own, 0), length = needed(view, "byteLength", own);
    struct Kind {
      std::size_t size;
      void (*decode)(const char*, std::size_t, std::size_t, std::size_t, bool, std::vector<double>&);
    };
    static const std::map<std::size_t, Kind> kKinds = {
        {5120, {1, decode<std::int8_t>}},   {5121, {1, decode<std::uint8_t>}},  {5122, {2, decode<std::int16_t>}},
        {5123, {2, decode<std::uint16_t>}}, {5125, {4, decode<std::uint32_t>}}, {5126, {4, decode<float>}}};
    const auto kind = kKinds.find(type);
    if (kind == kKinds.end()) mesh_.fail(fmt::format("has {} with the component type {}; export it again", of, type));
    const std::size_t each = kind->second.size * components,
                      stride = std::max(each, number(view, "byteStride", own, each));
    if (begin > bytes.size() || length > bytes.size() - begin ||
        (count > 0 && (offset > length || each > length - offset || (length - offset - each) / stride < count - 1)))
      mesh_.fail(fmt::format("has {} that goes on beyond {} or its buffer of {} bytes; is the copy whole?", of, own,
                             bytes.size()));
    std::vector<double> out;
    out.reserve(count * components);
    kind->second.decode(bytes.data() + begin + offset, stride, count, components, share, out);
    return out;
  }

  // The bytes of a buffer: those of the binary chunk, of the text, or of a file beside it.
  const std::string& buffer(std::size_t index) {
    const auto known = buffers_.find(index);
    if (known != buffers_.end()) return known->second;
    const std::string own = fmt::format("buffers[{}]", index);
    const Json& b = element("buffers", index, "a buffer view");
    const auto uri = b.find("uri");
    std::string bytes;
    if (uri == b.end()) {
      if (index != 0 || !has_binary_)
        mesh_.fail(fmt::format("has {} without an uri, and no binary chunk; export it again", own));
      bytes = std::move(binary_);
    } else if (!uri->is_string()) {
      mesh_.fail(fmt::format("has {}.uri that is no text; export it again", own));
    } else if (const std::string text = uri->get<std::string>(); text.rfind("data:", 0) == 0) {
      bytes = gltf_data(mesh_, text, own);
    } else {
      const std::filesystem::path beside = std::filesystem::path(mesh_.path).parent_path() / gltf_path(text);
      const std::string file = mesh_.scene.file_beside(mesh_.field, beside);
      if (const std::uintmax_t size = std::filesystem::file_size(file); size > kMostBytes - std::min(held_, kMostBytes))
        mesh_.fail(fmt::format("has {} in '{}' of {} bytes, and its buffers may have {} in all; {}", own, text, size,
                               kMostBytes, kReduce));
      bytes = gltf_bytes(file);
    }
    if (const std::size_t length = needed(b, "byteLength", own); bytes.size() < length)
      mesh_.fail(fmt::format("has {} of {} bytes, and {} are there; is the copy whole?", own, length, bytes.size()));
    held_ += bytes.size();
    return buffers_.emplace(index, std::move(bytes)).first->second;
  }

  MeshFile& mesh_;
  Json root_;
  std::string binary_;
  bool has_binary_ = false;
  std::size_t visited_ = 0, seen_ = 0;  // nodes; triangles and primitives
  std::size_t held_ = 0;                // bytes in buffers_
  std::vector<std::string> path_;       // names of the nodes down to the present one
  std::map<std::size_t, std::string> buffers_;
  std::map<std::pair<std::vector<std::string>, std::string>, int> tags_;
};

}  // namespace

void read_gltf(MeshFile& mesh) {
  try {
    Gltf(mesh).read();
  } catch (const Json::exception& e) {  // a value of another kind than glTF says
    mesh.fail(fmt::format("is no glTF file: {}; export it again", e.what()));
  }
}

}  // namespace sunder::scene
