#include "shell/geometry/knots.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"

namespace sunder::shell {

KnotVector::KnotVector(std::vector<double> knots, const std::string& field) : knots_(std::move(knots)) {
  require(knots_.size() >= 2 * kSupport, "{}: {} knots; an open quadratic knot vector has at least 6", field,
          knots_.size());
  for (std::size_t i = 0; i < knots_.size(); ++i) {
    require(std::isfinite(knots_[i]), "{}[{}] is {}; knots are finite numbers", field, i, knots_[i]);
    require(i == 0 || knots_[i] >= knots_[i - 1], "{}[{}] is {}, less than the knot before it ({}); knots never fall",
            field, i, knots_[i], i ? knots_[i - 1] : 0.0);
  }
  const std::size_t last = knots_.size() - 1;
  require(knots_[0] == knots_[kDegree] && knots_[last] == knots_[last - kDegree],
          "{}: the first and the last knot must each stand three times (an open knot vector)", field);
  require(knots_[0] < knots_[last], "{}: all knots are {}; the domain has no length", field, knots_[0]);
  for (std::size_t i = 1; i + 3 <= last; ++i)
    require(knots_[i] < knots_[i + 2] || i + 2 <= kDegree || i >= last - kDegree,
            "{}[{}] = {} stands three times inside: the patch would fall apart there; use two patches", field, i,
            knots_[i]);
}

KnotVector KnotVector::uniform(int spans, double length) {
  std::vector<double> knots(kDegree, 0.0);
  for (int i = 0; i <= spans; ++i) knots.push_back(length * i / spans);
  for (int i = 0; i < kDegree; ++i) knots.push_back(length);
  return KnotVector(std::move(knots));
}

int KnotVector::span_of(double u) const {
  const auto first = knots_.begin() + kDegree, last = knots_.end() - kSupport;
  const auto it = std::upper_bound(first, last, std::max(u, begin()));
  int span = static_cast<int>(it - first) - 1;
  span = std::clamp(span, 0, spans() - 1);
  while (span > 0 && span_length(span) == 0.0) --span;
  return span;
}

Basis KnotVector::basis(int span, double u) const {
  const double* t = knots_.data() + span;  // t[2] .. t[3] is the span
  const double length = t[3] - t[2], left = t[3] - t[1], right = t[4] - t[2];
  const double n0 = (t[3] - u) / length, n1 = (u - t[2]) / length;  // the two linear functions
  Basis b;
  b.value = {(t[3] - u) / left * n0, (u - t[1]) / left * n0 + (t[4] - u) / right * n1, (u - t[2]) / right * n1};
  b.first = {-2.0 / left * n0, 2.0 / left * n0 - 2.0 / right * n1, 2.0 / right * n1};
  b.second = {2.0 / (left * length), -2.0 / (left * length) - 2.0 / (right * length), 2.0 / (right * length)};
  return b;
}

KnotVector KnotVector::scaled(double factor) const {
  std::vector<double> knots = knots_;
  for (double& t : knots) t = (t - knots_[0]) * factor;
  return KnotVector(std::move(knots));
}

}  // namespace sunder::shell
