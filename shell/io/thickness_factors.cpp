#include "shell/io/thickness_factors.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "coupler/scene/checks.h"
#include "shell/geometry/builders.h"
#include "shell/io/grey_map.h"
#include "shell/io/ring_sectors.h"

namespace sunder::shell {
namespace {

// Piecewise linear, constant beyond its ends.
struct Law {
  proto::ThicknessLaw::Along along;
  std::vector<std::pair<double, double>> points;

  double coordinate(const Patch& patch, const Vec2& p) const {
    if (along < proto::ThicknessLaw::X) return p[along - proto::ThicknessLaw::U];
    return patch.evaluate(p).x[along - proto::ThicknessLaw::X];
  }
  double at(double x) const {
    if (x <= points.front().first) return points.front().second;
    const auto next = std::find_if(points.begin(), points.end(), [x](const auto& p) { return p.first >= x; });
    if (next == points.end()) return points.back().second;
    const auto& [a, fa] = *(next - 1);
    const auto& [b, fb] = *next;
    return fa + (x - a) / (b - a) * (fb - fa);
  }
};

Law law_of(const proto::ThicknessLaw& m) {
  Law out{m.along(), {}};
  for (const proto::ThicknessPoint& p : m.points()) out.points.emplace_back(p.at_m(), p.factor());
  return out;
}

Vec2 low_of(const Patch& p) { return {p.knots_u.begin(), p.knots_v.begin()}; }
Vec2 size_of(const Patch& p) { return Vec2(p.knots_u.end(), p.knots_v.end()) - low_of(p); }

// A law whose points all lie beyond one side of the shell has one factor there, which nobody writes on purpose. Of a
// ring, some sectors may lie beyond the law.
void check_reach(const scene::LoadedScene& scene, const proto::Shell& s, const Law& law, const Patch& own,
                 const std::string& field) {
  constexpr int kLooks = 32;  // along each side
  std::vector<Patch> patches{own};
  for (int k = 0; k < (scene::has_sectors(s) ? ring_sectors(s) : 0); ++k)
    patches.push_back(with_parameters_as_lengths(posed_sector(s, k, scene::patch_degree(s))));
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Patch& patch : patches)
    for (int i = 0; i <= kLooks; ++i)
      for (int j = 0; j <= kLooks; ++j) {
        const Vec2 p = low_of(patch) + size_of(patch).cwiseProduct(Vec2(i, j) / kLooks);
        const double x = law.coordinate(patch, p);
        low = std::min(low, x), high = std::max(high, x);
      }
  scene.check(law.points.front().first <= high && law.points.back().first >= low, field + ".points",
              "run from {:.6g} to {:.6g} m, and the shell from {:.6g} to {:.6g} m along {}; move them",
              law.points.front().first, law.points.back().first, low, high, proto::ThicknessLaw::Along_Name(law.along));
}

}  // namespace

ThicknessFactor thickness_factors(const scene::LoadedScene& scene, const proto::Shell& s, const Patch& patch,
                                  const std::string& field, const Paint* paint, bool fits) {
  if (!s.has_thickness_law() && !s.has_thickness_map() && !paint) return {};
  std::optional<Law> law;
  if (s.has_thickness_law()) {
    law.emplace(law_of(s.thickness_law()));
    // of a shell that a file divides, some parts may lie beyond the law
    if (fits && !s.has_cad() && !s.has_mesh()) check_reach(scene, s, *law, patch, field + ".thickness_law");
  }
  std::shared_ptr<const GreyImage> image;
  const proto::ThicknessMap& map = s.thickness_map();
  if (s.has_thickness_map()) {
    const std::optional<Vec2> size = fits ? std::optional<Vec2>(size_of(patch)) : std::nullopt;
    image = std::make_shared<const GreyImage>(read_grey_map(scene, map.path(), size, field + ".thickness_map"));
  }
  const double black = map.low_factor(), white = map.has_high_factor() ? map.high_factor() : 1.0;
  const std::shared_ptr<const Paint> painted = paint ? std::make_shared<const Paint>(*paint) : nullptr;
  return [law, image, black, white, painted](const Patch& own, const Vec2& p) {
    double factor = painted ? painted->at(p) : 1.0;
    if (law) factor *= law->at(law->coordinate(own, p));
    if (image) {
      const Vec2 share = (p - low_of(own)).cwiseQuotient(size_of(own));
      factor *= black + (white - black) * image->grey(share.x(), share.y());
    }
    return factor;
  };
}

double law_factor(const proto::ThicknessLaw& law, const Vec3& place) {
  ensure(law.along() >= proto::ThicknessLaw::X, "a thickness_law along a parameter has no factor in space");
  return law_of(law).at(place[law.along() - proto::ThicknessLaw::X]);
}

void check_thickness(const scene::LoadedScene& scene, const RowTables& t, const Patch& patch,
                     const std::string& field) {
  for (int q = 0; q < t.blocks() && t.varies(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double factor = t.thickness_factor(q, e);
      if (factor >= scene::kThinnest && factor <= scene::kThickest) continue;
      const Vec2 p = gauss_point(patch, t, q, e).parameter;
      scene.fail(field + ".thickness_m",
                 fmt::format("is multiplied by {:.3g} at ({:.4g}, {:.4g}), with thickness_law, thickness_map and "
                             "thickness_paint; {} to {}",
                             factor, p.x(), p.y(), scene::kThinnest, scene::kThickest));
    }
}

}  // namespace sunder::shell
