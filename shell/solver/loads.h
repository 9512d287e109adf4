#pragma once
// Forces from outside on a shell, apart from gravity and bodies.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// Factor over time [s], linear between points and constant beyond; empty: 1.
using TimeFactor = std::vector<std::pair<double, double>>;
double factor_at(const TimeFactor& factor, double time);

struct Load {
  enum class Kind {
    kPoint,       // `force` [N] at parameter `point`; keeps its direction
    kEdgeForce,   // `force` [N/m] of reference length along `edges`; keeps its direction
    kEdgeMoment,  // `size` [N] (moment per reference length) about the edge: turns the outside of the edge towards
                  // the normal; follows the edge
    kPressure     // `size` [Pa] along the normal x_u cross x_v; follows the surface, counts its present area
  };
  Kind kind = Kind::kPoint;
  Vec2 point = Vec2::Zero();  // parameters [m]
  int edges = 0;              // EdgeBits
  Vec3 force = Vec3::Zero();
  double size = 0.0;
  TimeFactor in_time;
};

/// Where a load acts and with which functions. Those of points on cracks' reach are the uncut patch's for points
/// and edges; pressure takes them as they stand.
struct LoadSample {
  std::vector<GatheredFunction> functions;
  double weight = 1.0;       // length [m]; parameter area for pressure; 1 for points
  double outward = 0.0;      // for edges: +1 where the tangent below has the patch on its left
  bool along_u = false;      // the edge's tangent is x_u, else x_v
  int block = -1, lane = 0;  // Gauss point of pressure
};
struct PreparedLoad {
  Load load;
  std::vector<LoadSample> samples;
};

/// Throws Error where a point lies outside the patch or nothing is loaded.
std::vector<PreparedLoad> prepare_loads(const Patch& patch, const RowTables& tables, const std::vector<Load>& loads,
                                        const std::string& name);

/// Adds the load's forces at `time` and positions `x` to `force`, both [3][plane]. `points` and `point_of` are the
/// gathered Gauss points of a state.
void add_load(const PreparedLoad& load, const RowTables& tables, const std::vector<GatheredPoint>& points,
              const std::vector<int>& point_of, double time, const std::vector<double>& x, std::vector<double>& force);

}  // namespace sunder::shell
