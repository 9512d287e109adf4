#pragma once
// Which supports of a point give a well conditioned matrix: bounds for eight of them at once, so that the exact
// condition, and the matrix itself, are rarely needed for more than the one that is taken.
#include <array>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A support of half-width `size`, in spacings, and the largest condition that will do.
struct SupportChoice {
  double size, limit;
};
constexpr int kChoices = 8;
enum class Conditioned { kNo, kYes, kUnsure };

/// For each of eight choices: does the matrix of the quadratic basis, over the control points at `offsets` from the
/// point, in spacings, within the support have a condition no larger than the limit? No answer where that is closer
/// than the bounds tell, a few per cent. Fewer than nine control points never do.
std::array<Conditioned, kChoices> conditioned(const std::vector<Vec2>& offsets, const SupportChoice* choices);

}  // namespace sunder::shell
