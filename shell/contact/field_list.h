#pragma once
// Velocity fields of a background grid's nodes: a field for each surface that comes near a node, in a list by node.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// The sample's field in the node's list that begins at `head` (-1: none yet): the first that is the `same` surface,
/// made where none is. A Field has shell, rest [m] and next; a Sample shell and rest. Returns the field's index.
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

/// Whether two places are of one surface: their shells hang together (`together[i][k]`), and they are no further apart
/// at rest than `one_surface` [m].
template <class A, class B>
bool are_one_surface(const A& a, const B& b, const std::vector<std::vector<char>>& together, double one_surface) {
  return together[a.shell][b.shell] != 0 && (a.rest - b.rest).squaredNorm() <= one_surface * one_surface;
}

}  // namespace sunder::shell
