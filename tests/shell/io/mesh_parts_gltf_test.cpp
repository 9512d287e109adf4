// glTF files as shells: both kinds, where their nodes put them, and what is refused.
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "shell/io/inspect_mesh.h"
#include "shell/io/mesh_parts.h"
#include "shell/solver/parting/pieces.h"
#include "tests/shell/io/mesh_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

template <class T>
std::string bytes(const std::vector<T>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
}
std::string base64(const std::string& from) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t k = 0; k < from.size(); k += 3) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 3; ++i)
      bits = bits << 8 | (k + i < from.size() ? static_cast<unsigned char>(from[k + i]) : 0u);
    for (int i = 0; i < 4; ++i)
      out += k + static_cast<std::size_t>(i) > from.size() ? '=' : digits[bits >> (18 - 6 * i) & 63u];
  }
  return out;
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// A rectangle of 2 m x 1 m that lies flat where y is up: four points, and colours 0, 1, 1, 0 in red.
const std::string kBinary = bytes<float>({0, 0, 0, 2, 0, 0, 2, 0, -1, 0, 0, -1}) +
                            bytes<std::uint16_t>({0, 1, 2, 0, 2, 3}) +
                            bytes<std::uint8_t>({0, 0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 0, 0, 0, 255});
std::string json(const std::string& uri, const std::string& node = "\"mesh\": 0", const std::string& more = "") {
  return R"({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [ { "nodes": [ 0 ] } ],
  "nodes": [ { "name": "sheet", )" +
         node + R"( }, { "name": "flap", "mesh": 0, "translation": [ 0, 0, 1 ] } ],
  "materials": [ { "name": "clear" } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0, "COLOR_0": 2 }, "indices": 1, "material": 0 } ] } ],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
    { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
    { "bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": true } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
                   { "buffer": 0, "byteOffset": 60, "byteLength": 16 } ],
  "buffers": [ { "byteLength": 76)" +
         (uri.empty() ? "" : ", \"uri\": \"" + uri + "\"") + " } ]" + more + " }";
}
std::string glb(std::string text, std::string binary) {
  while (text.size() % 4) text += ' ';
  while (binary.size() % 4) binary += '\0';
  const auto size = static_cast<std::uint32_t>(28 + text.size() + binary.size());
  return bytes<std::uint32_t>({0x46546C67, 2, size, static_cast<std::uint32_t>(text.size()), 0x4E4F534A}) + text +
         bytes<std::uint32_t>({static_cast<std::uint32_t>(binary.size()), 0x004E4942}) + binary;
}

class MeshGltf : public MeshScene {};

TEST_F(MeshGltf, TextWithDataTextWithAFileAndBinaryAreTheSame) {
  write("a.gltf", json("data:application/octet-stream;base64," + base64(kBinary)));
  write("b.gltf", json("b%20b.bin"));
  write("b b.bin", kBinary);
  write("c.glb", glb(json(""), kBinary));
  for (const char* name : {"a.gltf", "b.gltf", "c.glb"}) {
    const RunSetup r = setup(fmt::format("path: '{}' element_m: 0.2", name));
    ASSERT_EQ(r.shells.size(), 1u);
    EXPECT_NEAR(area(r), 2.0, 1e-9);
    Eigen::AlignedBox3d box;  // upright: y of the file is z
    for (const Vec3& x : r.shells[0].model.patch.control_points) box.extend(x);
    EXPECT_LT((box.min() - Vec3(0, 0, 0)).norm(), 1e-9) << name;
    EXPECT_LT((box.max() - Vec3(2, 1, 0)).norm(), 1e-9) << name;
  }
}

// A child is placed by its parent: a turn of 90 degrees about y, twice as large, one up; and a mirror turns triangles.
TEST_F(MeshGltf, NodesPlaceAndMirrorTheirMeshes) {
  write("a.glb", glb(json("",
                          "\"children\": [ 1 ], \"translation\": [ 0, 1, 0 ], \"scale\": [ 2, 2, -2 ], "
                          "\"rotation\": [ 0, 0.70710678118654757, 0, 0.70710678118654757 ]"),
                     kBinary));
  const RunSetup r = setup("path: 'a.glb' element_m: 0.4");
  EXPECT_NEAR(area(r), 8.0, 1e-8);
  Eigen::AlignedBox3d box;
  for (const Vec3& x : r.shells[0].model.patch.control_points) box.extend(x);
  // the sheet from (0, 0, 1) to (2, 0, 0) is scaled to (0, 0, -2) to (4, 0, 0); turned, its x goes from -2 to 0 and its
  // z from -4 to 0
  EXPECT_LT((box.min() - Vec3(-2, 0, 1)).norm(), 1e-6);
  EXPECT_LT((box.max() - Vec3(0, 4, 1)).norm(), 1e-6);
  EXPECT_EQ(read_shell_mesh(scene::load(folder.path + "/scene.textproto", {}), "shells[0].mesh",
                            scene::load(folder.path + "/scene.textproto", {}).message.shells(0).mesh())
                .mesh.turned,
            0);
}

// Texture coordinates of the four points, whose v goes down: (0.1, 0.2), (0.9, 0.2), (0.9, 0.7), (0.1, 0.7) as floats,
// and halves and wholes as shares of 65535. Beside it stands a sheet without any, which is read first.
std::string with_texture(const std::string& accessor) {
  std::string text = json("", "\"mesh\": 1");
  text = replaced(text, "\"indices\": 1, \"material\": 0 } ] } ]",
                  "\"indices\": 1 } ] }, { \"primitives\": [ { \"attributes\": { \"POSITION\": 0, \"TEXCOORD_0\": 3 }, "
                  "\"indices\": 1 } ] } ]");
  text = replaced(text, "\"normalized\": true }", "\"normalized\": true }, { \"bufferView\": 3, " + accessor + " }");
  text = replaced(text, "\"byteLength\": 16 }",
                  "\"byteLength\": 16 }, { \"buffer\": 0, \"byteOffset\": 76, \"byteLength\": 48 }");
  text = replaced(text, "\"scenes\": [ { \"nodes\": [ 0 ]", "\"scenes\": [ { \"nodes\": [ 1, 0 ]");
  text = replaced(text, "\"translation\": [ 0, 0, 1 ]", "\"translation\": [ 0, 0, 5 ]");
  return replaced(text, "\"byteLength\": 76", "\"byteLength\": 124");
}
const std::string kTextured = kBinary + bytes<float>({0.1f, 0.2f, 0.9f, 0.2f, 0.9f, 0.7f, 0.1f, 0.7f}) +
                              bytes<std::uint16_t>({0, 0, 65535, 0, 65535, 32768, 0, 32768});
const std::string kFloats = "\"componentType\": 5126, \"count\": 4, \"type\": \"VEC2\"";

TEST_F(MeshGltf, TextureCoordinatesAreThoseOfFramesWithTheirVUp) {
  const std::string shares =
      "\"byteOffset\": 32, \"componentType\": 5123, \"normalized\": true, \"count\": 4, \"type\": \"VEC2\"";
  const std::array<std::pair<std::string, std::array<Vec2, 2>>, 2> kinds{
      {{kFloats, {Vec2(0.1, 0.2), Vec2(0.9, 0.7)}}, {shares, {Vec2(0, 0), Vec2(1.0, 32768.0 / 65535.0)}}}};
  for (const auto& [accessor, corners] : kinds) {
    write("a.glb", glb(with_texture(accessor), kTextured));
    const RunSetup r = setup("path: 'a.glb' element_m: 0.2");
    ASSERT_EQ(r.shells.size(), 2u);
    const ShellModel &plain = r.shells[0].model, &m = r.shells[1].model;
    const Vec2 whole(m.patch.knots_u.end(), m.patch.knots_v.end());
    for (const Vec2& share : {Vec2(0, 0), Vec2(1, 1), Vec2(0.37, 0.61), Vec2(0.93, 0.02)}) {
      const Vec2 p = share.cwiseProduct(whole);
      const Vec3 x = m.patch.evaluate(p).x;
      const Vec2 in_file = corners[0] + Vec2(0.5 * x.x(), x.y()).cwiseProduct(corners[1] - corners[0]);
      EXPECT_LT((drawn_parameter(m, p) - Vec2(in_file.x(), 1.0 - in_file.y())).norm(), 1e-7) << accessor;
      EXPECT_LT((drawn_parameter(plain, p) - share).norm(), 1e-9) << accessor;
    }
  }
}

// A material's picture: offset (0.1, 0.2), scale (2, 3), and a turn by 90 degrees to the left. In a picture v goes
// down, so the turn takes (1, 0) to (0, -1) and (0, 1) to (1, 0).
std::string with_picture(const std::string& picture) {
  std::string text =
      replaced(with_texture(kFloats), "{ \"name\": \"clear\" }",
               "{ \"name\": \"clear\", \"pbrMetallicRoughness\": { \"baseColorTexture\": { " + picture + " } } }");
  text = replaced(text, "\"TEXCOORD_0\": 3 }, \"indices\": 1",
                  "\"TEXCOORD_0\": 3, \"TEXCOORD_1\": 4 }, \"indices\": 1, \"material\": 0");
  return replaced(text, kFloats + " }",
                  kFloats +
                      " }, { \"bufferView\": 3, \"byteOffset\": 32, \"componentType\": 5123, "
                      "\"normalized\": true, \"count\": 4, \"type\": \"VEC2\" }");
}
std::string moved_by(const std::string& more) {
  return "\"index\": 0, \"extensions\": { \"KHR_texture_transform\": { " + more + " } }";
}

TEST_F(MeshGltf, TheMaterialSaysWhichTextureCoordinatesAndWhereTheyAre) {
  struct Case {
    std::string picture;
    Vec2 origin, along_x, along_y;  // in the file, of a square of 1 m
  };
  const double half = 32768.0 / 65535.0;
  const std::string turn = "\"offset\": [ 0.1, 0.2 ], \"rotation\": 1.5707963267948966, \"scale\": [ 2, 3 ]";
  const std::vector<Case> cases{{"\"index\": 0", {0.1, 0.2}, {0.4, 0}, {0, 0.5}},
                                {"\"index\": 0, \"texCoord\": 1", {0, 0}, {0.5, 0}, {0, half}},
                                {moved_by("\"texCoord\": 1"), {0, 0}, {0.5, 0}, {0, half}},
                                {moved_by("\"offset\": [ 0.5, 0 ]"), {0.6, 0.2}, {0.4, 0}, {0, 0.5}},
                                {moved_by("\"texCoord\": 1, " + turn), {0.1, 0.2}, {0, -1.0}, {3.0 * half, 0}}};
  for (const Case& c : cases) {
    const std::string text = with_picture(c.picture);
    write("a.glb", glb(text.substr(0, text.rfind('}')) + ", \"extensionsRequired\": [ \"KHR_texture_transform\" ] }",
                       kTextured));
    const ShellModel m = setup("path: 'a.glb' element_m: 0.2").shells.at(1).model;
    const Vec2 whole(m.patch.knots_u.end(), m.patch.knots_v.end());
    for (const Vec2& share : {Vec2(0, 0), Vec2(1, 1), Vec2(0.37, 0.61)}) {
      const Vec2 p = share.cwiseProduct(whole);
      const Vec3 x = m.patch.evaluate(p).x;
      const Vec2 in_file = c.origin + x.x() * c.along_x + x.y() * c.along_y;
      EXPECT_LT((drawn_parameter(m, p) - Vec2(in_file.x(), 1.0 - in_file.y())).norm(), 1e-7) << c.picture;
    }
  }
}

TEST_F(MeshGltf, PicturesThatDoNotFitAreRefused) {
  const auto refused = [&](const std::string& picture, const std::string& says) {
    write("a.glb", glb(with_picture(picture), kTextured));
    expect_part(refusal("path: 'a.glb' element_m: 0.2"), says);
  };
  refused("\"texCoord\": 2",
          "has no TEXCOORD_2 in meshes[1].primitives[0], which the picture of its material 'clear' takes");
  refused("\"texCoord\": -1", "materials[0].texCoord of -1");
  refused(moved_by("\"offset\": [ 1 ]"), "materials[0].offset that are not 2 numbers");
  refused(moved_by("\"scale\": 2"), "materials[0].scale that are not 2 numbers");
  refused(moved_by("\"rotation\": \"left\""), "rotation of \"left\" in materials[0]");
  refused(moved_by("\"scale\": [ 1e308, 1e308 ], \"offset\": [ 1.7e308, 1.7e308 ]"), "TEXCOORD_0");
}

TEST_F(MeshGltf, TextureCoordinatesThatDoNotFitAreRefused) {
  const std::string few = replaced(kFloats, "\"count\": 4", "\"count\": 3");
  write("a.glb", glb(with_texture(few), kTextured));
  expect_part(refusal("path: 'a.glb' element_m: 0.2"),
              "TEXCOORD_0 in meshes[1].primitives[0] that are no texture coordinates of its points");
  write("b.glb", glb(with_texture(replaced(kFloats, "VEC2", "SCALAR")), kTextured));
  expect_part(refusal("path: 'b.glb' element_m: 0.2"), "accessors[3] of a type that does not fit");
  std::string broken = kTextured;
  broken.replace(kBinary.size(), 4, bytes<float>({std::numeric_limits<float>::quiet_NaN()}));
  write("c.glb", glb(with_texture(kFloats), broken));
  expect_part(refusal("path: 'c.glb' element_m: 0.2"), "TEXCOORD_0");
}

TEST_F(MeshGltf, NodesAndMaterialsAreParts) {
  write("a.glb", glb(json("", "\"mesh\": 0, \"children\": [ 1 ]"), kBinary));
  const auto mass = [&](const std::string& part) {
    double sum = 0.0;
    for (const ShellSetup& s : setup("path: 'a.glb' element_m: 0.2 " + part).shells)
      for (const double m : s.model.mass) sum += m;
    return sum / (2500 * 0.01 * 2.0);
  };
  EXPECT_NEAR(mass(""), 2.0, 1e-9);
  EXPECT_NEAR(mass("parts { group: 'flap' thickness_m: 0.005 }"), 1.5, 1e-6);
  EXPECT_NEAR(mass("parts { usemtl: 'clear' thickness_m: 0.005 }"), 1.0, 1e-6);
  expect_part(refusal("path: 'a.glb' element_m: 0.2 parts { group: 'flab' thickness_m: 0.005 }"),
              "did you mean 'flap'");
  const std::string told = inspect_mesh_report(folder.path + "/a.glb", {});
  for (const char* part : {"\"flap\"", "\"sheet\"", "\"clear\"", "\"coloured\": true"}) expect_part(told, part);
}

TEST_F(MeshGltf, ColoursAreRead) {
  write("a.glb", glb(json(""), kBinary));
  const RunSetup r = setup("path: 'a.glb' element_m: 0.1 thickness_paint { channel: RED low_factor: 0.5 }");
  double mass = 0.0;
  for (const double m : r.shells[0].model.mass) mass += m;
  EXPECT_NEAR(mass / (2500 * 0.01 * 2.0), 0.75, 1e-9);
}

TEST_F(MeshGltf, BadFilesAreRefusedByName) {
  const std::string good = glb(json(""), kBinary);
  const auto refused = [&](const std::string& content, const std::string& says, const char* name = "a.glb") {
    write(name, content);
    const std::string told = refusal(fmt::format("path: '{}' element_m: 0.2", name));
    expect_part(told, says);
    expect_part(told, "shells[0].mesh.path");
  };
  refused(good.substr(0, good.size() - 8), "is the copy whole?");
  refused("glTF", "is no glTF file");
  refused("{", "is no glTF file", "a.gltf");
  refused("[]", "is no glTF file", "a.gltf");
  refused(replaced(json("x.bin"), "\"2.0\"", "\"1.0\""), "glTF 2.0 is read", "a.gltf");
  refused(json("none.bin"), "cannot be read", "a.gltf");
  refused(json("../../x.bin"), "outside the scene's folder", "a.gltf");
  refused(json("data:;base64,AAAA"), "has buffers[0] of 76 bytes, and 3 are there", "a.gltf");
  refused(json("data:;base64,A*"), "base64 has not", "a.gltf");
  refused(glb(json("", "\"mesh\": 0", ", \"extensionsRequired\": [ \"KHR_draco_mesh_compression\" ]"), kBinary),
          "export it without compression");
  refused(glb(json("", "\"mesh\": 7"), kBinary), "has meshes[7] named by a node, and has 1");
  refused(glb(json("", "\"mesh\": 0, \"children\": [ 0 ]"), kBinary), "themselves as children");
  refused(glb(json("", "\"camera\": 0"), kBinary), "has no mesh in its scene");
  refused(glb(replaced(json(""), "\"count\": 6", "\"count\": 7"), kBinary), "goes on beyond bufferViews[1]");
  refused(glb(replaced(json(""), "\"count\": 6", "\"count\": -6"), kBinary), "accessors[1].count of -6");
  refused(glb(replaced(json(""), "5126", "5130"), kBinary), "the component type 5130");
  for (const char* type : {"5120", "5122", "5126", "5130"})
    refused(glb(replaced(json(""), "5123", type), kBinary), fmt::format("accessors[1].componentType of {}", type));
  refused(glb(replaced(json(""), "\"count\": 6", "\"count\": 6, \"normalized\": true"), kBinary),
          "accessors[1] with indices that are normalized");
  refused(glb(replaced(json(""), "\"VEC3\"", "\"VEC2\""), kBinary), "of a type that does not fit");
  refused(glb(replaced(replaced(json(""), ", \"COLOR_0\": 2", ""), "\"count\": 4, \"type\": \"VEC3\"",
                       "\"count\": 3, \"type\": \"VEC3\""),
              kBinary),
          "has corner 3 in meshes[0].primitives[0], which has 3 points");
  refused(glb(replaced(json(""), "\"count\": 4, \"type\": \"VEC3\"", "\"count\": 3, \"type\": \"VEC3\""), kBinary),
          "no colours of its points");
  refused(glb(json("", "\"mesh\": 0, \"rotation\": [ 0, 0, 0, 2 ]"), kBinary), "rotation of length 2");
  refused(glb(json("", "\"mesh\": 0, \"matrix\": [ 1 ]"), kBinary), "not 16 numbers");
  refused(glb(json("", "\"mesh\": 0, \"skin\": 0"), kBinary),
          "at 'sheet', so an armature says where its points are; apply the armature and export it again");
  for (const char* name : {"a.glb", "A.GLB", "a.b.GlTF"}) {
    write(name, good);
    expect_part(refusal(fmt::format("path: '{}' element_m: 0.2 up: Y", name)), "turned upright anyway");
  }
}

// Positions of which two are moved: 8 bytes of indices and 24 of values follow the rest.
std::string sparse_json(int type) {
  const std::string sparse = fmt::format(
      R"("count": 4, "type": "VEC3", "sparse": {{ "count": 2, "indices": {{ "bufferView": 3, "componentType": {} }},
                  "values": {{ "bufferView": 4 }} }})",
      type);
  const std::string text =
      replaced(replaced(json(""), "\"count\": 4, \"type\": \"VEC3\"", sparse), "\"byteLength\": 16 }",
               "\"byteLength\": 16 }, { \"buffer\": 0, \"byteOffset\": 76, \"byteLength\": 8 }, "
               "{ \"buffer\": 0, \"byteOffset\": 84, \"byteLength\": 24 }");
  return replaced(text, "\"byteLength\": 76", "\"byteLength\": 108");
}

// A number that is none would be written before the array, and 1.5 would be 1.
TEST_F(MeshGltf, IndicesOfSparseArraysThatAreNoneAreRefused) {
  const std::string values = bytes<float>({3, 0, 0, 3, 0, -1});
  const auto refused = [&](int type, const std::string& indices, const std::string& says) {
    write("a.glb", glb(sparse_json(type), kBinary + indices + values));
    const std::string told = refusal("path: 'a.glb' element_m: 0.2");
    expect_part(told, says);
    expect_part(told, "shells[0].mesh.path");
  };
  const float none = std::numeric_limits<float>::quiet_NaN();
  refused(5126, bytes<float>({none, 1}), "accessors[0].sparse.indices.componentType of 5126");
  refused(5126, bytes<float>({1.5f, 2}), "accessors[0].sparse.indices.componentType of 5126");
  refused(5120, bytes<std::int8_t>({-1, 1, 0, 0, 0, 0, 0, 0}), "accessors[0].sparse.indices.componentType of 5120");
  refused(5123, bytes<std::uint16_t>({1, 4, 0, 0}), "has element 4 in accessors[0].sparse, which is none");
  refused(5125, bytes<std::uint32_t>({4294967295u, 1}), "has element 4294967295 in accessors[0].sparse");
}

// A few bytes ask for much: one list of corners that many nodes show, and large files beside it.
TEST_F(MeshGltf, WhatManyNodesShowAndLargeBuffersAreRefused) {
  const auto many = [](const std::vector<std::uint16_t>& three) {
    std::string corners, children = "\"mesh\": 0, \"children\": [ 1";
    for (int k = 0; k < 20000; ++k) corners += bytes<std::uint16_t>(three);
    for (int k = 0; k < 200; ++k) children += ", 1";
    std::string text = replaced(json("", children + " ]"), "\"count\": 6", "\"count\": 60000");
    text = replaced(text, "\"byteOffset\": 48, \"byteLength\": 12", "\"byteOffset\": 76, \"byteLength\": 120000");
    return glb(replaced(text, "\"byteLength\": 76", "\"byteLength\": 120076"), kBinary + corners);
  };
  write("a.glb", many({0, 1, 2}));
  expect_part(refusal("path: 'a.glb' element_m: 0.2"), "has more than 300000 triangles, counted again for each node");
  write("a.glb", many({1, 1, 1}));
  expect_part(refusal("path: 'a.glb' element_m: 0.2"), "has more than 3000000 triangles, counted again for each node");
  write("a.gltf", json("large.bin"));
  write("large.bin", kBinary);
  EXPECT_EQ(setup("path: 'a.gltf' element_m: 0.2").shells.size(), 1u);
  std::filesystem::resize_file(folder.path + "/large.bin", (std::uintmax_t{1} << 30) + 1);  // a hole: it takes no space
  expect_part(refusal("path: 'a.gltf' element_m: 0.2"),
              "has buffers[0] in 'large.bin' of 1073741825 bytes, and its buffers may have 1073741824 in all");
}

// Strips and fans, sparse positions, and meshes without indices.
TEST_F(MeshGltf, KindsOfPrimitivesAndSparseArrays) {
  const std::string no_indices = replaced(json(""), "\"indices\": 1, ", "");
  write("a.glb", glb(replaced(no_indices, "\"material\": 0", "\"material\": 0, \"mode\": 6"), kBinary));  // a fan
  EXPECT_NEAR(area(setup("path: 'a.glb' element_m: 0.2")), 2.0, 1e-9);
  const std::string strip = bytes<float>({0, 0, 0, 2, 0, 0, 0, 0, -1, 2, 0, -1}) + kBinary.substr(48);
  write("a.glb", glb(replaced(no_indices, "\"material\": 0", "\"material\": 0, \"mode\": 5"), strip));
  EXPECT_NEAR(area(setup("path: 'a.glb' element_m: 0.2")), 2.0, 1e-9);
  // the second and the third point are moved by a sparse array, to x = 3
  write("a.glb", glb(sparse_json(5121),
                     kBinary + bytes<std::uint8_t>({1, 2, 0, 0, 0, 0, 0, 0}) + bytes<float>({3, 0, 0, 3, 0, -1})));
  EXPECT_NEAR(area(setup("path: 'a.glb' element_m: 0.2")), 3.0, 1e-9);
}

}  // namespace
