#pragma once
// An arch: a block on two feet with a gap below, and its mesh files.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "coupler/core/vec.h"

namespace arch {

// Outer size and gap in x and z, and depth in y [m].
constexpr double kWide = 0.06, kHigh = 0.05, kDeep = 0.03, kLeft = 0.02, kRight = 0.04, kGapHigh = 0.03;
constexpr double kVolume = kDeep * (kWide * kHigh - (kRight - kLeft) * kGapHigh);

struct Mesh {
  std::vector<sunder::Vec3> points;
  std::vector<std::vector<int>> faces;
};

/// An outline in x and z, clockwise seen from -y, extruded from y = 0: two faces of many corners, the others are quads.
inline Mesh prism(const std::vector<std::array<double, 2>>& outline, double deep) {
  const int n = static_cast<int>(outline.size());
  Mesh m;
  m.faces.resize(2);
  for (const double y : {0.0, deep})
    for (const auto& [x, z] : outline) m.points.emplace_back(x, y, z);
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    m.faces[0].push_back(n - 1 - i), m.faces[1].push_back(n + i);
    m.faces.push_back({i, j, n + j, n + i});
  }
  return m;
}

inline Mesh mesh() {
  return prism(
      {{0, 0}, {0, kHigh}, {kWide, kHigh}, {kWide, 0}, {kRight, 0}, {kRight, kGapHigh}, {kLeft, kGapHigh}, {kLeft, 0}},
      kDeep);
}

inline std::string off(const Mesh& m) {
  std::string text = fmt::format("OFF  # lines that begin with # say nothing\n# points, faces\n{} {} 0\n\n",
                                 m.points.size(), m.faces.size());
  for (const sunder::Vec3& p : m.points) text += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
  for (const auto& face : m.faces) {
    text += std::to_string(face.size());
    for (const int c : face) text += fmt::format(" {}", c);
    text += "\n";
  }
  return text;
}

inline std::string obj(const Mesh& m) {
  std::string text = "o arch\n";
  for (const sunder::Vec3& p : m.points) text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
  for (const auto& face : m.faces) {
    text += "f";
    for (std::size_t i = 0; i < face.size(); ++i)  // in all forms of OBJ: textures, normals, from the end
      text += i == 0 ? fmt::format(" {}//1", face[i] - static_cast<int>(m.points.size()))
                     : fmt::format(" {}/2/3", face[i] + 1);
    text += "\n";
  }
  return text;
}

/// A PC2 file of these samples: the frame of the first one, and frames from sample to sample.
inline std::string pc2(const std::vector<std::vector<sunder::Vec3>>& samples, float first, float every) {
  std::string out("POINTCACHE2\0", 12);
  const auto add = [&](auto number) { out.append(reinterpret_cast<const char*>(&number), sizeof number); };
  add(std::int32_t{1}), add(static_cast<std::int32_t>(samples.front().size())), add(first), add(every);
  add(static_cast<std::int32_t>(samples.size()));
  for (const auto& points : samples)
    for (const sunder::Vec3& p : points)
      for (int c = 0; c < 3; ++c) add(static_cast<float>(p[c]));
  return out;
}

}  // namespace arch
