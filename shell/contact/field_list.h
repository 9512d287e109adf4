#pragma once
// Velocity fields at the nodes of a background grid: each node has a list with a field for each surface near it.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// Index of the sample's field in the node's list that begins at `head` (-1: the list is empty). It is the first field
/// of the `same` surface; a new field is added where there is none. A Field has shell, rest [m] and next; a Sample has
/// shell and rest.
template <class Field, class Sample, class Same>
int field_of(std::vector<Field>& fields, int& head, const Sample& p, Same&& same) {
  int last = -1;
  for (int f = head; f >= 0; last = f, f = fields[f].next)
    if (same(fields[f])) return f;
  const int f = static_cast<int>(fields.size());
  fields.emplace_back();
  fields.back().shell = p.shell, fields.back().rest = p.rest;
  (last < 0 ? head : fields[last].next) = f;
  return f;
}

/// True if two places are on one surface: their shells are joined (`together[i][k]`), and their distance at rest is at
/// most `one_surface` [m].
template <class A, class B>
bool are_one_surface(const A& a, const B& b, const std::vector<std::vector<char>>& together, double one_surface) {
  return together[a.shell][b.shell] != 0 && (a.rest - b.rest).squaredNorm() <= one_surface * one_surface;
}

}  // namespace sunder::shell
