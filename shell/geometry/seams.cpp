#include "shell/geometry/seams.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

constexpr int kSamples = 16;      // samples along an edge, where two edges are compared
constexpr double kSagitta = 0.2;  // largest rise of a bent edge above the chord between two samples [chord lengths]
constexpr int kSections = 48;     // steps that bracket the nearest point of an edge, each by a third
constexpr double kNear = 0.2;     // edges within this share of the finer edge's mean spacing nearly meet
// largest offset of a smooth seam's row from the line between the rows beside it [their distance]
constexpr double kStraight = 1e-6;
constexpr double kLeastShare = 0.02;  // least share of either neighbouring row in a smooth seam's row
// normals with a larger cosine in absolute value are clearly on one side or on opposite sides
constexpr double kAskew = 0.1;
constexpr double kAtPole = 1e-9;    // shorter over longer tangent at a pole
constexpr double kSameKnot = 1e-9;  // share of the edge's domain
constexpr double kNoWeight = 1e-13;

using Terms = std::vector<std::pair<PatchPoint, double>>;

// One edge of a patch as a rational curve with a parameter from 0 to 1.
struct EdgeCurve {
  int patch = 0, edge = 0, degree = 2;
  std::vector<double> knots;     // 0 to 1
  std::vector<int> row, second;  // control points of the edge and of the row beside it, by growing parameter
  std::vector<Vec3> samples;
};

EdgeCurve edge_curve(const Patch& p, int patch, int edge, bool reversed) {
  EdgeCurve c;
  c.patch = patch, c.edge = edge, c.degree = p.degree();
  const KnotVector& k = edge <= kUMax ? p.knots_v : p.knots_u;
  for (const double knot : k.knots()) {
    const double share = (knot - k.begin()) / (k.end() - k.begin()), last = c.knots.empty() ? 0.0 : c.knots.back();
    c.knots.push_back(share - last <= kSameKnot ? last : share >= 1.0 - kSameKnot ? 1.0 : share);
  }
  c.row = edge_row(p, edge, 0), c.second = edge_row(p, edge, 1);
  for (int i = 0; i <= kSamples; ++i) c.samples.push_back(p.evaluate(edge_point(p, edge, double(i) / kSamples)).x);
  if (reversed) {
    std::reverse(c.row.begin(), c.row.end()), std::reverse(c.second.begin(), c.second.end());
    std::reverse(c.samples.begin(), c.samples.end()), std::reverse(c.knots.begin(), c.knots.end());
    for (double& knot : c.knots) knot = 1.0 - knot;  // exact: 0 and 1 change places
  }
  return c;
}

double spacing(const EdgeCurve& c) {
  double length = 0.0;
  for (int i = 0; i < kSamples; ++i) length += (c.samples[i + 1] - c.samples[i]).norm();
  return length / static_cast<double>(c.row.size() - c.degree);
}

// Returns the mean of all products of `count` out of `p` knots (2 or 3), measured from `begin` in units of `size`.
double mean_product(const double* knots, int p, std::size_t count, double begin, double size) {
  double sums[kHighestDegree + 1] = {1.0};  // elementary symmetric polynomials
  for (int k = 0; k < p; ++k)
    for (int c = k + 1; c > 0; --c) sums[c] += sums[c - 1] * (knots[k] - begin) / size;
  constexpr double kChoose[2][4] = {{1, 2, 1, 0}, {1, 3, 3, 1}};
  return sums[count] / kChoose[p - 2][count];
}

// Matrix that expresses the control points of `to` by those of `from`, for a curve of degree 2 or 3. Control point i of
// `to` is the blossom of a polynomial at the inner knots of that point. The polynomial passes through degree + 1 points
// of the curve in one span of the point's support; spans are averaged by length. This is exact knot insertion where
// `to` has all knots of `from`; elsewhere it still reproduces polynomials. The matrix is local: end points depend on
// end points alone, inner ones on their neighbours. Least squares over the whole edge would couple distant points, so
// that a piece that detaches at one end would release points at the other.
Eigen::MatrixXd dependence_matrix(const EdgeCurve& from, const EdgeCurve& to) {
  const KnotVector knots(from.knots, from.degree, "seam");
  const int p = to.degree, columns = static_cast<int>(from.row.size()), rows = static_cast<int>(to.row.size());
  if (std::equal(from.knots.begin(), from.knots.end(), to.knots.begin(), to.knots.end(),
                 [](double a, double b) { return std::abs(a - b) <= kSameKnot; }))
    return Eigen::MatrixXd::Identity(rows, columns);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows, columns);
  const auto add_value = [&](int row, double at, double weight) {
    const int span = knots.span_of(at);
    const Basis b = knots.basis(span, at);
    for (int k = 0; k <= p; ++k) out(row, span + k) += weight * b.value[k];
  };
  for (int i = 0; i < rows; ++i) {
    const double* inner = &to.knots[i + 1];  // p knots
    const double length = inner[p - 1] - inner[0];
    if (length <= kSameKnot) {
      add_value(i, inner[0], 1.0);
      continue;
    }
    for (int span = 0; span + 1 < p; ++span) {
      const double begin = inner[span], size = inner[span + 1] - begin;
      if (size <= kSameKnot) continue;
      for (int k = 0; k <= p; ++k) {
        // Coefficients of the Lagrange polynomial of point k; its variable t runs from 0 to 1 over the span.
        std::vector<double> polynomial{1.0};
        for (int other = 0; other <= p; ++other) {
          if (other == k) continue;
          const double root = double(other) / p, scale = double(k) / p - root;
          polynomial.push_back(0.0);
          for (std::size_t c = polynomial.size(); c-- > 0;)
            polynomial[c] = ((c > 0 ? polynomial[c - 1] : 0.0) - root * polynomial[c]) / scale;
        }
        double weight = 0.0;  // its blossom: t^c becomes the mean of all products of c knots
        for (std::size_t c = 0; c < polynomial.size(); ++c)
          weight += polynomial[c] * mean_product(inner, p, c, begin, size);
        add_value(i, k == p ? inner[span + 1] : begin + size * k / p, weight * size / length);
      }
    }
  }
  return out;
}

Terms normalised(Terms terms) {
  double sum = 0.0;
  terms.erase(std::remove_if(terms.begin(), terms.end(), [](const auto& t) { return std::abs(t.second) < kNoWeight; }),
              terms.end());
  for (const auto& [point, weight] : terms) sum += weight;
  for (auto& [point, weight] : terms) weight /= sum;
  return terms;
}

Vec3 mean(const std::vector<const Patch*>& patches, const Terms& terms) {
  Vec3 x = Vec3::Zero();
  for (const auto& [p, weight] : terms) x += weight * patches[p.patch]->control_points[p.point];
  return x;
}

// Collects dependences and resolves chains of them: in the result no point depends on another dependent point.
class Resolver {
 public:
  explicit Resolver(const std::function<bool(const PatchPoint&)>& held) : held_(held) {}

  void depend(const PatchPoint& point, const Terms& on) {
    if (held(point)) {
      if (on.size() == 1 && !held(on[0].first)) of_[on[0].first] = {{point, 1.0}};
      return;
    }
    std::map<PatchPoint, double> terms = expanded(on);
    if (of_.count(point)) {  // a corner, where several seams meet
      const std::map<PatchPoint, double> known = expanded({{point, 1.0}});
      if (terms == known || terms.empty() || (known.size() == 1 && held(known.begin()->first))) return;
      if (terms.size() == 1 && held(terms.begin()->first)) {
        of_[point] = terms;
        return;
      }
      if (terms.size() == 1 && !known.count(terms.begin()->first))
        of_[terms.begin()->first] = known;
      else if (known.size() == 1 && !terms.count(known.begin()->first))
        of_[known.begin()->first] = terms;
      return;  // two means of several points each; they agree where the seams agree
    }
    const auto self = terms.find(point);
    if (self != terms.end()) {
      const double rest = 1.0 - self->second;
      if (std::abs(rest) < 1e-9) return;
      terms.erase(self);
      for (auto& [other, weight] : terms) weight /= rest;
    }
    of_[point] = terms;
  }

  std::vector<Dependence> all() const {
    std::vector<Dependence> out;
    for (const auto& [point, terms] : of_) {
      const auto resolved = expanded({terms.begin(), terms.end()});
      out.push_back({point, normalised({resolved.begin(), resolved.end()})});
    }
    return out;
  }

 private:
  std::map<PatchPoint, double> expanded(const Terms& terms, int depth = 0) const {
    ensure(depth < 64, "seams tie control points in a circle");
    std::map<PatchPoint, double> out;
    for (const auto& [point, weight] : terms) {
      const auto it = of_.find(point);
      if (it == of_.end()) {
        out[point] += weight;
        continue;
      }
      for (const auto& [other, w] : expanded({it->second.begin(), it->second.end()}, depth + 1))
        out[other] += weight * w;
    }
    return out;
  }
  bool held(const PatchPoint& p) const { return held_ && held_(p); }
  const std::function<bool(const PatchPoint&)>& held_;
  std::map<PatchPoint, std::map<PatchPoint, double>> of_;
};

// Largest distance [m] between two edges at their samples; `where` receives its place.
double gap(const EdgeCurve& a, const EdgeCurve& b, Vec3& where) {
  double most = 0.0;
  where = a.samples.front();
  for (int i = 0; i <= kSamples; ++i) {
    const double d = (a.samples[i] - b.samples[i]).norm();
    if (d > most) most = d, where = a.samples[i];
  }
  return most;
}

// Returns the angle [rad] between the surfaces at share t of the edge. `opposite` tells whether the normals are on
// opposite sides.
double kink(const Patch& p, const EdgeCurve& a, const Patch& q, const EdgeCurve& b, bool reversed, double t,
            bool& opposite) {
  const auto frame = [](const Patch& patch, int edge, double at, Vec3& inward, Vec3& normal) {
    const SurfacePoint x = patch.evaluate(edge_point(patch, edge, at));
    normal = x.u.cross(x.v).normalized();
    const Vec3 along = edge <= kUMax ? x.v : x.u;
    inward = edge <= kUMax ? x.u : x.v;
    if (edge == kUMax || edge == kVMax) inward = -inward;
    inward -= inward.dot(along) / along.squaredNorm() * along;
    inward.normalize();
  };
  Vec3 in_p, normal_p, in_q, normal_q;
  frame(p, a.edge, t, in_p, normal_p), frame(q, b.edge, reversed ? 1.0 - t : t, in_q, normal_q);
  const double angle = std::numbers::pi - std::acos(std::clamp(in_p.dot(in_q), -1.0, 1.0));
  opposite = angle < 0.5 * std::numbers::pi && normal_p.dot(normal_q) < -kAskew;
  return angle;
}

class Search {
 public:
  Search(const std::vector<const Patch*>& patches, const std::vector<std::string>& names, double tolerance,
         const std::function<bool(const PatchPoint&)>& held, const std::vector<int>& whole)
      : patches_(patches), names_(names), tolerance_(tolerance), whole_(whole), resolver_(held) {}

  Stitches run(const std::vector<std::vector<Join>>& join) {
    const int n = static_cast<int>(patches_.size());
    for (int i = 0; i < n; ++i)
      for (const int edge : kEdges)
        if (whole_.empty() || (whole_[i] & edge)) edges_.push_back(edge_curve(*patches_[i], i, edge, false));
    const auto pole = [&](const EdgeCurve& c) {
      return std::all_of(c.samples.begin(), c.samples.end(),
                         [&](const Vec3& x) { return (x - c.samples[0]).norm() <= tolerance_; });
    };
    // an edge that is one point (a pole): other edges end there
    edges_.erase(std::remove_if(edges_.begin(), edges_.end(), pole), edges_.end());
    for (std::size_t a = 0; a < edges_.size(); ++a)
      for (std::size_t b = a + 1; b < edges_.size(); ++b)
        if (edges_[a].patch != edges_[b].patch && join[edges_[a].patch][edges_[b].patch] != Join::kOpen)
          compare(edges_[a], edges_[b], join[edges_[a].patch][edges_[b].patch]);
    Stitches out;
    out.seams = std::move(seams_), out.points = resolver_.all();
    return out;
  }

 private:
  std::string name(const EdgeCurve& c) const {
    constexpr const char* kNames[] = {"U_MIN", "U_MAX", "V_MIN", "V_MAX"};
    return fmt::format("edge {} of shell '{}'",
                       kNames[std::find(std::begin(kEdges), std::end(kEdges), c.edge) - kEdges], names_[c.patch]);
  }

  void compare(const EdgeCurve& a, const EdgeCurve& b, Join join) {
    const double near = kNear * std::min(spacing(a), spacing(b));
    const auto ends = [&](bool reversed) {
      return std::max((a.samples.front() - (reversed ? b.samples.back() : b.samples.front())).norm(),
                      (a.samples.back() - (reversed ? b.samples.front() : b.samples.back())).norm());
    };
    const bool reversed = ends(true) < ends(false);
    if (ends(reversed) > near) return part_of(a, b);
    const EdgeCurve other = edge_curve(*patches_[b.patch], b.patch, b.edge, reversed);
    Vec3 where;
    const double apart = gap(a, other, where);
    if (apart > near && ends(reversed) > tolerance_) return;  // the edges only end near each other
    require(apart <= tolerance_,
            "{} and {} nearly meet: they are up to {:.3g} m apart, at ({:.6g}, {:.6g}, {:.6g}); move them together, or "
            "give seams.tolerance_m, or a rule that leaves them OPEN",
            name(a), name(b), apart, where.x(), where.y(), where.z());
    require(a.degree == other.degree, "{} and {} meet, but their degrees are {} and {}; take the same", name(a),
            name(b), a.degree, other.degree);
    // The side with fewer control points is the independent one.
    if (other.row.size() < a.row.size())
      stitch(edge_curve(*patches_[b.patch], b.patch, b.edge, false),
             edge_curve(*patches_[a.patch], a.patch, a.edge, reversed), reversed, join);
    else
      stitch(a, other, reversed, join);
  }

  // Returns the distance [m] of x from the edge between samples k - 1 and k + 2, which hold one minimum.
  double distance(const Vec3& x, const EdgeCurve& c, int k) const {
    const auto off = [&](double t) {
      return (patches_[c.patch]->evaluate(edge_point(*patches_[c.patch], c.edge, t)).x - x).norm();
    };
    double low = std::max(0.0, (k - 1.0) / kSamples), high = std::min(1.0, (k + 2.0) / kSamples);
    for (int it = 0; it < kSections; ++it) {
      const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
      (off(a) < off(b) ? high : low) = off(a) < off(b) ? b : a;
    }
    return off(0.5 * (low + high));
  }

  // Refuses edges that meet over a part of their length, which is a T-junction.
  void part_of(const EdgeCurve& a, const EdgeCurve& b) const {
    for (const auto& [one, other] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
      int on = 0;
      Vec3 where = Vec3::Zero();
      for (int i = 0; i <= kSamples; ++i)
        for (int k = 0; k < kSamples; ++k) {
          const Vec3 d = other->samples[k + 1] - other->samples[k], r = one->samples[i] - other->samples[k];
          const double t = std::clamp(r.dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
          if ((r - t * d).norm() > kSagitta * d.norm() + tolerance_) continue;
          if (distance(one->samples[i], *other, k) <= tolerance_ && (i == 0 || i == kSamples || on > 0)) {
            ++on, where = one->samples[i];
            break;
          }
        }
      require(
          on < 3,
          "{} and {} meet over a part of their length, at ({:.6g}, {:.6g}, {:.6g}): divide the longer one where the "
          "other ends, or give a rule that leaves them OPEN",
          name(a), name(b), where.x(), where.y(), where.z());
    }
  }

  void stitch(const EdgeCurve& independent, const EdgeCurve& dependent, bool reversed, Join join) {
    const Patch &m = *patches_[independent.patch], &s = *patches_[dependent.patch];
    const Eigen::MatrixXd a = dependence_matrix(independent, dependent),
                          back = dependence_matrix(dependent, independent);
    const auto count_m = static_cast<int>(independent.row.size()), count_s = static_cast<int>(dependent.row.size());
    Seam seam;
    seam.first = independent.patch, seam.second = dependent.patch, seam.first_edge = independent.edge,
    seam.second_edge = dependent.edge;
    seam.reversed = reversed, seam.join = join;
    for (int i = 0; i < kSamples; ++i) seam.length += (independent.samples[i + 1] - independent.samples[i]).norm();
    // second row of the dependent side, expressed on the knots of the independent one
    std::vector<Terms> other(count_m);
    for (int j = 0; j < count_m; ++j) {
      for (int i = 0; i < count_s; ++i)
        other[j].push_back({{dependent.patch, dependent.second[i]}, back(j, i) * s.weights[dependent.second[i]]});
      other[j] = normalised(std::move(other[j]));
    }
    std::vector<double> share(count_m);  // share of the independent side's second row in the seam's row
    seam.smooth = join == Join::kClamped;
    for (int j = 0; j < count_m; ++j) {
      const Vec3 x = m.control_points[independent.row[j]], from = m.control_points[independent.second[j]],
                 to = mean(patches_, other[j]), d = to - from;
      const double t = d.squaredNorm() > 0.0 ? (x - from).dot(d) / d.squaredNorm() : 0.0;
      share[j] = 1.0 - t;
      seam.smooth = seam.smooth && t > kLeastShare && t < 1.0 - kLeastShare &&
                    (x - from - t * d).norm() <= std::max(kStraight * d.norm(), tolerance_);
    }
    bool opposite = false;
    for (int i = 0; i <= kSamples; ++i) {
      bool here = false;
      seam.angle = std::max(seam.angle, kink(m, independent, s, dependent, reversed, double(i) / kSamples, here));
      opposite = opposite || here;
    }
    require(
        !opposite,
        "{} and {} meet, but their normals u x v are on opposite sides; turn one of the patches over (reverse its u "
        "or v)",
        name(independent), name(dependent));
    for (int j = 0; j < count_m && seam.smooth; ++j) {
      Terms terms{{{independent.patch, independent.second[j]}, share[j]}};
      for (const auto& [p, weight] : other[j]) terms.push_back({p, (1.0 - share[j]) * weight});
      resolver_.depend({independent.patch, independent.row[j]}, terms);
    }
    for (int i = 0; i < count_s; ++i) {
      Terms terms;
      for (int j = 0; j < count_m; ++j)
        terms.push_back({{independent.patch, independent.row[j]}, a(i, j) * m.weights[independent.row[j]]});
      terms = normalised(std::move(terms));
      const Vec3 x = s.control_points[dependent.row[i]];
      const double off = (mean(patches_, terms) - x).norm();
      require(off <= 10.0 * tolerance_,
              "{} and {} meet, but one edge cannot depend on the other: their knots leave it {:.3g} m off at ({:.6g}, "
              "{:.6g}, "
              "{:.6g}); give both the same course along the edge",
              name(independent), name(dependent), off, x.x(), x.y(), x.z());
      resolver_.depend({dependent.patch, dependent.row[i]}, terms);
    }
    if (join == Join::kClamped && !seam.smooth)
      for (int j = 0; j < count_m; ++j) {
        const double width = (independent.knots[j + independent.degree + 1] - independent.knots[j]) /
                             (independent.degree + 1) * seam.length;
        seam.crease.push_back(
            {{independent.patch, independent.second[j]}, other[j], {independent.patch, independent.row[j]}, width});
      }
    seams_.push_back(std::move(seam));
  }

  const std::vector<const Patch*>& patches_;
  const std::vector<std::string>& names_;
  double tolerance_;
  const std::vector<int>& whole_;  // EdgeBits of each patch; empty: all
  std::vector<EdgeCurve> edges_;
  std::vector<Seam> seams_;
  Resolver resolver_;
};

}  // namespace

Stitches find_stitches(const std::vector<const Patch*>& patches, const std::vector<std::string>& names,
                       double tolerance, const std::vector<std::vector<Join>>& join,
                       const std::function<bool(const PatchPoint&)>& held, const std::vector<int>& whole) {
  return Search(patches, names, tolerance, held, whole).run(join);
}

}  // namespace sunder::shell
