#pragma once
// Regions of a parameter plane, bounded by loops of curves, and their division by lines of constant parameter.
#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// A curve over t from 0 to 1.
using RegionCurve = std::function<Vec2(double)>;
/// A closed loop of curves, each beginning where the one before ends. The region lies on its left.
using RegionLoop = std::vector<RegionCurve>;
using Region = std::vector<RegionLoop>;

constexpr int kRegionSamples = 65;  // places along a curve where it is looked at

/// Calls f(curve, t) at places along each curve of a loop.
template <class F>
void each_sample(const RegionLoop& loop, F&& f) {
  for (const RegionCurve& curve : loop)
    for (int i = 0; i < kRegionSamples; ++i) f(curve, static_cast<double>(i) / (kRegionSamples - 1));
}

/// Smallest box around a loop, extremes between two samples included.
Eigen::AlignedBox2d box_of(const RegionLoop& loop);

/// Area that a loop encloses, positive for an outline (counter-clockwise) and negative for a hole.
double area_of(const RegionLoop& loop);

/// The part of a region where coordinate `axis` (0 or 1) is below `value`, or above it. Curves are cut where they cross
/// the line; pieces are joined along it. No corner may lie on the line (crosses_cleanly).
Region part_of(const Region& region, int axis, double value, bool below);

/// Whether no curve of the region begins, ends or runs within `tolerance` of the line.
bool crosses_cleanly(const Region& region, int axis, double value, double tolerance);

/// Outlines of a region, each with the holes inside of it.
std::vector<Region> connected(const Region& region);

}  // namespace sunder::shell
