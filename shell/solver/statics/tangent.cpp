#include "shell/solver/statics/tangent.h"

#include <algorithm>
#include <cmath>

namespace sunder::shell {
namespace {

// Shares of the size that a control point stands for. One-sided differences are off by about the share, which is more
// than the stiffness of a thin shell against bending without stretch; central ones by its square, and those
// of fourth order by its fourth power.
constexpr double kDifference = 1e-6;
constexpr double kCentralDifference = 1e-5;
constexpr double kFourthOrderDifference = 3e-4;

}  // namespace

FreeDegrees free_degrees(const ShellModel& m, const ShellState& s) {
  const std::size_t stride = m.tables.component_stride;
  FreeDegrees free;
  free.number.assign(3 * stride, -1);
  for (int d = 0; d < 3; ++d) {
    std::vector<char> fixed(stride, 1);
    for (int i = 0; i < m.control_points(); ++i) fixed[m.tables.slot(i)] = s.motion.detached[m.tables.slot(i)];
    for (const int slot : m.constraints.held[d]) fixed[slot] = 1;
    for (const auto& driven : m.constraints.driven)
      for (const int slot : driven.slots[d]) fixed[slot] = 1;
    int* number = &free.number[d * stride];
    for (const auto& group : m.constraints.tied[d]) {
      const bool any = std::any_of(group.begin(), group.end(), [&](int slot) { return fixed[slot] != 0; });
      for (const int slot : group) fixed[slot] = 1, number[slot] = any ? -1 : free.count;
      free.count += !any;
    }
    for (std::size_t i = 0; i < stride; ++i)
      if (!fixed[i]) number[i] = free.count++;
  }
  return free;
}

Eigen::SparseMatrix<double> tangent_stiffness(const ShellModel& m, ShellState& s, const FreeDegrees& free,
                                              Differences differences, const std::function<void()>& forces) {
  const bool central = differences != Differences::kOneSided, fourth = differences == Differences::kFourthOrder;
  const RowTables& t = m.tables;
  const std::size_t stride = t.component_stride;
  const int reach = std::max(t.degree, m.trim.reach);  // control points of one Gauss point are at most this far apart
  const int period = 2 * reach + 1;                    // control points one period apart move together
  std::vector<double> epsilon(stride, 0.0);            // by the area that a control point stands for
  for (std::size_t i = 0; i < stride; ++i)
    epsilon[i] = (fourth    ? kFourthOrderDifference
                  : central ? kCentralDifference
                            : kDifference) *
                 std::sqrt(m.mass[i] / m.mass_per_area(static_cast<int>(i)));
  forces();
  const std::vector<double> f0 = s.motion.force, x = s.motion.x;
  std::vector<double> before = f0;  // forces at the other side of a difference
  std::vector<double> wide;         // difference of forces over twice the distance
  const double sides = central ? 2.0 : 1.0;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(free.count) * 3 * period * period);
  for (int colour = 0; colour < period * period; ++colour)
    for (int d = 0; d < 3; ++d) {
      const int first_i = colour % period, first_j = colour / period;
      const auto moved = [&](double sign) {
        for (int j = first_j; j < t.rows; j += period)
          for (int i = first_i; i < t.columns; i += period) {
            const std::size_t k = d * stride + j * t.stride + i;
            s.motion.x[k] = x[k] + sign * epsilon[j * t.stride + i];
          }
        forces();
      };
      if (fourth) {
        moved(-2.0), before = s.motion.force, moved(2.0), wide = s.motion.force;
        for (std::size_t k = 0; k < wide.size(); ++k) wide[k] -= before[k];
      }
      if (central) moved(-1.0), before = s.motion.force;
      moved(1.0);
      for (int j = first_j; j < t.rows; j += period)
        for (int i = first_i; i < t.columns; i += period) {
          const int column = free.number[d * stride + j * t.stride + i];
          if (column < 0) continue;
          for (int q = std::max(0, j - reach); q <= std::min(t.rows - 1, j + reach); ++q)
            for (int p = std::max(0, i - reach); p <= std::min(t.columns - 1, i + reach); ++p)
              for (int e = 0; e < 3; ++e) {
                const std::size_t k = e * stride + q * t.stride + p;
                double value = -(s.motion.force[k] - before[k]) / (sides * epsilon[j * t.stride + i]);
                if (fourth) value = (4.0 * value + wide[k] / (4.0 * epsilon[j * t.stride + i])) / 3.0;
                if (free.number[k] < 0 || value == 0.0) continue;
                entries.emplace_back(free.number[k], column, value);
              }
        }
      s.motion.x = x;
    }
  s.motion.force = f0;
  Eigen::SparseMatrix<double> tangent(free.count, free.count);
  tangent.setFromTriplets(entries.begin(), entries.end());
  return tangent;
}

}  // namespace sunder::shell
