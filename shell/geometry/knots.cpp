#include "shell/geometry/knots.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

// Evaluates the three quadratic functions between t[2] and t[3].
Basis quadratic(const double* t, double u) {
  const double length = t[3] - t[2], left = t[3] - t[1], right = t[4] - t[2];
  const double n0 = (t[3] - u) / length, n1 = (u - t[2]) / length;  // the two linear functions
  Basis b{};
  b.value = {(t[3] - u) / left * n0, (u - t[1]) / left * n0 + (t[4] - u) / right * n1, (u - t[2]) / right * n1};
  b.first = {-2.0 / left * n0, 2.0 / left * n0 - 2.0 / right * n1, 2.0 / right * n1};
  b.second = {2.0 / (left * length), -2.0 / (left * length) - 2.0 / (right * length), 2.0 / (right * length)};
  return b;
}

// Evaluates the four cubic functions between t[3] and t[4] from the quadratic ones Q_k there (Cox, de Boor):
//   N_k = (u - t_k) / w_{k-1} Q_{k-1} + (t_{k+4} - u) / w_k Q_k,  N_k' = 3 (Q_{k-1} / w_{k-1} - Q_k / w_k),
// where w_k = t_{k+4} - t_{k+1} is the support of Q_k.
Basis cubic(const double* t, double u) {
  const Basis q = quadratic(t + 1, u);
  Basis b{};
  for (int k = 0; k < 3; ++k) {
    const double width = t[k + 4] - t[k + 1];
    b.value[k] += (t[k + 4] - u) / width * q.value[k], b.value[k + 1] += (u - t[k + 1]) / width * q.value[k];
    b.first[k] -= 3.0 / width * q.value[k], b.first[k + 1] += 3.0 / width * q.value[k];
    b.second[k] -= 3.0 / width * q.first[k], b.second[k + 1] += 3.0 / width * q.first[k];
  }
  return b;
}

}  // namespace

KnotVector::KnotVector(std::vector<double> knots, int degree, const std::string& field)
    : knots_(std::move(knots)), degree_(degree) {
  require(degree == 2 || degree == kHighestDegree, "{}: degree {}; 2 (quadratic) or 3 (cubic)", field, degree);
  const char* ends = degree == 2 ? "three" : "four";
  require(!knots_.empty(), "{}: no knots", field);
  const auto at_first = std::count(knots_.begin(), knots_.end(), knots_.front()),
             at_last = std::count(knots_.begin(), knots_.end(), knots_.back());
  const bool of_other = at_first == at_last && at_first == (degree == 2 ? 4 : 3) && knots_.front() < knots_.back();
  require(!of_other,
          "{}: the first and the last knot stand {} times, as those of degree {} do, and the patch has degree {} in "
          "both directions; set degree {} where both have it, else raise the lower one to 3 in the program that made "
          "the surface",
          field, at_first, at_first - 1, degree, at_first - 1);
  require(knots_.size() >= 2 * static_cast<std::size_t>(degree) + 2,
          "{}: {} knots; an open knot vector of degree {} has at least {}", field, knots_.size(), degree,
          2 * degree + 2);
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    require(std::isfinite(knots_[i]), "{}[{}] is {}; knots are finite numbers", field, i, knots_[i]);
    require(i == 0 || knots_[i] >= knots_[i - 1], "{}[{}] is {}, less than the knot before it ({}); knots never fall",
            field, i, knots_[i], i ? knots_[i - 1] : 0.0);
  }
  const std::size_t last = knots_.size() - 1, p = degree;
  require(knots_[0] < knots_[last], "{}: all knots are {}; the domain has no length", field, knots_[0]);
  require(at_first == at_last && at_first == degree + 1,
          "{}: the first and the last knot must each stand {} times (an open knot vector of degree {})", field, ends,
          degree);
  for (std::size_t i = p - 1; i + p + 1 <= last; ++i)
    require(knots_[i] < knots_[i + 2], "{}[{}] = {} stands three times inside: the patch would {} there; {}", field, i,
            knots_[i], degree == 2 ? "fall apart" : "fold",
            degree == 2 ? "use two patches" : "give it twice at the most");
}

KnotVector KnotVector::uniform(int spans, double length, int degree) {
  std::vector<double> knots(degree, 0.0);
  for (int i = 0; i <= spans; ++i) knots.push_back(length * i / spans);
  for (int i = 0; i < degree; ++i) knots.push_back(length);
  return KnotVector(std::move(knots), degree);
}

int KnotVector::span_of(double u) const {
  const auto first = knots_.begin() + degree_, last = knots_.end() - degree_ - 1;
  const auto it = std::upper_bound(first, last, std::max(u, begin()));
  int span = static_cast<int>(it - first) - 1;
  span = std::clamp(span, 0, spans() - 1);
  while (span > 0 && span_length(span) == 0.0) --span;
  return span;
}

Basis KnotVector::basis(int span, double u) const {
  const double* t = knots_.data() + span;
  return degree_ == 2 ? quadratic(t, u) : cubic(t, u);
}

KnotVector KnotVector::scaled(double factor) const {
  std::vector<double> knots = knots_;
  for (double& t : knots) t = (t - knots_[0]) * factor;
  return KnotVector(std::move(knots), degree_);
}

}  // namespace sunder::shell
