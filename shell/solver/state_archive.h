#pragma once
// The state of a shell between two windows, for checkpoints.
#include <memory>

#include "coupler/core/archive.h"
#include "shell/solver/state.h"

namespace sunder {
template <>
inline constexpr bool kAsBytes<shell::Tip> = true;
}  // namespace sunder

namespace sunder::shell {

template <class A>
void archive(A& a, GatheredPoint& p) {
  archive_all(a, p.block, p.lane, p.kind, p.area, p.metric, p.functions, p.handed_off, p.in_rows);
  if constexpr (A::kReading) p.stamp = fresh_stamp();
}

template <class A>
void archive(A& a, FacePoint& p) {
  archive_all(a, p.rest, p.bore, p.was_open, p.depth);
}

template <class A>
void archive(A& a, Interlock& i) {
  archive_all(a, i.edge, i.area, i.stiffness, i.plus, i.minus, i.points[0], i.points[1], i.origin, i.rest_area[0],
              i.rest_area[1], i.holds, i.opening, i.along, i.height, i.sound, i.rubbed, i.crushed);
}

/// Edges are added again in their order, which reproduces the bins.
template <class A>
void archive(A& a, CrackGraph& g) {
  std::vector<Vec2> vertices = g.vertices();
  std::vector<CrackEdge> edges = g.edges();
  int cracks = g.next_crack();
  double length = g.total_length();
  std::size_t count = archive_detail::length(a, edges.size(), sizeof(int));
  archive_all(a, vertices, cracks, length);
  if constexpr (A::kReading) edges.resize(count);
  for (CrackEdge& e : edges) archive_all(a, e.from, e.to, e.crack, e.time, e.face, e.resistance);
  if constexpr (A::kReading) g.restore(vertices, edges, cracks, length);
}

/// Archives the members that a kind of state lists in its saved().
template <class A, class Kind>
requires requires(Kind& kind) {
  kind.saved([](auto&...) {});
}
void archive(A& a, Kind& kind) {
  kind.saved([&a](auto&... members) { archive_all(a, members...); });
}

/// Reads or writes a state of the same model; caches and scratch do not change.
template <class A>
void archive(A& a, ShellState& s) {
  ShellState::kinds(s, [&a](auto&... kinds) { archive_all(a, kinds...); });
  if constexpr (A::kReading)
    for (const GatheredPoint& g : s.cracked.gathered) s.cracked.note_kind(g);
}

}  // namespace sunder::shell
