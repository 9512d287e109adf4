// Reads STL files: triangles, each with its own three corners.
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {
namespace {

constexpr std::size_t kHead = 84, kTriangle = 50;  // bytes: a title and a count; a normal, three corners, an attribute

/// Joins corners with equal coordinates. They are equal to the bit, because a program writes each from one point.
class Corners {
 public:
  explicit Corners(MeshFile& mesh) : mesh_(mesh) {}
  int index(const Vec3& p, const std::string& where) {
    if (!p.allFinite()) mesh_.add(p, where);  // which refuses it: a map has no order for such numbers
    const auto [found, is_new] =
        known_.emplace(std::array{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, static_cast<int>(mesh_.points.size()));
    if (is_new) mesh_.add(p, where);
    return found->second;
  }

 private:
  MeshFile& mesh_;
  std::map<std::array<double, 3>, int> known_;
};

void read_binary(MeshFile& mesh, const std::string& bytes) {
  Corners corners(mesh);
  mesh.place = "number";
  for (std::size_t at = kHead; at < bytes.size(); at += kTriangle) {
    Polygon polygon{{}, static_cast<int>((at - kHead) / kTriangle) + 1};
    for (int c = 0; c < 3; ++c) {
      std::array<float, 3> x;  // little endian, as this machine
      std::memcpy(x.data(), &bytes[at + 12 * (1 + c)], sizeof x);
      polygon.corners.push_back(corners.index(Vec3(x[0], x[1], x[2]), fmt::format("triangle {}", polygon.line)));
    }
    if (mesh.with_faces) mesh.polygons.push_back(std::move(polygon));
  }
}

void read_ascii(MeshFile& mesh, const std::string& text) {
  Corners corners(mesh);
  std::istringstream lines(text);
  Polygon polygon;
  int number = 0, facet = 0;
  bool ended = false;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "facet") {
      if (!polygon.corners.empty()) mesh.fail_at(fmt::format("line {}", number), "the facet before it has no endfacet");
      polygon = {{}, number}, ++facet;
    }
    if (word == "vertex") {
      Vec3 p;
      if (!(words >> p.x() >> p.y() >> p.z()))
        mesh.fail_at(fmt::format("line {}", number), fmt::format("'{}' is no point of three numbers", line));
      polygon.corners.push_back(corners.index(p, fmt::format("line {}", number)));
    }
    if (word == "endfacet") {
      if (polygon.corners.size() != 3)
        mesh.fail_at(fmt::format("line {}", number),
                     fmt::format("the facet has {} corners, and a facet has 3", polygon.corners.size()));
      if (mesh.with_faces) mesh.polygons.push_back(polygon);
      polygon = {};
    }
    ended = ended || word == "endsolid";
  }
  if (!ended) mesh.fail(fmt::format("ends after {} facets, without the word endsolid; is the copy whole?", facet));
}

}  // namespace

void read_stl(MeshFile& mesh) {
  std::ifstream in(mesh.file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  // A binary file may start with the word solid too, so its length decides.
  std::uint32_t count = 0;
  if (bytes.size() >= kHead) std::memcpy(&count, &bytes[kHead - 4], sizeof count);
  if (bytes.size() >= kHead && bytes.size() == kHead + kTriangle * count) return read_binary(mesh, bytes);
  if (bytes.compare(0, 5, "solid") != 0 || bytes.find("facet") == std::string::npos)
    mesh.fail(
        fmt::format("is no STL file: it does not start with the word solid, and has {} bytes where a binary file "
                    "of {} triangles would have {}; is the copy whole?",
                    bytes.size(), count, kHead + kTriangle * static_cast<std::size_t>(count)));
  read_ascii(mesh, bytes);
}

}  // namespace sunder::scene
