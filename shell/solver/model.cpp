#include "shell/solver/model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/core/error.h"
#include "shell/geometry/edges.h"
#include "shell/geometry/parameter_place.h"
#include "shell/mechanics/point_force.h"

namespace sunder::shell {

namespace {

constexpr int kCoreLayers = 2;  // layers of an interlayer

// Finds which slots are held along all axes, and the edges that are held with their slopes.
void find_held(const ShellModel& m, const Constraints& c, std::vector<char>& held, int& clamped) {
  const RowTables& t = m.tables;
  std::vector<int> axes(t.component_stride, 0);
  for (const auto& slots : c.held)
    for (const int slot : slots) ++axes[slot];
  for (const auto& driven : c.driven)
    for (const auto& slots : driven.slots)
      for (const int slot : slots) ++axes[slot];
  held.assign(t.component_stride, 0), clamped = 0;
  for (int i = 0; i < t.component_stride; ++i) held[i] = axes[i] >= 3;
  const auto holds = [&](int edge, int depth) {
    const std::vector<int> row = edge_row(m.patch, edge, depth);
    const auto stays = [&](int i) { return !m.trim.drops(t.slot(i)); };
    return std::any_of(row.begin(), row.end(), stays) &&
           std::all_of(row.begin(), row.end(), [&](int i) { return held[t.slot(i)] != 0 || !stays(i); });
  };
  for (const int edge : kEdges)
    if (holds(edge, 0) && holds(edge, 1)) clamped |= edge;
}

// Finds the control points in the boxes of supports. A control point is at the place of the surface at its home.
std::vector<Support> with_boxes_found(const ShellModel& m, std::vector<Support> supports) {
  const double tolerance = edge_tolerance(m.patch);  // of a border of a box that a scene rounds
  for (Support& s : supports) {
    s.in_boxes.assign(s.boxes.size(), {});
    for (int i = 0; i < m.control_points() && !s.boxes.empty(); ++i) {
      if (m.trim.drops(m.tables.slot(i))) continue;
      const Vec3 x = m.patch.evaluate(m.trim.empty() ? m.parameter[i] : m.trim.home[i]).x;
      for (std::size_t b = 0; b < s.boxes.size(); ++b)
        if ((x.array() >= s.boxes[b].low.array() - tolerance).all() &&
            (x.array() <= s.boxes[b].high.array() + tolerance).all())
          s.in_boxes[b].push_back(i);
    }
  }
  return supports;
}

// Stages of the supports after each time at which some of them are released.
std::vector<SupportStage> find_releases(const ShellModel& m, const std::vector<Support>& supports) {
  std::vector<double> times;
  for (const Support& s : supports)
    if (std::isfinite(s.until)) times.push_back(s.until);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::vector<SupportStage> stages;
  for (const double time : times) {
    SupportStage& stage = stages.emplace_back();
    stage.from = time;
    stage.constraints = make_constraints(m.patch, supports, m.tables.stride, "shell '" + m.name + "'", time);
    if (!m.trim.empty()) trim_supports(m.trim, stage.constraints);
    find_held(m, stage.constraints, stage.held, stage.clamped);
  }
  return stages;
}

}  // namespace

double ShellModel::wave_speed() const {
  return std::sqrt(material.youngs_modulus / (1.0 - material.poisson_ratio * material.poisson_ratio) /
                   material.density);
}

bool ShellModel::wholly_held() const {
  for (int i = 0; i < control_points(); ++i)
    if (const int slot = tables.slot(i); held[slot] == 0 && !trim.drops(slot)) return false;
  return true;
}

double ShellModel::rayleigh_speed() const {  // Viktorov's fit to the Rayleigh equation
  const double nu = material.poisson_ratio;
  return std::sqrt(tables.elasticity.mu / material.density) * (0.862 + 1.14 * nu) / (1.0 + nu);
}

double ShellModel::response_time() const {
  return std::max(spacing / wave_speed(), largest_thickness() / std::sqrt(tables.elasticity.mu / material.density));
}

double largest_mobility(const ShellModel& m) {
  std::vector<GatheredFunction> functions;
  double largest = 0.0;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      if (m.tables.metric[m.tables.at(q, kMetricFields, kArea, e)] == 0.0) continue;
      double sum = 0.0;
      shell_functions(m, q, e, functions);
      for (const auto& f : functions) sum += f.n[0] * f.n[0] / m.mass[f.slot];
      largest = std::max(largest, 2.0 * sum);
    }
  return largest;
}

double ShellModel::thickness_at(const Vec2& p) const {
  if (!varies()) return thickness;
  const Vec2 inside(std::clamp(p.x(), patch.knots_u.begin(), patch.knots_u.end()),
                    std::clamp(p.y(), patch.knots_v.begin(), patch.knots_v.end()));
  return thickness * thickness_factor(patch, inside);
}

ShellModel make_shell(const std::string& name, const Patch& patch, double thickness, const ShellMaterial& material,
                      int layers, int gauss, const std::vector<Support>& supports, const std::vector<Load>& loads,
                      const TrimLoops& trim, const ThicknessFactor& factor) {
  ShellModel m{name, with_parameters_as_lengths(patch), thickness, material};
  const Interlayer& core = material.interlayer;
  m.material.density += (core.density - material.density) * core.thickness / thickness;
  const Elasticity e = elasticity(material, material.stress_model);
  Layers rule = material.linear_bending ? linear_bending(thickness)
                : m.laminated()         ? plies(layers, thickness, core.thickness)
                                        : gauss_layers(layers, thickness);
  if (material.surface_compression > 0.0) prestress(rule, thickness, material.surface_compression, e);
  m.tables = make_row_tables(m.patch, gauss, rule, e, "shell '" + name + "'", trim, factor);
  m.thickness_factor = factor;
  ensure(!factor || !m.laminated(), "shell '{}' has an interlayer and a thickness that varies", name);
  if (m.laminated()) {
    const Elasticity soft = elasticity({core.youngs_modulus, core.poisson_ratio}, material.stress_model);
    m.interlayer =
        make_row_tables(m.patch, gauss, gauss_layers(kCoreLayers, core.thickness), soft, "shell '" + name + "'", trim);
  }
  const RowTables& t = m.tables;
  m.mass.assign(t.component_stride, 0.0);
  std::vector<double> area_of_slot(factor ? t.component_stride : 0, 0.0);
  if (factor) m.thinnest = std::numeric_limits<double>::infinity(), m.thickest = 0.0;
  // m_I = integral of rho tau N_I: the row sum of the consistent mass; it is positive for B-splines.
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double area = t.metric[t.at(q, kMetricFields, kArea, e)];
      if (area == 0.0) continue;
      const ShapeFunctions s = m.patch.shape_functions(gauss_point(m.patch, t, q, e).parameter);
      for (int k = 0; k < s.count(); ++k)
        m.mass[s.row(k) * t.stride + s.column(k)] += m.material.density * thickness * area * s.value[k];
      if (!factor) continue;
      const double f = t.thickness_factor(q, e);
      m.thinnest = std::min(m.thinnest, f), m.thickest = std::max(m.thickest, f);
      for (int k = 0; k < s.count(); ++k) area_of_slot[s.row(k) * t.stride + s.column(k)] += area / f * s.value[k];
    }
  for (std::size_t i = 0; i < area_of_slot.size(); ++i)
    m.thickness_of_slot.push_back(area_of_slot[i] > 0.0 ? m.mass[i] / (m.material.density * thickness * area_of_slot[i])
                                                        : 1.0);
  m.rest.assign(3 * static_cast<std::size_t>(t.component_stride), 0.0);
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d)
      m.rest[static_cast<std::size_t>(d) * t.component_stride + t.slot(i)] = m.patch.control_points[i][d];
  m.held.assign(t.component_stride, 0);
  m.constraints = make_constraints(m.patch, supports, t.stride, "shell '" + name + "'");
  m.loads = prepare_loads(m.patch, t, loads, "shell '" + name + "'");
  m.parameter_of_slot.assign(t.component_stride, Vec2::Zero());
  for (int i = 0; i < m.control_points(); ++i) {
    m.parameter.push_back(m.patch.greville(i));
    m.parameter_of_slot[t.slot(i)] = m.parameter.back();
  }
  m.spacing_u = (m.patch.knots_u.end() - m.patch.knots_u.begin()) / t.spans_u;
  m.spacing_v = (m.patch.knots_v.end() - m.patch.knots_v.begin()) / t.spans_v;
  m.spacing = std::sqrt(m.spacing_u * m.spacing_v);
  if (!trim.empty()) trim_shell(m, trim);
  const std::vector<Support> found = with_boxes_found(m, supports);
  if (std::any_of(found.begin(), found.end(), [](const Support& s) { return !s.boxes.empty(); })) {
    m.constraints = make_constraints(m.patch, found, t.stride, "shell '" + name + "'");
    if (!trim.empty()) trim_supports(m.trim, m.constraints);
  }
  find_held(m, m.constraints, m.held, m.clamped);
  m.releases = find_releases(m, found);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double* metric = &t.metric[t.at(q, kMetricFields, 0, e)];
      if (metric[kArea * t.lanes] == 0.0) continue;
      const double along_u = m.patch.knots_u.span_length(e), along_v = m.patch.knots_v.span_length(q / (gauss * gauss));
      m.longest_element = std::max({m.longest_element, along_u * std::sqrt(metric[kA11 * t.lanes]),
                                    along_v * std::sqrt(metric[kA22 * t.lanes])});
      const double least =
          std::min(along_u * std::sqrt(metric[kA11 * t.lanes]), along_v * std::sqrt(metric[kA22 * t.lanes]));
      m.shortest_element = m.shortest_element > 0.0 ? std::min(m.shortest_element, least) : least;
    }
  m.largest_mobility = largest_mobility(m);
  return m;
}

}  // namespace sunder::shell
