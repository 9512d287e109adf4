#include "coupler/core/smooth_keys.h"

#include <algorithm>

namespace sunder {
namespace {

constexpr double kSteepest = 3.0;  // a cubic with slopes of at most three times that of its line is monotone

}  // namespace

Vec3 smooth_slope(const Vec3& before, const Vec3& after, double h0, double h1) {
  if (before.dot(after) <= 0.0) return Vec3::Zero();
  const Vec3 slope = (h1 * before + h0 * after) / (h0 + h1);
  const double most = kSteepest * std::min(before.norm(), after.norm()), size = slope.norm();
  return size > most ? Vec3(most / size * slope) : slope;
}

std::vector<Vec3> smooth_slopes(const std::vector<double>& times, const std::vector<Vec3>& values) {
  std::vector<Vec3> slopes(values.size(), Vec3::Zero());
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    const double h0 = times[k] - times[k - 1], h1 = times[k + 1] - times[k];
    slopes[k] = smooth_slope((values[k] - values[k - 1]) / h0, (values[k + 1] - values[k]) / h1, h0, h1);
  }
  return slopes;
}

HermiteWeights hermite_weights(const std::vector<double>& times, double t) {
  HermiteWeights w;
  const int last = static_cast<int>(times.size()) - 1;
  if (last < 0 || t <= times.front()) return w;
  if (t >= times.back()) {
    w.key = last;
    return w;
  }
  w.key = static_cast<int>(std::upper_bound(times.begin(), times.end(), t) - times.begin()) - 1;
  const double h = times[w.key + 1] - times[w.key], s = (t - times[w.key]) / h;
  w.c = s * s * (3.0 - 2.0 * s), w.a = 1.0 - w.c;
  w.b = h * s * (1.0 - s) * (1.0 - s), w.d = -h * s * s * (1.0 - s);
  return w;
}

}  // namespace sunder
