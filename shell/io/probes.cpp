#include "shell/io/probes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace sunder::shell {

Vec3 displacement(const ShellModel& m, const ShellState& s, const Vec2& at) {
  Vec3 u = Vec3::Zero();
  for (const GatheredFunction& f : shell_functions(m, at)) u += f.n[0] * (s.position(f.slot) - s.at(m.rest, f.slot));
  return u;
}

Vec3 reaction(const ShellModel& m, const ShellState& s, const Vec3& gravity, const Constraints::Part& part) {
  Vec3 sum = Vec3::Zero();
  for (int d = 0; d < 3; ++d)
    for (const int slot : part.slots[d])
      // A dependent control point at a seam has no mass; its force counts at those it depends on.
      if (!s.motion.detached[slot] && s.motion.mass[slot] > 0.0)
        sum[d] -= s.motion.force[d * m.tables.component_stride + slot] + s.motion.mass[slot] * gravity[d];
  return sum;
}

Vec3 reaction(const ShellModel& m, const ShellState& s, const Vec3& gravity) {
  Vec3 sum = Vec3::Zero();
  for (const Constraints::Part& part : m.constraints.parts) sum += reaction(m, s, gravity, part);
  return sum;
}

Vec3 support_impulse(const ShellState& s, const Constraints::Part& part) {
  Vec3 sum = Vec3::Zero();
  const std::size_t stride = s.motion.support_impulse.size() / 3;
  for (int d = 0; d < 3 && stride > 0; ++d)
    for (const int slot : part.slots[d]) sum[d] += s.motion.support_impulse[d * stride + slot];
  return sum;
}

SurfaceArea surface_area(const ShellModel& m, const ShellState& s, int row, int lane) {
  const RowTables& t = m.tables;
  SurfaceArea sum;
  GatheredPoint uncut;
  const int points = t.gauss * t.gauss;
  for (int q = row * points; q < (row + 1) * points; ++q) {
    const GaussPoint g = gauss_point(m.patch, t, q, lane);
    if (g.weight == 0.0) continue;
    const double area = t.metric[t.at(q, kMetricFields, kArea, lane)] / t.thickness_factor(q, lane);
    const int point = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + lane];
    if (point < 0) shell_functions(m, q, lane, uncut.functions);
    const GatheredPoint& p = point < 0 ? uncut : s.cracked.gathered[point];
    const bool dead = point >= 0 && p.kind == PointKind::kDead;
    if ((point >= 0 && p.handed_off) || (!dead && s.motion.detached[p.functions[0].slot])) {
      sum.gone += area;
      continue;
    }
    if (dead) {
      sum.torn += area;
      continue;
    }
    const auto measure = [&](const std::vector<double>& x) {
      return 1.0 / surface_forms(gather(t, p, x)).inverse_area;
    };
    sum.rest += area, sum.now += area * measure(s.motion.x) / measure(m.rest);
  }
  return sum;
}

SurfaceArea surface_area(const ShellModel& m, const ShellState& s) {
  SurfaceArea sum;
  for (int row = 0; row < m.tables.spans_v; ++row)
    for (int lane = 0; lane < m.tables.spans_u; ++lane) sum += surface_area(m, s, row, lane);
  return sum;
}

namespace {

// Names of the columns of one array of a point, for example middle_stress_outside_xx [Pa].
std::string field_columns(const std::string& probe, const FieldArray& a) {
  std::string out;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const std::string component = a.components.empty() ? "" : "_" + a.components[k];
    out += fmt::format(",{}_{}{} [{}]", probe, a.name, component, a.unit.empty() ? "-" : a.unit);
  }
  return out;
}

std::string columns_of(const Probe& p) {
  if (p.is_pair())
    return fmt::format(",{0}_impulse_x [N s],{0}_impulse_y [N s],{0}_impulse_z [N s],{0}_x [N],{0}_y [N],{0}_z [N]",
                       p.name);
  std::string out = fmt::format(",{0}_x [m],{0}_y [m],{0}_z [m]", p.name);
  if (p.body >= 0) out += fmt::format(",{0}_vx [m/s],{0}_vy [m/s],{0}_vz [m/s]", p.name);
  if (p.body >= 0 && !p.soft)
    out += fmt::format(",{0}_qw [-],{0}_qx [-],{0}_qy [-],{0}_qz [-],{0}_wx [rad/s],{0}_wy [rad/s],{0}_wz [rad/s]",
                       p.name);
  for (const FieldArray& a : field_arrays(p.fields)) out += field_columns(p.name, a);
  return out;
}

// Values of the columns of one probe; none where there is no shell any more, and no numbers where nothing bears stress.
std::vector<double> values_of(const Probe& p, const ProbeMoment& now) {
  std::vector<double> out;
  const auto three = [&](const Vec3& v) {
    for (const double value : v) out.push_back(value);
  };
  if (p.is_pair()) {
    if (now.shells.empty()) return {};
    const ContactSince& c = now.contacts[p.shell];
    Vec3 impulse = Vec3::Zero();
    const std::vector<double>& given = p.other >= 0 ? c.by_shell : c.by_body;
    for (int d = 0; d < 3 && !given.empty(); ++d) impulse[d] = given[3 * (p.other >= 0 ? p.other : p.body) + d];
    three(impulse), three(c.on_points.time > 0.0 ? Vec3(impulse / c.on_points.time) : Vec3(Vec3::Zero()));
  } else if (p.body >= 0) {
    const BodyMotion& b = p.soft ? now.soft[p.body] : now.bodies[p.body]->motion;
    three(b.position), three(b.velocity);
    if (p.soft) return out;
    const Quat& q = b.orientation;
    out.push_back(q.w()), three(q.vec()), three(now.bodies[p.body]->angular_velocity());
  } else if (!now.shells.empty()) {
    const ShellView& s = now.shells[p.shell];
    three(displacement(*s.model, *s.state, p.at));
    if (p.fields.empty()) return out;
    const std::size_t moved = out.size();
    if (!FieldSampler(*s.model, *s.state, p.fields, now.contacts[p.shell].on_points).add_values(p.at, out))
      std::fill(out.begin() + moved, out.end(), std::nan(""));
  }
  return out;
}

}  // namespace

std::string probe_header(const std::vector<Probe>& probes, const std::vector<const ShellModel*>& models) {
  std::string out = "time [s]";
  for (const Probe& p : probes) out += columns_of(p);
  out += ",reaction_x [N],reaction_y [N],reaction_z [N]";
  for (const ShellModel* m : models)
    for (const Constraints::Part& part : m->constraints.parts) {
      const std::string name = m->name + "_" + part.name;
      out += fmt::format(",{0}_x [N],{0}_y [N],{0}_z [N]", name);
      out += fmt::format(",{0}_impulse_x [N s],{0}_impulse_y [N s],{0}_impulse_z [N s]", name);
    }
  return out + "\n";
}

std::string probe_row(const std::vector<Probe>& probes, const std::vector<const ShellModel*>& models,
                      const ProbeMoment& now) {
  std::string out = fmt::format("{:.9g}", now.time);
  const auto three = [&](const Vec3& v) { out += fmt::format(",{:.9g},{:.9g},{:.9g}", v.x(), v.y(), v.z()); };
  for (const Probe& p : probes) {
    const std::vector<double> values = values_of(p, now);
    for (const double v : values) out += std::isnan(v) ? "," : fmt::format(",{:.9g}", v);
    const std::string columns = values.empty() ? columns_of(p) : "";
    out.append(std::count(columns.begin(), columns.end(), ','), ',');
  }
  Vec3 sum = Vec3::Zero();
  for (const ShellView& s : now.shells) sum += reaction(*s.model, *s.state, s.gravity);
  if (!now.shells.empty())
    three(sum);
  else
    out += ",,,";
  for (std::size_t k = 0; k < models.size(); ++k)
    for (const Constraints::Part& part : models[k]->constraints.parts) {
      if (now.shells.empty()) {
        out += ",,,,,,";
        continue;
      }
      three(reaction(*models[k], *now.shells[k].state, now.shells[k].gravity, part));
      three(support_impulse(*now.shells[k].state, part));
    }
  return out + "\n";
}

}  // namespace sunder::shell
