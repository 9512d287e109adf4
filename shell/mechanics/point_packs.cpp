#include "shell/mechanics/point_packs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace sunder::shell {
namespace {

constexpr int kUnitBits = 30;  // of the largest function: leaves a bit for the sign and one for the sum of zero

// Units of the derivatives, powers of two; 1 where all functions are zero.
std::array<double, kDerivatives> units_of(const std::vector<GatheredFunction>& functions) {
  std::array<double, kDerivatives> unit{};
  for (const GatheredFunction& f : functions)
    for (int k = 0; k < kDerivatives; ++k) unit[k] = std::max(unit[k], std::abs(f.n[k + 1]));
  for (double& most : unit) {
    int exponent = kUnitBits;
    if (most > 0.0) std::frexp(most, &exponent);
    most = std::ldexp(1.0, exponent - kUnitBits);
  }
  return unit;
}

// Points that exert a force here.
bool is_summed(const GatheredPoint& p) { return !p.in_rows && p.kind != PointKind::kDead; }

}  // namespace

void round_to_units(std::vector<GatheredFunction>& functions) {
  const std::array<double, kDerivatives> units = units_of(functions);
  for (int k = 0; k < kDerivatives; ++k) {
    const double unit = units[k];
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

void PointPacks::update(const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t chunk) {
  constexpr std::size_t kTurn = kPointRun * kPointChunks;
  const std::size_t first = chunk * kPointRun;
  const std::size_t count = points.size() > first ? (points.size() - first + kTurn - 1) / kTurn : 0;
  bool any = runs_.size() != count;
  runs_.resize(count);
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const std::size_t begin = first + r * kTurn, end = std::min(begin + kPointRun, points.size());
    std::array<std::uint64_t, kPointRun> stamp{};
    for (std::size_t i = begin; i < end; ++i) stamp[i - begin] = is_summed(points[i]) ? points[i].stamp : 0;
    if (stamp == runs_[r].stamp) continue;
    runs_[r].stamp = stamp, any = true;
    renew(runs_[r], t, points, begin);
  }
  if (!any) return;
  first_slot_ = std::numeric_limits<int>::max(), end_slot_ = 0;
  each([&](const PointPack& p, const PointPack*) {
    for (const auto& quads : {p.slots.front(), p.slots.back()})
      for (const int slot : quads) first_slot_ = std::min(first_slot_, slot), end_slot_ = std::max(end_slot_, slot + 1);
  });
  if (end_slot_ == 0) first_slot_ = 0;
}

namespace {

// Points of a run, and the control points of each as bits.
class Neighbours {
 public:
  Neighbours(const std::vector<GatheredPoint>& points, const std::vector<std::size_t>& of) {
    int low = std::numeric_limits<int>::max(), end = 0;
    for (const std::size_t i : of)
      for (const GatheredFunction& f : points[i].functions)
        low = std::min(low, f.slot), end = std::max(end, f.slot + 1);
    std::vector<int> place(std::max(end - low, 0), -1);
    for (const std::size_t i : of)
      for (const GatheredFunction& f : points[i].functions)
        if (place[f.slot - low] < 0) place[f.slot - low] = count_++;
    words_ = (count_ + 63) / 64;
    bits_.resize(of.size() * words_), size_.resize(of.size());
    for (std::size_t k = 0; k < of.size(); ++k) {
      for (const GatheredFunction& f : points[of[k]].functions) {
        const int at = place[f.slot - low];
        bits_[k * words_ + at / 64] |= std::uint64_t{1} << at % 64;
      }
      size_[k] = common(k, &bits_[k * words_]);
    }
  }
  int words() const { return words_; }
  int size(std::size_t k) const { return size_[k]; }
  // How many of the control points in `set` point k uses.
  int common(std::size_t k, const std::uint64_t* set) const {
    int sum = 0;
    for (int w = 0; w < words_; ++w) sum += std::popcount(bits_[k * words_ + w] & set[w]);
    return sum;
  }
  void add(std::size_t k, std::uint64_t* set) const {
    for (int w = 0; w < words_; ++w) set[w] |= bits_[k * words_ + w];
  }

 private:
  int count_ = 0, words_ = 0;
  std::vector<std::uint64_t> bits_;  // [point][word]
  std::vector<int> size_;
};

// Points whose functions lie in one quad of lanes.
struct Quad {
  std::vector<std::size_t> points;  // in the list of gathered points
  int size = 0;                     // of their control points together
};

// To the point with most control points come those that share most with it, and so on. Quads of like size follow one
// another.
std::vector<Quad> quads_of(const std::vector<GatheredPoint>& points, const std::vector<std::size_t>& of) {
  // how much a control point that a point adds counts more than one that it does not use: a fifth less or half as much
  // again makes no difference
  constexpr int kAdded = 5, kUnused = 3;
  const Neighbours neighbours(points, of);
  std::vector<std::size_t> left(of.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::vector<Quad> quads;
  std::vector<std::uint64_t> all;
  while (!left.empty()) {
    all.assign(neighbours.words(), 0);
    Quad quad;
    for (int n = 0; n < kQuad && !left.empty(); ++n) {
      const auto cost = [&](std::size_t k) {
        const int size = neighbours.size(k), common = neighbours.common(k, all.data());
        return n == 0 ? -size : kAdded * (size - common) - kUnused * common;
      };
      std::size_t best = 0;
      int least = std::numeric_limits<int>::max();
      for (std::size_t k = 0; k < left.size(); ++k)
        if (const int now = cost(left[k]); now < least) least = now, best = k;
      quad.points.push_back(of[left[best]]);
      neighbours.add(left[best], all.data());
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
    }
    for (const std::uint64_t word : all) quad.size += std::popcount(word);
    quads.push_back(std::move(quad));
  }
  std::stable_sort(quads.begin(), quads.end(), [](const Quad& a, const Quad& b) { return a.size > b.size; });
  return quads;
}

}  // namespace

void PointPacks::renew(Run& run, const RowTables& t, const std::vector<GatheredPoint>& points, std::size_t begin) {
  // by elements, whatever the order in which cracks touched them
  std::vector<std::pair<std::tuple<int, int, int>, std::size_t>> places;
  for (std::size_t i = begin; i < begin + kPointRun; ++i)
    if (run.stamp[i - begin] != 0)
      places.push_back({{points[i].block / (t.gauss * t.gauss), points[i].lane, points[i].block}, i});
  std::sort(places.begin(), places.end());
  std::vector<std::size_t> order;
  for (const auto& [place, i] : places) order.push_back(i);
  const std::vector<Quad> quads = quads_of(points, order);
  run.packs.resize((quads.size() + kQuads - 1) / kQuads);
  for (std::size_t k = 0; k < run.packs.size(); ++k) {
    PointPack& pack = run.packs[k];
    std::array<std::uint64_t, kLanes> stamp;
    IntPack own{};
    for (int i = 0; i < kLanes; ++i) {
      const std::size_t q = k * kQuads + i / kQuad, there = q < quads.size() ? q : k * kQuads;
      const std::size_t n = i % kQuad, of_quad = quads[there].points.size();
      own[i] = there == q && n < of_quad ? -1 : 0;
      pack.index[i] = quads[there].points[n < of_quad ? n : 0];
      stamp[i] = points[pack.index[i]].stamp;
    }
    if (!any(pack.own != own) && pack.stamp == stamp) continue;
    pack.own = own, pack.stamp = stamp;
    build(pack, points);
  }
}

void PointPacks::build(PointPack& pack, const std::vector<GatheredPoint>& points) {
  for (int i = 0; i < kLanes; ++i) {
    const GatheredPoint& p = points[pack.index[i]];
    pack.block[i] = p.block, pack.lane[i] = p.lane, pack.area[i] = p.area;
    pack.linear[i] = p.kind == PointKind::kLinear ? -1 : 0;
    pack.ref.a.c11[i] = p.metric.a.c11, pack.ref.a.c22[i] = p.metric.a.c22, pack.ref.a.c12[i] = p.metric.a.c12;
    pack.ref.b.c11[i] = p.metric.b.c11, pack.ref.b.c22[i] = p.metric.b.c22, pack.ref.b.c12[i] = p.metric.b.c12;
    const std::array<double, kDerivatives> unit = units_of(p.functions);
    for (int k = 0; k < kDerivatives; ++k) pack.unit[k][i] = unit[k];
  }
  pack.wide.clear();
  if (fill(pack, pack.narrow, points)) return;
  pack.narrow.clear();
  for (Pack& unit : pack.unit) unit = splat<Pack>(1.0);
  fill(pack, pack.wide, points);
}

template <class Functions>
bool PointPacks::fill(PointPack& pack, std::vector<Functions>& all, const std::vector<GatheredPoint>& points) {
  pack.slots.clear(), all.clear();
  bool exact = true;
  for (int quad = 0; quad < kQuads && exact; ++quad) {
    const int first = quad * kQuad;
    int low = std::numeric_limits<int>::max(), end = 0;
    for (int i = first; i < first + kQuad; ++i)
      for (const GatheredFunction& f : points[pack.index[i]].functions)
        low = std::min(low, f.slot), end = std::max(end, f.slot + 1);
    place_.assign(std::max(end - low, 0), -1);
    for (int i = first; i < first + kQuad; ++i)
      for (const GatheredFunction& f : points[pack.index[i]].functions) place_[f.slot - low] = 0;
    std::vector<int> slots;
    for (int s = low; s < end; ++s)
      if (place_[s - low] == 0) place_[s - low] = static_cast<int>(slots.size()), slots.push_back(s);
    if (slots.empty()) slots.push_back(0);  // a point may have no function at all
    while (pack.slots.size() < slots.size()) {
      pack.slots.push_back(pack.slots.empty() ? std::array<int, kQuads>{} : pack.slots.back());
      all.push_back({});
    }
    for (std::size_t k = 0; k < pack.slots.size(); ++k) pack.slots[k][quad] = slots[std::min(k, slots.size() - 1)];
    for (int i = first; i < first + kQuad; ++i) {
      double inverse[kDerivatives];  // exact, of powers of two
      for (int k = 0; k < kDerivatives; ++k) inverse[k] = 1.0 / pack.unit[k][i];
      for (const GatheredFunction& f : points[pack.index[i]].functions)
        for (int k = 0; k < kDerivatives; ++k) {
          auto& n = all[place_[f.slot - low]].n[k];
          using Number = std::remove_reference_t<decltype(n[0])>;
          const double units = f.n[k + 1] * inverse[k];
          const auto number = static_cast<Number>(units);
          n[i] += number;
          exact = exact && number == units;
        }
    }
  }
  return exact;
}

}  // namespace sunder::shell
