#pragma once
// Places in the parameter domain as a scene gives them: rounded to a few digits.
#include <string>

#include "shell/geometry/patch.h"

namespace sunder::shell {

/// A place nearer to an edge than this share of the patch's size is on the edge. The end of an arc is an irrational
/// number, and even a plate's last knot is a product of sums: a scene cannot give either to the last bit.
constexpr double kOnEdge = 1e-6;  // [-]

/// Returns the distance below which a place is on an edge: kOnEdge of the longer side of the parameter domain [m].
double edge_tolerance(const Patch& patch);

/// Parameters are lengths by a Gauss rule of two points an element. Returns what it errs by along the middle line of
/// the direction (0: u, 1: v) [m]: a place by the true length of an arc misses its end by so much.
double length_error(const Patch& patch, int direction);

/// Returns `p`, moved onto each edge that is nearer than the tolerance and the error of the length. Places further
/// outside stay where they are: patch.contains() tells.
Vec2 moved_onto_edges(const Patch& patch, const Vec2& p);

/// Returns "from 0 to 1.1 along u and from 0 to 2 along v". A place at a printed end is on the edge.
std::string parameter_range(const Patch& patch);

}  // namespace sunder::shell
