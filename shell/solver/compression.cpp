#include "shell/solver/compression.h"

#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {

void check_compression(const ShellModel& m, const ShellState& s) {
  const RowTables& t = m.tables;
  if (!std::isfinite(t.elasticity.least_log_area())) return;
  const double least = std::exp(t.elasticity.least_log_area());
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const GaussPoint g = gauss_point(m.patch, t, q, e);
      if (g.weight == 0.0) continue;
      const int point = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + e];
      GatheredPoint uncut;
      if (point >= 0 && s.cracked.gathered[point].kind != PointKind::kQuadratic) continue;
      if (point < 0) {
        shell_functions(m, q, e, uncut.functions);
        const double* metric = &t.metric[t.at(q, kMetricFields, 0, e)];
        uncut.metric = {{metric[kA11 * t.lanes], metric[kA22 * t.lanes], metric[kA12 * t.lanes]},
                        {metric[kB11 * t.lanes], metric[kB22 * t.lanes], metric[kB12 * t.lanes]}};
      }
      const GatheredPoint& p = point < 0 ? uncut : s.cracked.gathered[point];
      const Forms<double> f = surface_forms(gather(t, p, s.motion.x));
      for (std::size_t l = 0; l < t.layers.zeta.size(); ++l) {
        const Sym2<double> c = at_height(f.a, f.b, t.layers.zeta[l]), a = reference_at(p.metric, t.layers, l);
        const double area = std::sqrt(std::max(0.0, determinant(c) / determinant(a)));
        if (area > least || !std::isfinite(determinant(c))) continue;  // other checks find values that are not finite
        throw Error(Exit::kPhysics, "compression",
                    fmt::format("shell '{}' is compressed to {:.3g} of its area at (u, v) = ({:.4g}, {:.4g}); with a "
                                "poisson_ratio of {} a sheet in plane stress bears no more below {:.3g}: load it less, "
                                "or take a poisson_ratio nearer to 0",
                                m.name, area, g.parameter.x(), g.parameter.y(), m.material.poisson_ratio, least));
      }
    }
}

}  // namespace sunder::shell
