#pragma once
// Reads PC2 files: the points of a mesh at many times, as animation programs write them.
#include <string>
#include <vector>

#include "coupler/scene/mesh_reader.h"

namespace sunder::scene {

constexpr int kMostSamples = 1000;  // of a file: each is a shape that is checked and kept

/// Points of a mesh file over time.
struct PointSamples {
  std::vector<double> times;              // [s], rising from 0 or later
  std::vector<std::vector<Vec3>> points;  // [sample][point of the mesh file], scaled [m]
};

/// Reads the cache of the body whose mesh is `mesh`. The file is little endian: the text POINTCACHE2 and a zero byte; a
/// version, 1; the number of points; the frame of the first sample and the frames between two samples, in single
/// precision; the number of samples; then x, y, z of each point at each sample, in single precision. `field` is that of
/// the cache. Throws Error (bad_scene) where a number of the head does not fit the file's length or the mesh, or a
/// point is none.
PointSamples read_point_cache(const LoadedScene& scene, const std::string& field, const proto::PointCache& cache,
                              const MeshFile& mesh);

}  // namespace sunder::scene
