#pragma once
// What layers remember, and where a kernel finds it: the state of a Gauss point has the same place in either kernel.
#include <algorithm>
#include <array>
#include <vector>

#include "shell/mechanics/row_tables.h"

namespace sunder::shell {

constexpr int kMostLayers = 16;        // of a law with memory
constexpr int kPointChunks = 4;        // into which gathered points are divided, whatever the number of threads
constexpr std::size_t kPointRun = 64;  // consecutive points that one chunk takes, in turns: a new point moves no other

struct RowPlasticity;
struct RowDamage;
struct DamageLaw;
/// Memory of all laws; a law reads its own. Null: the law is not in force.
struct LayerMemory {
  RowPlasticity* plastic = nullptr;
  RowDamage* row_damage = nullptr;
  DamageLaw* point_damage = nullptr;
};

// Each of the three places below has, for arrays [block][field][lane]:
//   load(values, fields, field)             a value for each lane
//   store(values, fields, field, where, v)  of the lanes `where`
//   add(sum, where, area, per_area)         adds area * per_area of the lanes `where` to a sum
//   sum_slot()                              number of a sum that no other thread adds to

/// A pack of the row kernel: the lanes stand side by side, from `lane` on.
struct RowPlaces {
  using Value = Pack;
  const RowTables& t;
  int block, lane;

  int sum_slot() const { return block / (t.gauss * t.gauss); }
  Pack load(const std::vector<double>& values, int fields, int field) const {
    return shell::load<Pack>(values.data() + t.at(block, fields, field, lane));
  }
  void store(std::vector<double>& values, int fields, int field, const IntPack& where, const Pack& v) const {
    double* to = values.data() + t.at(block, fields, field, lane);
    shell::store<Pack>(to, select(where, v, shell::load<Pack>(to)));
  }
  void add(double& sum, const IntPack& where, const Pack& area, const Pack& per_area) const {
    const Pack all = select(where, area * per_area, Pack{});
    for (int i = 0; i < kLanes; ++i) sum += all[i];
  }
};

/// A pack of gathered points, each at its own place. Lanes beyond the last point repeat the first.
struct PointPlaces {
  using Value = Pack;
  const RowTables& t;
  std::array<int, kLanes> block, lane;
  std::array<std::size_t, kLanes> index;  // in the list of gathered points

  int sum_slot() const { return static_cast<int>(index[0] / kPointRun % kPointChunks); }
  Pack load(const std::vector<double>& values, int fields, int field) const {
    Pack v{};
    for (int i = 0; i < kLanes; ++i) v[i] = values[t.at(block[i], fields, field, lane[i])];
    return v;
  }
  void store(std::vector<double>& values, int fields, int field, const IntPack& where, const Pack& v) const {
    for (int i = 0; i < kLanes; ++i)
      if (where[i]) values[t.at(block[i], fields, field, lane[i])] = v[i];
  }
  void add(double& sum, const IntPack& where, const Pack& area, const Pack& per_area) const {
    for (int i = 0; i < kLanes; ++i)
      if (where[i]) sum += area[i] * per_area[i];
  }
};

/// One point.
struct OnePlace {
  using Value = double;
  const RowTables& t;
  int block, lane;

  int sum_slot() const { return 0; }
  double load(const std::vector<double>& values, int fields, int field) const {
    return values[t.at(block, fields, field, lane)];
  }
  void store(std::vector<double>& values, int fields, int field, bool where, double v) const {
    if (where) values[t.at(block, fields, field, lane)] = v;
  }
  void add(double& sum, bool where, double area, double per_area) const {
    if (where) sum += area * per_area;
  }
};

}  // namespace sunder::shell
