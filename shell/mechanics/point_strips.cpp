#include "shell/mechanics/point_strips.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sunder::shell {
namespace {

constexpr int kUnitBits = 30;  // of the largest function: leaves a bit for the sign and one for the sum of zero

// Unit of derivative k, a power of two; 1 where all functions are zero.
double unit_of(const std::vector<GatheredFunction>& functions, int k) {
  double most = 0.0;
  for (const GatheredFunction& f : functions) most = std::max(most, std::abs(f.n[k + 1]));
  int exponent = kUnitBits;
  if (most > 0.0) std::frexp(most, &exponent);
  return std::ldexp(1.0, exponent - kUnitBits);
}

bool are_multiples(const std::vector<GatheredFunction>& functions, int k, double unit) {
  return std::all_of(functions.begin(), functions.end(), [&](const GatheredFunction& f) {
    const double units = f.n[k + 1] / unit;
    return std::abs(units) <= std::numeric_limits<std::int32_t>::max() && units == std::nearbyint(units);
  });
}

}  // namespace

void round_to_units(std::vector<GatheredFunction>& functions) {
  for (int k = 0; k < kDerivatives; ++k) {
    const double unit = unit_of(functions, k);
    double sum = 0.0;
    std::size_t largest = 0;
    for (std::size_t i = 0; i < functions.size(); ++i) {
      double& n = functions[i].n[k + 1];
      n = std::nearbyint(n / unit) * unit, sum += n;
      if (std::abs(n) > std::abs(functions[largest].n[k + 1])) largest = i;
    }
    // rounding moves each function by half a unit at most: a larger sum was not zero before
    if (std::abs(sum) <= static_cast<double>(functions.size()) * unit && !functions.empty())
      functions[largest].n[k + 1] -= sum;
  }
}

void PointStrips::prepare(std::size_t points) {
  entries_.resize(points);
  if (2 * unused_ <= wide_.strips.size() + narrow_.strips.size()) return;
  std::fill(entries_.begin(), entries_.end(), Entry{});
  wide_ = {}, narrow_ = {}, unused_ = 0;
}

void PointStrips::pack(Entry& entry, const GatheredPoint& point, int stride) {
  unused_ += entry.count;
  entry = {point.stamp};
  sorted_.clear();
  for (const GatheredFunction& f : point.functions) sorted_.push_back(&f);
  std::sort(sorted_.begin(), sorted_.end(), [](const auto* a, const auto* b) { return a->slot < b->slot; });
  entry.narrow = true;
  for (int k = 0; k < kDerivatives; ++k) {
    entry.unit[k] = unit_of(point.functions, k);
    entry.narrow = entry.narrow && are_multiples(point.functions, k, entry.unit[k]);
  }
  if (!entry.narrow) entry.unit.fill(1.0);
  entry.narrow ? fill(entry, narrow_, stride) : fill(entry, wide_, stride);
}

template <class Strip>
void PointStrips::fill(Entry& entry, Strips<Strip>& all, int stride) {
  entry.begin = static_cast<std::uint32_t>(all.strips.size());
  int first = -kLanes;
  for (const GatheredFunction* f : sorted_) {
    if (f->slot >= first + kLanes) {
      first = std::min(f->slot, stride - kLanes);
      all.strips.push_back({}), all.slot.push_back(first);
    }
    for (int k = 0; k < kDerivatives; ++k) {
      auto& lane = all.strips.back().n[k];
      lane[f->slot - first] += static_cast<std::remove_reference_t<decltype(lane[0])>>(f->n[k + 1] / entry.unit[k]);
    }
  }
  entry.count = static_cast<std::uint32_t>(all.strips.size()) - entry.begin;
}

}  // namespace sunder::shell
