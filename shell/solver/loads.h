#pragma once
// External forces on a shell, without gravity and contact with bodies.
#include <vector>

#include "shell/geometry/patch.h"
#include "shell/mechanics/point_force.h"

namespace sunder::shell {

/// Factor over time [s]: linear between points, constant outside; empty: 1.
using TimeFactor = std::vector<std::pair<double, double>>;
double factor_at(const TimeFactor& factor, double time);

/// A load as the scene gives it.
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

/// A sample of a point or edge load, with the functions of the uncut patch.
struct LoadSample {
  Vec2 at = Vec2::Zero();  // parameters [m]
  std::vector<GatheredFunction> functions;
  double weight = 1.0;   // length [m]; 1 for points
  double outward = 0.0;  // edges: +1 where the tangent has the patch on its left, otherwise -1
  bool along_u = false;  // the edge's tangent is x_u, otherwise x_v
};
struct PreparedLoad {
  Load load;
  std::vector<LoadSample> samples;
};
struct PreparedLoads {
  std::vector<PreparedLoad> beside;  // of points and edges
  std::vector<Load> pressures;
  std::vector<double> area;  // parameter area of each Gauss point [block][lane] [m^2]; empty: no pressure

  bool empty() const { return beside.empty() && pressures.empty(); }
  /// True where a load turns with the surface, so that its tangent stiffness is not symmetric.
  bool rotate_with_surface() const;
  /// Returns the time of the last change of a load [s]; 0: loads are constant.
  double last_change() const;
};

/// Prepares the samples of all loads. A point by an edge is moved onto it (moved_onto_edges). Throws Error where a
/// point lies outside the patch or an edge load names no edge.
PreparedLoads prepare_loads(const Patch& patch, const RowTables& tables, const std::vector<Load>& loads,
                            const std::string& name);

/// Overwrites `force` [N] with the loads at `time` [s] and positions `x` [m], both [3][component stride]. `points` are
/// the gathered Gauss points of a state; pressure acts on them with their own functions.
void load_forces(const PreparedLoads& loads, const RowTables& tables, const std::vector<GatheredPoint>& points,
                 double time, const std::vector<double>& x, int threads, RowScratch& scratch,
                 std::vector<double>& force);

}  // namespace sunder::shell
