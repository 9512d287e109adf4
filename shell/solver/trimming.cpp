#include "shell/solver/trimming.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"
#include "shell/fracture/constants.h"
#include "shell/geometry/seams.h"
#include "shell/mechanics/point_packs.h"
#include "shell/solver/state.h"

namespace sunder::shell {
namespace {

/// [h]: supports of the least squares by which control points outside continue those inside: the least, the most, and
/// the step between those that are tried.
/// numerical: three points in a row make a polynomial of degree 2; more than the largest would look past what
/// visibility does
constexpr double kLeastContinuation = 3.25, kMostContinuation = 5.25, kContinuationStep = 0.25;
/// [-]: most of the sum of magnitudes of the shares that a support may have.
/// numerical: a larger one would continue what lies inside with its error many times over
constexpr double kMostShares = 9.0;
/// [-]: the same of the shares of a mass.
/// numerical: shares of a mass are of degree 1, which continues less far; negative ones take mass away
constexpr double kMostMassShares = 3.0;
/// [of its mass in the whole patch]: a control point of which loops leave less is dropped.
/// numerical: functions of less mass move too stiffly; those of more keep the accuracy of the whole patch beside the
/// loop
constexpr double kLeastMass = 0.03;
constexpr double kSingularShares = 1e-7;  // least over largest eigenvalue of least squares that have an answer
constexpr double kOnPatchEdge = 1e-9;     // distance over the size of the patch at which a loop runs on its edge

// Coefficients of the monomials up to the degree, about `centre` in units of `size`, at a control point: the blossom
// of t^k at its inner knots, an elementary symmetric polynomial over its number of terms.
std::array<double, kHighestDegree + 1> coefficients(const KnotVector& k, int i, double centre, double size) {
  const int degree = k.degree();
  std::array<double, kHighestDegree + 1> e{1.0, 0.0, 0.0, 0.0};
  for (int n = 1; n <= degree; ++n) {
    const double t = (k.knots()[i + n] - centre) / size;
    for (int j = n; j > 0; --j) e[j] += t * e[j - 1];
  }
  constexpr double kTerms[4][4] = {{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 2, 1, 1}, {1, 3, 3, 1}};
  for (int j = 0; j <= degree; ++j) e[j] /= kTerms[degree][j];
  return e;
}

// The spline of MLS functions, over the support.
double weight_at(double r) {
  if (r >= 1.0) return 0.0;
  return r <= 0.5 ? 2.0 / 3.0 - 4.0 * r * r * (1.0 - r) : 4.0 / 3.0 * std::pow(1.0 - r, 3);
}

// Control points that stay, from which others are continued.
struct Continuation {
  const ShellModel& m;
  const std::vector<char>& kept;  // [control point]

  // Shares of control points that stay by which polynomials of `degree` continue to control point i: least squares,
  // with weights that fall with the distance. `along`: only control points of its row (0) or column (1); -1: all. Empty
  // where too few are near.
  std::vector<std::pair<int, double>> shares(int i, int degree, int along, double support) const {
    const Patch& p = m.patch;
    const int columns = p.columns(), u = i % columns, v = i / columns;
    const Vec2 centre = p.greville(i), size(m.spacing_u, m.spacing_v);
    std::vector<int> near;
    std::vector<double> weights;
    std::vector<Eigen::VectorXd> rows;
    const int reach = static_cast<int>(std::ceil(support)) + 1;
    const auto row_of = [&](int k) {
      const auto a = coefficients(p.knots_u, k % columns, centre.x(), size.x());
      const auto b = coefficients(p.knots_v, k / columns, centre.y(), size.y());
      std::vector<double> terms;
      for (int n = 0; n <= degree; ++n)
        for (int j = 0; j <= n; ++j)
          if (along < 0 || j == (along == 0 ? 0 : n)) terms.push_back(a[n - j] * b[j]);
      return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(terms.data(), static_cast<Eigen::Index>(terms.size())));
    };
    for (int j = std::max(0, v - reach); j <= std::min(p.rows() - 1, v + reach); ++j)
      for (int k = std::max(0, u - reach); k <= std::min(columns - 1, u + reach); ++k) {
        const int at = j * columns + k;
        if (!kept[at] || (along == 0 && j != v) || (along == 1 && k != u)) continue;
        const Vec2 d = (p.greville(at) - centre).cwiseAbs().cwiseQuotient(size);
        const double w = weight_at(d.x() / support) * weight_at(d.y() / support);
        if (w > 0.0) near.push_back(at), weights.push_back(w), rows.push_back(row_of(at));
      }
    const Eigen::VectorXd wanted = row_of(i);
    const auto terms = wanted.size();
    if (static_cast<Eigen::Index>(near.size()) < terms) return {};
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(terms, terms);
    for (std::size_t k = 0; k < near.size(); ++k) a += weights[k] * rows[k] * rows[k].transpose();
    const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
    const auto [values, vectors] = eigenpairs(scale.asDiagonal() * a * scale.asDiagonal());
    if (!(values[0] > kSingularShares * values[terms - 1])) return {};
    std::vector<std::pair<int, double>> out;
    for (const int k : near) out.emplace_back(k, 0.0);
    Eigen::VectorXd missing = wanted;
    for (int pass = 0; pass < 2; ++pass) {  // the second takes away the round-off of the first
      const Eigen::VectorXd answer =
          scale.asDiagonal() * (vectors * (vectors.transpose() * (scale.asDiagonal() * missing)).cwiseQuotient(values));
      for (std::size_t k = 0; k < near.size(); ++k) {
        const double share = weights[k] * rows[k].dot(answer);
        out[k].second += share, missing -= share * rows[k];
      }
    }
    return out;
  }

  // The shares of the smallest support that does not amplify more than `most`, or else of the one that amplifies least.
  std::vector<std::pair<int, double>> best(int i, int degree, int along, double most) const {
    std::vector<std::pair<int, double>> found;
    double least = std::numeric_limits<double>::infinity();
    for (double support = kLeastContinuation; support <= kMostContinuation; support += kContinuationStep) {
      std::vector<std::pair<int, double>> now = shares(i, degree, along, support);
      double sum = 0.0;
      for (const auto& [k, share] : now) sum += std::abs(share);
      if (now.empty() || !(sum < least)) continue;
      least = sum, found = std::move(now);
      if (least <= most) break;
    }
    return found;
  }
};

std::string place_of(const ShellModel& m, int i) {
  const Vec2 p = m.patch.greville(i);
  return fmt::format("({:.4g}, {:.4g})", p.x(), p.y());
}

// The direction of the edge of the patch along which a support holds a control point: 0 or 1; -1: none.
int held_along(const ShellModel& m, const std::vector<char>& held, int i) {
  if (!held[m.tables.slot(i)]) return -1;
  const int columns = m.patch.columns(), rows = m.patch.rows(), u = i % columns, v = i / columns;
  if (v < 2 || v >= rows - 2) return 0;
  return u < 2 || u >= columns - 2 ? 1 : -1;
}

// Whether both points lie on one edge of the patch, where a loop is no border of its own.
bool on_one_edge(const Patch& p, const Vec2& a, const Vec2& b) {
  const Vec2 low(p.knots_u.begin(), p.knots_v.begin()), high(p.knots_u.end(), p.knots_v.end());
  const double near = kOnPatchEdge * (high - low).norm();
  for (int d = 0; d < 2; ++d)
    for (const double at : {low[d], high[d]})
      if (std::max(std::abs(a[d] - at), std::abs(b[d] - at)) <= near) return true;
  return false;
}

// Whether a stretch of a loop at which ties hold another shell passes p.
bool on_tied(const ShellModel& m, const Vec2& p) {
  for (const std::vector<Vec2>& line : m.trim.tied)
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      const Vec2 d = line[k + 1] - line[k];
      const double share = std::clamp((p - line[k]).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
      if ((p - line[k] - share * d).norm() < kOnTied * m.spacing) return true;
    }
  return false;
}

std::vector<char> held_slots(const ShellModel& m) {
  std::vector<char> held(m.tables.component_stride, 0);
  for (int d = 0; d < 3; ++d) {
    for (const int slot : m.constraints.held[d]) held[slot] = 1;
    for (const auto& driven : m.constraints.driven)
      for (const int slot : driven.slots[d]) held[slot] = 1;
  }
  return held;
}

// Mass of each control point in the whole patch, as a share of what one inside an even patch has.
std::vector<double> whole_masses(const ShellModel& m) {
  const Patch& p = m.patch;
  std::vector<double> out;
  const auto& u = p.knots_u.knots();
  const auto& v = p.knots_v.knots();
  const int degree = p.degree();
  for (int i = 0; i < m.control_points(); ++i) {
    const int a = i % p.columns(), b = i / p.columns();
    out.push_back((u[a + degree + 1] - u[a]) * (v[b + degree + 1] - v[b]) / ((degree + 1.0) * (degree + 1.0)));
  }
  return out;
}

// Which control points stay: those whose functions have some of their mass left, wherever they lie.
std::vector<char> points_kept(const ShellModel& m) {
  const std::vector<double> whole = whole_masses(m);
  std::vector<double> area(m.control_points(), 0.0);
  const RowTables& t = m.tables;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const GaussPoint g = gauss_point(m.patch, t, q, e);
      if (g.weight == 0.0) continue;
      const ShapeFunctions n = m.patch.shape_functions(g.parameter);
      for (int k = 0; k < n.count(); ++k) area[n.row(k) * t.columns + n.column(k)] += g.weight * n.value[k];
    }
  std::vector<char> kept(m.control_points(), 0);
  for (int i = 0; i < m.control_points(); ++i) kept[i] = area[i] > kLeastMass * whole[i];
  return kept;
}

// Finds where dropped control points lie. Those that no Gauss point uses stay where they are.
void drop_points(ShellModel& m, const std::vector<char>& kept) {
  Trimming& trim = m.trim;
  const Continuation from{m, kept};
  const std::vector<char> held = held_slots(m);
  trim.dropped_of.assign(m.tables.component_stride, -1);
  for (int i = 0; i < m.control_points(); ++i) {
    if (kept[i]) continue;
    const int slot = m.tables.slot(i);
    DroppedPoint d{slot, {}};
    if (m.mass[slot] > 0.0) {
      const int along = held_along(m, held, i);
      std::vector<std::pair<int, double>> on;
      if (along >= 0) on = from.best(i, m.patch.degree(), along, kMostShares);
      if (on.empty()) on = from.best(i, m.patch.degree(), -1, kMostShares);
      require(!on.empty(),
              "the part beside control point {} is too narrow for the control points in it; leave it out, or take more "
              "elements",
              place_of(m, i));
      Vec3 x = Vec3::Zero();
      for (const auto& [k, share] : on) x += share * m.patch.control_points[k];
      m.patch.control_points[i] = x;
      for (const auto& [k, share] : on) d.on.emplace_back(m.tables.slot(k), share);
      for (int axis = 0; axis < 3; ++axis)
        m.rest[static_cast<std::size_t>(axis) * m.tables.component_stride + slot] = x[axis];
    }
    trim.dropped_of[slot] = static_cast<int>(trim.dropped.size());
    trim.dropped.push_back(std::move(d));
  }
}

// Moves the masses of dropped control points inside. Shares that continue linear functions keep the mass and its first
// moment; those of stiffness would make masses negative.
void move_masses(ShellModel& m, const std::vector<char>& kept) {
  const Continuation from{m, kept};
  const std::vector<double> before = m.mass;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (kept[i] || before[slot] == 0.0) continue;
    for (const auto& [k, share] : from.best(i, 1, -1, kMostMassShares))
      m.mass[m.tables.slot(k)] += share * before[slot];
    m.mass[slot] = 0.0;
  }
  for (int i = 0; i < m.control_points(); ++i)
    require(!kept[i] || m.mass[m.tables.slot(i)] > 0.0,
            "the part beside control point {} is too narrow for the control points in it; leave it out, or take more "
            "elements",
            place_of(m, i));
}

// Functions beside a crack use no control point that is dropped, outside, or light: they spread stiffness more evenly
// than mass.
void hide_light_points(ShellModel& m) {
  const std::vector<double> whole = whole_masses(m);
  m.trim.absent.assign(m.control_points(), 0);
  for (int i = 0; i < m.control_points(); ++i)
    m.trim.absent[i] = m.mass[m.tables.slot(i)] < kLightMass * m.mass_per_area(m.tables.slot(i)) * whole[i];
  for (const int i : m.trim.outside) m.trim.absent[i] = 1;
}

// Gauss points whose functions are not those of the rows.
void find_points(ShellModel& m) {
  Trimming& trim = m.trim;
  const RowTables& t = m.tables;
  const int each = t.gauss * t.gauss;
  trim.point_of.assign(static_cast<std::size_t>(t.blocks()) * t.lanes, -1);
  trim.reach = t.degree;
  for (int f = 0; f < t.spans_v; ++f)
    for (int e = 0; e < t.spans_u; ++e) {
      bool own = !is_whole_element(m.patch, t, e, f);  // a loop along its border leaves it in the rows
      for (int k = 0; k < t.support() * t.support() && !own; ++k)
        own = trim.drops((f + k / t.support()) * t.stride + e + k % t.support());
      for (int q = f * each; q < (f + 1) * each && own; ++q) {
        const GaussPoint at = gauss_point(m.patch, t, q, e);
        if (at.weight == 0.0) continue;
        GatheredPoint g;
        g.block = q, g.lane = e, g.kind = PointKind::kQuadratic;
        g.area = t.metric[t.at(q, kMetricFields, kArea, e)];
        g.functions = shell_functions(m, at.parameter);
        thicken(g.functions, t.thickness_factor(q, e));
        round_to_units(g.functions);  // packs of 32 bits hold them
        const Forms<double> rest = surface_forms(gather(t, g, m.rest));
        g.metric = {rest.a, rest.b};
        int low_u = t.columns, high_u = 0, low_v = t.rows, high_v = 0;
        for (const GatheredFunction& n : g.functions) {
          const int u = n.slot % t.stride, v = n.slot / t.stride;
          low_u = std::min(low_u, u), high_u = std::max(high_u, u), low_v = std::min(low_v, v),
          high_v = std::max(high_v, v);
        }
        trim.reach = std::max({trim.reach, high_u - low_u, high_v - low_v});
        trim.point_of[static_cast<std::size_t>(q) * t.lanes + e] = static_cast<int>(trim.points.size());
        trim.points.push_back(std::move(g));
      }
    }
}

}  // namespace

void note_ties(const std::vector<Seam>& seams, const std::vector<ShellModel*>& models) {
  for (ShellModel* m : models) m->trim.tied.clear();
  for (const Seam& seam : seams)
    for (const bool first : {true, false}) {
      if (!seam.trimmed() || seam.join != Join::kClamped) continue;
      std::vector<Vec2> line;
      for (const SeamPlace& place : seam.places) line.push_back(first ? place.first : place.second);
      if (seam.closed) line.push_back(line.front());
      models[first ? seam.first : seam.second]->trim.tied.push_back(std::move(line));
    }
}

void trim_supports(const Trimming& trim, Constraints& c) {
  const auto thin = [&](std::vector<int>& slots) { std::erase_if(slots, [&](int slot) { return trim.drops(slot); }); };
  for (int d = 0; d < 3; ++d) {
    thin(c.held[d]);
    for (auto& group : c.tied[d]) thin(group);
    std::erase_if(c.tied[d], [](const std::vector<int>& group) { return group.size() < 2; });
    for (auto& driven : c.driven) thin(driven.slots[d]);
  }
  thin(c.anchors);
  for (Constraints::Part& part : c.parts) {
    const auto empty = [&] {
      return std::all_of(part.slots.begin(), part.slots.end(), [](const auto& slots) { return slots.empty(); });
    };
    const bool held = !empty();
    for (auto& slots : part.slots) thin(slots);
    require(!held || !empty(), "{} holds no control point inside the trims; hold a part that they leave", part.name);
  }
}

namespace {

// Loads act on what is inside; on an edge, on the samples inside.
void trim_loads(ShellModel& m) {
  for (PreparedLoad& load : m.loads.beside) {
    std::vector<LoadSample> left;
    for (LoadSample& sample : load.samples) {
      if (!m.trim.loops.contains(sample.at)) continue;
      without_dropped(m, sample.at, sample.functions);
      left.push_back(std::move(sample));
    }
    require(!left.empty(), "a load at ({:.6g}, {:.6g}) lies outside the trims; move it to the part that they leave",
            load.samples.front().at.x(), load.samples.front().at.y());
    load.samples = std::move(left);
  }
}

}  // namespace

void without_dropped(const ShellModel& m, const Vec2& p, std::vector<GatheredFunction>& functions) {
  const Trimming& trim = m.trim;
  if (std::none_of(functions.begin(), functions.end(), [&](const auto& f) { return trim.drops(f.slot); })) return;
  std::vector<GatheredFunction> out;
  const auto add = [&](int slot, const std::array<double, 6>& n, double share) {
    auto at = std::find_if(out.begin(), out.end(), [&](const auto& f) { return f.slot == slot; });
    if (at == out.end()) at = out.insert(out.end(), {slot, {}});
    for (int k = 0; k < 6; ++k) at->n[k] += share * n[k];
  };
  for (const GatheredFunction& f : functions) {
    if (!trim.drops(f.slot)) {
      add(f.slot, f.n, 1.0);
      continue;
    }
    for (const auto& [slot, share] : trim.dropped[trim.dropped_of[f.slot]].on) add(slot, f.n, share);
  }
  const auto away = [&](const GatheredFunction& f) {
    return (m.parameter_of_slot[f.slot] - p).cwiseAbs().cwiseQuotient(Vec2(m.spacing_u, m.spacing_v)).maxCoeff();
  };
  std::stable_sort(out.begin(), out.end(), [&](const auto& a, const auto& b) { return away(a) < away(b); });
  functions = std::move(out);
}

std::vector<GatheredFunction> shell_functions(const ShellModel& m, const Vec2& p) {
  std::vector<GatheredFunction> out = patch_functions(m.patch, p, m.tables.stride);
  if (!m.trim.empty()) without_dropped(m, p, out);
  return out;
}

void shell_functions(const ShellModel& m, int block, int lane, std::vector<GatheredFunction>& out) {
  const int own = m.trim.empty() ? -1 : m.trim.point_of[static_cast<std::size_t>(block) * m.tables.lanes + lane];
  if (own >= 0)
    out = m.trim.points[own].functions;
  else
    patch_functions(m.patch, gauss_point(m.patch, m.tables, block, lane).parameter, m.tables.stride, out),
        thicken(out, m.tables.thickness_factor(block, lane));
}

void update_dropped_points(const Trimming& trim, std::vector<double>& field) {
  const std::size_t stride = field.size() / 3;
  for (const DroppedPoint& d : trim.dropped) {
    if (d.on.empty()) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (const auto& [slot, share] : d.on) sum += share * field[axis * stride + slot];
      field[axis * stride + d.slot] = sum;
    }
  }
}

void trim_state(const ShellModel& m, ShellState& s) {
  const Trimming& trim = m.trim;
  const RowTables& t = m.tables;
  for (const DroppedPoint& d : trim.dropped) {
    s.motion.detached[d.slot] = 1, s.motion.mass[d.slot] = s.motion.inverse_mass[d.slot] = 0.0;
    for (int axis = 0; axis < 3; ++axis) s.motion.v[static_cast<std::size_t>(axis) * t.component_stride + d.slot] = 0.0;
  }
  s.cracked.gathered = trim.points, s.cracked.point_of = trim.point_of;
  if (m.laminated()) s.cracked.of_interlayer = trim.points;
  for (const GatheredPoint& g : trim.points) {
    if (m.laminated()) s.cracked.interlayer.metric[t.at(g.block, kMetricFields, kArea, g.lane)] = 0.0;
    const std::size_t gauss = static_cast<std::size_t>(g.block) * t.lanes + g.lane;
    s.cracked.tables.metric[t.at(g.block, kMetricFields, kArea, g.lane)] = 0.0;
    const Vec2 p = gauss_point(m.patch, t, g.block, g.lane).parameter;
    double reach = 0.0;
    for (const GatheredFunction& f : g.functions)
      reach = std::max(
          reach, (m.parameter_of_slot[f.slot] - p).cwiseAbs().cwiseQuotient(Vec2(m.spacing_u, m.spacing_v)).maxCoeff());
    s.cracked.reach[gauss] = static_cast<float>(reach * (1.0 + 1e-6));
  }
  for (std::size_t gauss = 0; gauss < t.trimmed.size(); ++gauss)
    if (t.trimmed[gauss].weight == 0.0) s.cracked.kind_of[gauss] = static_cast<char>(PointKind::kDead);
  CrackGraph& graph = s.cracks.graph;
  for (const TrimLoop& loop : trim.loops.loops()) {
    int first = -1, last = -1;
    for (std::size_t k = 0; k + 1 < loop.points.size(); ++k) {
      const Vec2 &a = loop.points[k], &b = loop.points[k + 1];
      const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / m.spacing)));
      for (int i = 0; i < pieces; ++i) {
        const bool ends = k + 2 == loop.points.size() && i + 1 == pieces;
        if (first < 0) first = last = graph.add_vertex(a);
        const int to = ends ? first : graph.add_vertex(a + (b - a) * ((i + 1.0) / pieces));
        const Vec2 &from = graph.vertices()[last], &end = graph.vertices()[to];
        if (!on_one_edge(m.patch, from, end)) graph.add_trim(last, to, on_tied(m, 0.5 * (from + end)));
        last = to;
      }
    }
  }
  s.cracks.interlock_of.assign(graph.edges().size(), -1);
}

bool is_uncracked(const ShellModel& m, const ShellState& s) {
  return !s.cracks.graph.has_cracks() && s.cracked.gathered.size() == m.trim.points.size();
}

void trim_shell(ShellModel& m, const TrimLoops& loops) {
  m.trim.loops = loops;
  const std::vector<char> kept = points_kept(m);
  require(std::any_of(kept.begin(), kept.end(), [](char c) { return c != 0; }),
          "the trims leave no control point of the patch, whose spacing is {:.3g} m; leave more, or take more elements",
          m.spacing);
  for (int i = 0; i < m.control_points(); ++i)
    m.trim.home.push_back(kept[i] ? loops.moved_inside(m.parameter[i], kHomeInside * m.spacing) : m.parameter[i]);
  for (int i = 0; i < m.control_points(); ++i)
    if (m.trim.home[i] != m.parameter[i]) m.trim.outside.push_back(i);
  drop_points(m, kept);
  move_masses(m, kept);
  hide_light_points(m);
  find_points(m);
  trim_supports(m.trim, m.constraints);
  trim_loads(m);
}

}  // namespace sunder::shell
