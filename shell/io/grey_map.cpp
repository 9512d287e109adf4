#include "shell/io/grey_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

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
  if (sizes.empty()) return "no image has that shape; leave the image out";
  std::string text;
  for (const auto& [w, h] : sizes) text += fmt::format("{}{:.0f} x {:.0f}", text.empty() ? "" : " or ", w, h);
  return text + " would do";
}

}  // namespace

GreyImage read_grey_map(const scene::LoadedScene& scene, const std::string& given, const std::optional<Vec2>& size,
                        const std::string& field) {
  const std::string path = scene.file_beside(field + ".path", given);
  try {
    const auto accept = [&](double width, double height) {
      const double aspect = size ? size->x() / size->y() : width / height;
      const bool good = std::min(width, height) >= kFewestPixels && std::max(width, height) <= kMostPixels;
      require(good, "has {} x {} pixels, and an image has {} to {} a side: {}", width, height, kFewestPixels,
              kMostPixels, sizes_that_do(width, height, aspect));
      require(std::abs(width / height / aspect - 1.0) <= kDistortion,
              "has {} x {} pixels, but the parameter domain is {:.4g} m x {:.4g} m, and the shapes may differ by 2 %: "
              "{}",
              width, height, size ? size->x() : width, size ? size->y() : height, sizes_that_do(width, height, aspect));
    };
    return is_png(path) ? read_png(path, accept) : read_pgm(path, accept);
  } catch (const Error& e) {
    scene.fail(field + ".path", fmt::format("'{}' {}", given, e.what()));
  }
}

}  // namespace sunder::shell
