#include "shell/geometry/builders.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

using Homogeneous = Eigen::Vector4d;  // (weight * point, weight)

Homogeneous homogeneous(const Patch& p, int k) {
  Homogeneous h;
  h << p.weights[k] * p.control_points[k], p.weights[k];
  return h;
}

// Inserts `knot` into a row of homogeneous control points (Boehm 1980).
void insert_knot(std::vector<double>& knots, int degree, std::vector<Homogeneous>& row, double knot) {
  int k = degree;
  while (k + 1 < static_cast<int>(knots.size()) - degree - 1 && knots[k + 1] <= knot) ++k;
  std::vector<Homogeneous> out(row.begin(), row.begin() + (k - degree + 1));
  for (int i = k - degree + 1; i <= k; ++i) {
    const double a = (knot - knots[i]) / (knots[i + degree] - knots[i]);
    out.push_back((1.0 - a) * row[i - 1] + a * row[i]);
  }
  out.insert(out.end(), row.begin() + k, row.end());
  row = std::move(out);
  knots.insert(knots.begin() + k + 1, knot);
}

// Returns the knots that divide each span s into `pieces(s)` equal parts.
template <class Pieces>
std::vector<double> cut(const KnotVector& k, Pieces&& pieces) {
  std::vector<double> out;
  for (int s = 0; s < k.spans(); ++s)
    for (int i = 1; k.span_length(s) > 0.0 && i < pieces(s); ++i)
      out.push_back(k.span_begin(s) + k.span_length(s) * i / pieces(s));
  return out;
}

std::vector<double> new_knots(const KnotVector& k, int elements, const char* direction) {
  int spans = 0;
  for (int s = 0; s < k.spans(); ++s) spans += k.span_length(s) > 0.0;
  require(spans > 0 && elements >= spans && elements % spans == 0, "{} elements along {}: must be a multiple of {}",
          elements, direction, spans);
  return cut(k, [&](int) { return elements / spans; });
}

std::vector<double> new_knots_at_least(const KnotVector& k, int least) {
  require(least >= 1, "at least {} elements; must be 1 or more", least);
  constexpr double kRoundOff = 1e-9;  // share of a piece: three spans of a third each make three pieces, not four
  const double longest = (k.end() - k.begin()) / least;
  return cut(k,
             [&](int s) { return std::max(1, static_cast<int>(std::ceil(k.span_length(s) / longest - kRoundOff))); });
}

Patch of_degree(const Patch& quadratic, int degree) {
  require(degree == 2 || degree == 3, "degree {}; 2 (quadratic) or 3 (cubic)", degree);
  return degree == 2 ? quadratic : elevated(quadratic);
}

void require_arc(double angle) {
  require(angle > 0.0 && angle < kWidestArc, "an arc of {:.4g} rad; one patch spans more than 0 and less than {:.4g}",
          angle, kWidestArc);
}

// Inserts the knots `at_u` and `at_v`; the surface does not change.
Patch with_knots(const Patch& p, const std::vector<double>& at_u, const std::vector<double>& at_v) {
  std::vector<std::vector<Homogeneous>> net;  // rows along u
  std::vector<double> ku, kv = p.knots_v.knots();
  for (int j = 0; j < p.rows(); ++j) {
    std::vector<Homogeneous> row;
    row.reserve(p.columns() + at_u.size());
    for (int i = 0; i < p.columns(); ++i) row.push_back(homogeneous(p, j * p.columns() + i));
    ku = p.knots_u.knots();
    for (const double knot : at_u) insert_knot(ku, p.degree(), row, knot);
    net.push_back(std::move(row));
  }
  const int columns = static_cast<int>(net[0].size());
  std::vector<std::vector<Homogeneous>> fine(columns);
  for (int i = 0; i < columns; ++i) {
    std::vector<Homogeneous> column;
    column.reserve(net.size() + at_v.size());
    for (const auto& row : net) column.push_back(row[i]);
    kv = p.knots_v.knots();
    for (const double knot : at_v) insert_knot(kv, p.degree(), column, knot);
    fine[i] = std::move(column);
  }
  Patch out{KnotVector(ku, p.degree(), "u"), KnotVector(kv, p.degree(), "v"), {}, {}};
  for (int j = 0; j < out.rows(); ++j)
    for (int i = 0; i < columns; ++i) {
      const Homogeneous& h = fine[i][j];
      out.control_points.emplace_back(h.head<3>() / h[3]);
      out.weights.push_back(h[3]);
    }
  return out;
}

}  // namespace

Patch refined(const Patch& p, int elements_u, int elements_v) {
  return with_knots(p, new_knots(p.knots_u, elements_u, "u"), new_knots(p.knots_v, elements_v, "v"));
}

Patch refined_at_least(const Patch& p, int least_u, int least_v) {
  return with_knots(p, new_knots_at_least(p.knots_u, least_u), new_knots_at_least(p.knots_v, least_v));
}

Patch elevated(const Patch& p) {
  require(p.degree() == 2 && p.columns() == 3 && p.rows() == 3,
          "a patch of degree {} and {} x {} control points; only a single quadratic span is elevated", p.degree(),
          p.columns(), p.rows());
  const auto cubic = [](const KnotVector& k) {
    const double a = k.begin(), b = k.end();
    return KnotVector({a, a, a, a, b, b, b, b}, 3, "knots");
  };
  // Degree elevation of Bezier points: both ends stay, and the middle point contributes two thirds to each inner one.
  constexpr double kFrom[4][3] = {{1, 0, 0}, {1.0 / 3.0, 2.0 / 3.0, 0}, {0, 2.0 / 3.0, 1.0 / 3.0}, {0, 0, 1}};
  Patch out{cubic(p.knots_u), cubic(p.knots_v), {}, {}};
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      Homogeneous h = Homogeneous::Zero();
      for (int b = 0; b < 3; ++b)
        for (int a = 0; a < 3; ++a) h += kFrom[j][b] * kFrom[i][a] * homogeneous(p, 3 * b + a);
      out.control_points.emplace_back(h.head<3>() / h[3]);
      out.weights.push_back(h[3]);
    }
  return out;
}

Patch revolved(const std::array<Vec2, 3>& profile, const std::array<double, 3>& weights, double angle) {
  require_arc(angle);
  const KnotVector one({0, 0, 0, 1, 1, 1}, 2, "knots");
  Patch p{one, one, {}, {}};
  const double half = std::cos(0.5 * angle);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const double at = 0.5 * angle * i, out = i == 1 ? 1.0 / half : 1.0;
      p.control_points.emplace_back(out * profile[j].x() * std::cos(at), out * profile[j].x() * std::sin(at),
                                    profile[j].y());
      p.weights.push_back(weights[j] * (i == 1 ? half : 1.0));
    }
  return p;
}

Patch cylinder(double radius, double length, double angle, int elements_u, int elements_v, int degree) {
  Patch p = revolved({Vec2(radius, 0), Vec2(radius, 0.5 * length), Vec2(radius, length)}, {1, 1, 1}, angle);
  p = placed(p, Vec3::Zero(), Quat(Eigen::AngleAxisd(-0.5 * angle, Vec3::UnitZ())));
  return refined(of_degree(p, degree), elements_u, elements_v);
}

Patch sphere(double radius, double angle, double from, double to, int elements_u, int elements_v, int degree) {
  require(from < to && from >= -0.5 * std::numbers::pi && to <= 0.5 * std::numbers::pi + 1e-12,
          "polar angles from {:.4g} to {:.4g} rad; must rise, within a quarter turn of the equator", from, to);
  require_arc(to - from);
  const double middle = 0.5 * (from + to), half = std::cos(0.5 * (to - from));
  const auto at = [&](double polar, double r) { return Vec2(r * std::cos(polar), r * std::sin(polar)); };
  std::array<Vec2, 3> profile{at(from, radius), at(middle, radius / half), at(to, radius)};
  for (Vec2& p : profile)
    if (p.x() < 1e-12 * radius) p.x() = 0.0;  // exactly at the pole
  return refined(of_degree(revolved(profile, {1, half, 1}, angle), degree), elements_u, elements_v);
}

Patch cone(double bottom, double top, double height, double angle, int elements_u, int elements_v, int degree) {
  const Vec2 a(bottom, 0), b(top, height);
  return refined(of_degree(revolved({a, 0.5 * (a + b), b}, {1, 1, 1}, angle), degree), elements_u, elements_v);
}

Patch placed(Patch patch, const Vec3& position, const Quat& orientation) {
  for (Vec3& p : patch.control_points) p = position + orientation * p;
  return patch;
}

}  // namespace sunder::shell
