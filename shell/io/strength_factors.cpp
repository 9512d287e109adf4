#include "shell/io/strength_factors.h"

#include <algorithm>
#include <cmath>

#include "shell/io/pgm_file.h"
#include "shell/io/png_file.h"

namespace sunder::shell {
namespace {

constexpr double kMostPixels = 16384.0, kFewestPixels = 2.0;  // pixels along a side
constexpr double kUsualPixels = 1024.0;  // along the longer side of the sizes that a message suggests
constexpr double kDistortion = 0.02;     // allowed error of the aspect ratio

// Lists image sizes near the given one with the domain's aspect ratio `aspect` (width / height).
std::string sizes_that_do(double width, double height, double aspect) {
  std::vector<std::pair<double, double>> sizes;
  const auto offer = [&](double w, double h) {
    const bool good = std::min(w, h) >= kFewestPixels && std::max(w, h) <= kMostPixels &&
                      std::abs(w / h / aspect - 1.0) <= kDistortion;
    if (good && (sizes.empty() || sizes.back() != std::pair(w, h))) sizes.emplace_back(w, h);
  };
  offer(width, std::round(width / aspect));
  offer(std::round(height * aspect), height);
  if (sizes.empty()) {
    const double ratio = std::max(aspect, 1.0 / aspect);
    const double brief = std::max(kFewestPixels, std::round(kUsualPixels / ratio)), longer = std::round(brief * ratio);
    offer(aspect >= 1.0 ? longer : brief, aspect >= 1.0 ? brief : longer);
  }
  if (sizes.empty()) return "no image has that shape; give strength_regions";
  std::string text;
  for (const auto& [w, h] : sizes) text += fmt::format("{}{:.0f} x {:.0f}", text.empty() ? "" : " or ", w, h);
  return text + " would do";
}

GreyImage read_map(const scene::LoadedScene& scene, const proto::StrengthMap& m, const Vec2& size,
                   const std::string& field) {
  const std::string path = scene.file_beside(field + ".path", m.path());
  const double aspect = size.x() / size.y();
  try {
    const auto accept = [&](double width, double height) {
      const bool good = std::min(width, height) >= kFewestPixels && std::max(width, height) <= kMostPixels;
      require(good, "has {} x {} pixels, and an image has {} to {} a side: {}", width, height, kFewestPixels,
              kMostPixels, sizes_that_do(width, height, aspect));
      require(std::abs(width / height / aspect - 1.0) <= kDistortion,
              "has {} x {} pixels, but the parameter domain is {:.4g} m x {:.4g} m, and the shapes may differ by 2 %: "
              "{}",
              width, height, size.x(), size.y(), sizes_that_do(width, height, aspect));
    };
    return is_png(path) ? read_png(path, accept) : read_pgm(path, accept);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", m.path(), e.what()));
  }
}

bool holds(const proto::StrengthRegion& r, const Vec2& p) {
  if (r.has_disc()) return (p - Vec2(r.disc().center().u(), r.disc().center().v())).norm() <= r.disc().radius_m();
  return p.x() >= r.low().u() && p.x() <= r.high().u() && p.y() >= r.low().v() && p.y() <= r.high().v();
}

}  // namespace

std::vector<float> strength_factors(const scene::LoadedScene& scene, const proto::Shell& s, const ShellModel& m,
                                    const std::string& field) {
  if (s.strength_regions_size() == 0 && !s.has_strength_map()) return {};
  const RowTables& t = m.tables;
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()),
      size = Vec2(m.patch.knots_u.end(), m.patch.knots_v.end()) - low;
  GreyImage image;
  const auto& map = s.strength_map();
  if (s.has_strength_map()) image = read_map(scene, map, size, field + ".strength_map");
  const double black = map.low_factor(), white = map.has_high_factor() ? map.high_factor() : 1.0;
  std::vector<int> held(s.strength_regions_size(), 0);
  std::vector<float> factors(static_cast<std::size_t>(t.blocks()) * t.lanes, 1.0f);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, t, q, e).parameter;
      double factor = 1.0;
      if (s.has_strength_map())
        factor = black + (white - black) * image.grey((p.x() - low.x()) / size.x(), (p.y() - low.y()) / size.y());
      for (int k = 0; k < s.strength_regions_size(); ++k)
        if (holds(s.strength_regions(k), p)) ++held[k], factor *= s.strength_regions(k).factor();
      scene.check(factor >= scene::kLeastFactor && factor <= scene::kMostFactor, field + ".strength_regions",
                  "multiply to {:.3g} at ({:.4g}, {:.4g}), with strength_map; {:.0g} to {:.0g} of the material's "
                  "strength",
                  factor, p.x(), p.y(), scene::kLeastFactor, scene::kMostFactor);
      factors[static_cast<std::size_t>(q) * t.lanes + e] = static_cast<float>(factor);
    }
  for (int k = 0; k < s.strength_regions_size(); ++k)
    scene.check(held[k] > 0, fmt::format("{}.strength_regions[{}]", field, k),
                "holds no Gauss point of the shell, whose parameters run from {:.6g} to {:.6g} along u and from {:.6g} "
                "to {:.6g} along v, with a spacing of {:.3g} m; move it, or make it larger",
                low.x(), low.x() + size.x(), low.y(), low.y() + size.y(), m.spacing);
  return factors;
}

}  // namespace sunder::shell
