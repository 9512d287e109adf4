#pragma once
// Internal forces at Gauss points with shape functions of their own: those that a crack has touched. Points that damage
// may weaken are listed with them, and summed by the rows.
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "shell/mechanics/point_damage.h"
#include "shell/mechanics/row_force.h"
#include "shell/mechanics/section.h"

namespace sunder::shell {

/// One control point's part in a gathered point: value and derivatives of its shape function.
struct GatheredFunction {
  int slot;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class PointKind { kQuadratic, kLinear, kDead };  // linear: membrane only; dead: carries nothing

struct GatheredPoint {
  int block = 0, lane = 0;
  PointKind kind = PointKind::kDead;
  double area = 0.0;                 // reference area [m^2]
  ReferenceMetric<double> metric{};  // with these shape functions, so that the rest state has no strain
  std::vector<GatheredFunction> functions;
  bool left = false;  // with a piece that was handed off
  // Damaged, but no crack has touched it: the row kernel sums it, here it is only remembered.
  bool in_rows = false;
};

/// All functions of the uncut patch at parameter `p`, by slots of rows `stride` apart.
std::vector<GatheredFunction> patch_functions(const Patch& patch, const Vec2& p, int stride);
void patch_functions(const Patch& patch, const Vec2& p, int stride, std::vector<GatheredFunction>& out);

struct DamageLaw {
  std::vector<PointDamage>* points = nullptr;  // parallel to the gathered points; null: nothing is damaged
  double brittleness = 0.0;                    // H of eq. 9
  bool heals = true;                           // else the damage of a layer is its maximum over time
  // out: what points that healed in this substep had spared [J]. In one dimension nothing is left then; a
  // cycle of a biaxial stress leaves up to the order of the fracture energy, of either sign.
  double healed = 0.0;
  double dissipated = 0.0;  // out, without healing: what weakening took for good in this substep [J]
};

/// What else acts on control points, summed beside the points, in as many chunks: called for each of them, perhaps at
/// once, with positions and forces of slots as x y z and a padding.
using PointsBeside = std::function<void(int chunk, int chunks, const double* x4, double* force4)>;
constexpr int kPointLanes = 4;  // a slot's x y z and a padding

/// Adds the points' forces to `force` [3][plane]; returns their elastic energy [J] if `energy`.
/// `damage` weakens tension by the present stress; where `stress` is recorded its history is kept. Where it
/// heals it is elastic but softer: the energy is the full material's less what weakening spared. A crack
/// that opens there dissipates what is stored. Where it does not, the energy is what unloading along the secant gives
/// back, and the rest is dissipated.
/// Layers that yield go on with the states that they had in the rows; they take no damage.
/// Deterministic: a fixed number of chunks, summed in order. Stress as in row_forces.
double add_point_forces(const RowTables& t, const std::vector<GatheredPoint>& points, const std::vector<double>& x,
                        bool energy, SurfaceStress stress, int threads, std::vector<double>& scratch,
                        std::vector<double>& force, DamageLaw* damage = nullptr, RowPlasticity* plastic = nullptr,
                        const PointsBeside& beside = {});

/// `times` the force of one point, as it stands, before its functions spread it. Nothing: it has none.
std::optional<Derivatives<double>> point_force(const RowTables& t, const GatheredPoint& point,
                                               const std::vector<double>& x, double times,
                                               const PointDamage* damage = nullptr, double brittleness = 0.0,
                                               bool heals = true, const RowPlasticity* plastic = nullptr);
/// Adds what it is on the control points in direction k to `force` [3][plane].
void spread(const RowTables& t, const GatheredPoint& point, const Derivatives<double>& of_point, int k,
            std::vector<double>& force);

/// Elastic energy of one point [J].
double point_energy(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                    const PointDamage* damage = nullptr, double brittleness = 0.0, bool heals = true);
/// The same of one whose layers yield, whose states stay as they are.
double point_energy(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                    const RowPlasticity& plastic);
/// Without healing: as if the point had come to these positions with the functions that it has now.
void settle(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x, double brittleness,
            PointDamage& damage);
/// Layers that yield: the same; returns the plastic work [J]. A linear point, which has no curvature, goes on with the
/// mean of its layers.
double settle(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
              const RowPlasticity& plastic);

Derivatives<double> gather(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x);

/// Stress of both faces [Pa] that an undamaged point would bear, 11 22 12 of the lower face, then of the upper.
std::array<double, 6> undamaged_stress(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x);

}  // namespace sunder::shell
