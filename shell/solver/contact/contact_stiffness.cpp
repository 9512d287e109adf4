#include "shell/solver/contact/contact_stiffness.h"

#include "shell/solver/contact/rigid_contact.h"
#include "shell/solver/forces.h"

namespace sunder::shell {
namespace {

constexpr double kStep = 1e-5;  // thicknesses: far above round-off of the force, far below bending
constexpr double kShare = 0.1;  // least shape function of a control point that counts as under a sample

}  // namespace

std::vector<double> contact_stiffness(const ShellModel& m, ShellState& s, const std::vector<Proxy>& bodies,
                                      const ContactCandidates& candidates, const std::vector<char>& asked,
                                      int threads) {
  std::vector<double> stiffness(bodies.size(), 0.0);
  const std::size_t stride = static_cast<std::size_t>(m.tables.component_stride);
  std::vector<int> owner(stride, -1);
  std::vector<Vec3> out(bodies.size(), Vec3::Zero());
  bool any = false;
  std::vector<GatheredFunction> functions;
  for (std::size_t b = 0; b < std::min(bodies.size(), candidates.of_body.size()); ++b) {
    if (!asked[b]) continue;
    for (const auto& sample : candidates.of_body[b]) {
      sample_functions(m, s, sample.block, sample.lane, functions);
      Vec3 x = Vec3::Zero();
      for (const auto& f : functions) x += f.n[0] * s.position(f.slot);
      if (functions.empty() || s.motion.detached[functions[0].slot]) continue;
      out[b] += bodies[b].distance(x).normal;
      for (const auto& f : functions)
        if (f.n[0] >= kShare && s.motion.inverse_mass[f.slot] > 0.0 && owner[f.slot] < 0)
          owner[f.slot] = static_cast<int>(b), any = true;
    }
    if (out[b].norm() > 0.0) out[b].normalize();
  }
  if (!any) return stiffness;
  compute_forces(m, s, false, 0.0, threads);
  const std::vector<double> rest = s.motion.force, x = s.motion.x;
  const double step = kStep * m.thickness;
  for (std::size_t i = 0; i < stride; ++i)
    if (owner[i] >= 0)
      for (int d = 0; d < 3; ++d) s.motion.x[d * stride + i] += step * out[owner[i]][d];
  compute_forces(m, s, false, 0.0, threads);
  for (std::size_t i = 0; i < stride; ++i)
    if (owner[i] >= 0)
      for (int d = 0; d < 3; ++d)
        stiffness[owner[i]] -= out[owner[i]][d] * (s.motion.force[d * stride + i] - rest[d * stride + i]) / step;
  s.motion.x = x, s.motion.force = rest;
  for (double& k : stiffness) k = std::max(k, 0.0);
  return stiffness;
}

}  // namespace sunder::shell
