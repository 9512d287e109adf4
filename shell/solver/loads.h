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

/// Where the load of a point or an edge acts, with the functions of the uncut patch.
struct LoadSample {
  std::vector<GatheredFunction> functions;
  double weight = 1.0;   // length [m]; 1 for points
  double outward = 0.0;  // for edges: +1 where the tangent below has the patch on its left
  bool along_u = false;  // the edge's tangent is x_u, else x_v
};
struct PreparedLoad {
  Load load;
  std::vector<LoadSample> samples;
};
struct PreparedLoads {
  std::vector<PreparedLoad> beside;  // of points and edges
  std::vector<Load> pressures;
  std::vector<double> area;  // parameter area of Gauss points [block][lane] [m^2]; empty: no pressure

  bool empty() const { return beside.empty() && pressures.empty(); }
  /// Some turn with the surface, so that their tangent is not symmetric.
  bool follow() const;
  /// Until when they change [s]; 0: they do not.
  double last_change() const;
};

/// Throws Error where a point lies outside the patch or nothing is loaded.
PreparedLoads prepare_loads(const Patch& patch, const RowTables& tables, const std::vector<Load>& loads,
                            const std::string& name);

/// Overwrites `force` with that of the loads at `time` and positions `x`, both [3][plane]. `points`: the gathered Gauss
/// points of a state, which bear pressure with their own functions.
void load_forces(const PreparedLoads& loads, const RowTables& tables, const std::vector<GatheredPoint>& points,
                 double time, const std::vector<double>& x, int threads, RowScratch& scratch,
                 std::vector<double>& force);

}  // namespace sunder::shell
