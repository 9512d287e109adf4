#pragma once
// Finds where borders of patches run together, where one of both is trimmed.
#include <string>
#include <vector>

#include "shell/geometry/seams.h"
#include "shell/geometry/trim_loops.h"

namespace sunder::shell {

constexpr double kSmoothAngle = 2e-3;  // largest angle of a smooth seam along a trim [rad]
constexpr double kNearlySmooth = 0.1;  // of one that is known to be smooth [rad]

/// A patch with its trims, and the edges that find_stitches joins.
struct BorderedPatch {
  const Patch* patch = nullptr;  // as it is without trims; parameters are lengths
  const TrimLoops* trims = nullptr;
  int whole = 0;  // EdgeBits of edges that exist over their whole length
  std::string name;
};

/// A stretch of two borders that is known to run together.
struct KnownBorder {
  int first = 0, second = 0;                      // patches
  std::vector<PlaneCurve> on_first, on_second{};  // in their parameters, at the same places for each t
  bool closed = false;                            // it goes round
  bool smooth = false;                            // the surfaces are smooth there, but for the errors of both
};

/// Makes seams of such stretches. Those that are smooth are tied in slope, unless `join` makes them hinges or open.
std::vector<Seam> known_seams(const std::vector<BorderedPatch>& patches, const std::vector<KnownBorder>& borders,
                              const std::vector<std::vector<Join>>& join);

/// Finds stretches of borders that run together within `tolerance` [m]: loops, and edges of patches where one of both
/// is not whole. `join` is that of find_stitches. Throws Error where borders nearly meet over some length, or where the
/// normals at a smooth seam are opposite.
std::vector<Seam> find_trim_seams(const std::vector<BorderedPatch>& patches, double tolerance,
                                  const std::vector<std::vector<Join>>& join);

}  // namespace sunder::shell
