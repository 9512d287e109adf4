#pragma once
// How far to move what starts inside something else.
#include <functional>
#include <string>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// How deep [m] something is inside another after a move [m]; negative outside.
using DepthAfter = std::function<double(const Vec3& move)>;

/// The shortest move [m] along one of the directions, of length one, after which the depth is at most `least` [m]. Zero
/// where none is found.
Vec3 shortest_way(const std::vector<Vec3>& directions, double least, const DepthAfter& depth_after);

/// "move it 0.001 m along (0, 0, 1)", with digits that are enough; "move it away" where the way is zero.
std::string move_along(const std::string& what, const Vec3& way);

}  // namespace sunder::shell
