#include "shell/io/probes.h"

#include <fmt/format.h>

namespace sunder::shell {

Vec3 displacement(const ShellModel& m, const ShellState& s, const Vec2& at) {
  Vec3 u = Vec3::Zero();
  for (const GatheredFunction& f : patch_functions(m.patch, at, m.tables.stride))
    u += f.n[0] * (s.position(f.slot) - s.at(m.rest, f.slot));
  return u;
}

Vec3 reaction(const ShellModel& m, const ShellState& s, const Vec3& gravity) {
  Vec3 sum = Vec3::Zero();
  const std::size_t plane = m.tables.plane;
  const auto add = [&](int d, int slot) {
    if (!s.gone[slot]) sum[d] -= s.force[d * plane + slot] + s.mass[slot] * gravity[d];
  };
  for (int d = 0; d < 3; ++d) {
    for (const int slot : m.constraints.held[d]) add(d, slot);
    for (const auto& driven : m.constraints.driven)
      for (const int slot : driven.slots[d]) add(d, slot);
  }
  return sum;
}

std::string probe_header(const std::vector<Probe>& probes) {
  std::string out = "time [s]";
  for (const Probe& p : probes) out += fmt::format(",{0}_x [m],{0}_y [m],{0}_z [m]", p.name);
  return out + ",reaction_x [N],reaction_y [N],reaction_z [N]\n";
}

std::string probe_row(const std::vector<Probe>& probes, const ShellModel& m, const ShellState& s, double time,
                      const Vec3& gravity) {
  std::string out = fmt::format("{:.9g}", time);
  const auto three = [&](const Vec3& v) { out += fmt::format(",{:.9g},{:.9g},{:.9g}", v.x(), v.y(), v.z()); };
  for (const Probe& p : probes) three(displacement(m, s, p.at));
  three(reaction(m, s, gravity));
  return out + "\n";
}

}  // namespace sunder::shell
