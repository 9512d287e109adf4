#pragma once
// Velocity fields of a background grid's nodes: a field for each surface that comes near a node, in a list by node.
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// The sample's field in the node's list that begins at `head` (-1: none yet), made where it has none. Samples share a
/// field where their shells hang together (`together[i][k]`) and they are no further apart at rest than `one_surface`
/// [m]. A Field has shell, rest [m] and next; a Sample shell and rest. Returns the field's index.
template <class Field, class Sample>
int field_of(std::vector<Field>& fields, int& head, const std::vector<std::vector<char>>& together, double one_surface,
             const Sample& p) {
  int last = -1;
  for (int f = head; f >= 0; last = f, f = fields[f].next)
    if (together[fields[f].shell][p.shell] != 0 && (fields[f].rest - p.rest).squaredNorm() <= one_surface * one_surface)
      return f;
  const int f = static_cast<int>(fields.size());
  fields.emplace_back();
  fields.back().shell = p.shell, fields.back().rest = p.rest;
  (last < 0 ? head : fields[last].next) = f;
  return f;
}

}  // namespace sunder::shell
