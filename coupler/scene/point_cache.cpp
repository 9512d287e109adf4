#include "coupler/scene/point_cache.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace sunder::scene {
namespace {

struct Head {
  std::array<char, 12> name;
  std::int32_t version, points;
  float first, every;  // [frames]
  std::int32_t samples;
};
constexpr std::size_t kHead = 32, kPoint = 12;  // bytes
static_assert(sizeof(Head) == kHead);
constexpr std::array<char, 12> kName{'P', 'O', 'I', 'N', 'T', 'C', 'A', 'C', 'H', 'E', '2', '\0'};

}  // namespace

PointSamples read_point_cache(const LoadedScene& scene, const std::string& field, const proto::PointCache& cache,
                              const MeshFile& mesh) {
  const std::string path = field + ".path";
  const std::filesystem::path file = scene.file_beside(path, cache.path());
  const auto fail = [&](const std::string& what) { scene.fail(path, fmt::format("'{}' {}", cache.path(), what)); };
  std::ifstream in(file, std::ios::binary);
  Head head{};
  in.read(reinterpret_cast<char*>(&head), sizeof head);  // little endian, as this machine
  if (!in || head.name != kName)
    fail("is no PC2 file: it does not begin with the word POINTCACHE2; export the animation as PC2");
  if (head.version != 1) fail(fmt::format("is of version {}; version 1 is read, which programs write", head.version));
  if (head.points < 1 || static_cast<std::size_t>(head.points) != mesh.points.size())
    fail(
        fmt::format("has {} points, and '{}' has {}: export both from one mesh, without modifiers that change its "
                    "points",
                    head.points, mesh.path, mesh.points.size()));
  if (head.samples < 1 || head.samples > kMostSamples)
    fail(fmt::format("has {} samples; give 1 to {}: export a shorter time, or fewer samples", head.samples,
                     kMostSamples));
  if (!(std::isfinite(head.every) && head.every > 0.0f) && head.samples > 1)
    fail(fmt::format("has {} frames from sample to sample; export it with a sample rate above 0", head.every));
  const std::size_t sample = kPoint * mesh.points.size(), whole = kHead + sample * head.samples;
  std::error_code none;
  const auto size = std::filesystem::file_size(file, none);
  if (none || size != whole)
    fail(fmt::format("has {} bytes, and {} samples of {} points take {}; is the copy whole?", none ? 0 : size,
                     head.samples, head.points, whole));
  PointSamples out;
  const double start = cache.has_time_s() ? cache.time_s() : head.first / cache.frames_per_second();
  if (!(std::isfinite(start) && start >= 0.0))
    fail(fmt::format("begins at frame {}, before time 0; say when it begins with time_s", head.first));
  std::vector<float> x(3 * mesh.points.size());
  for (int k = 0; k < head.samples; ++k) {
    in.read(reinterpret_cast<char*>(x.data()), static_cast<std::streamsize>(sample));
    if (!in) fail(fmt::format("ends within sample {}; is the copy whole?", k + 1));
    const double time = start + k * static_cast<double>(head.every) / cache.frames_per_second();
    if (!std::isfinite(time) || (k > 0 && !(time > out.times.back())))
      fail(fmt::format("has {} frames from sample to sample: times must rise; export it with another sample rate",
                       head.every));
    out.times.push_back(time);
    std::vector<Vec3>& points = out.points.emplace_back();
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const Vec3 p(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
      if (!(p.allFinite() && (mesh.scale * p).cwiseAbs().maxCoeff() <= kFarthest))
        fail(
            fmt::format("sample {}, point {}: ({}, {}, {}) is no point, or further than {:g} m away, scaled by {}; is "
                        "scale right?",
                        k + 1, i + 1, p.x(), p.y(), p.z(), kFarthest, mesh.scale));
      points.push_back(mesh.scale * p);
    }
  }
  return out;
}

}  // namespace sunder::scene
