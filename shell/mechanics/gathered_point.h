#pragma once
// One gathered point: a Gauss point that a crack has touched, with shape functions of its own. Points that damage may
// weaken are gathered too, but the row kernel sums them.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "shell/mechanics/layers.h"

namespace sunder::shell {

/// Shape function of one control point at a gathered point.
struct GatheredFunction {
  int slot;
  std::array<double, 6> n;  // value, u, v, uu, vv, uv
};

enum class PointKind { kQuadratic, kLinear, kDead };  // linear: membrane only; dead: no force

/// A number that no other caller gets.
std::uint64_t fresh_stamp();

/// A Gauss point and its shape functions.
struct GatheredPoint {
  int block = 0, lane = 0;
  PointKind kind = PointKind::kDead;
  bool handed_off = false;  // with its piece
  // The row kernel sums the point: it is damaged, but no crack has touched it.
  bool in_rows = false;
  // Kernels keep packed copies of all below as long as the stamp is the same. Another point has another stamp, and so
  // have other functions. A dead point has no functions.
  std::uint64_t stamp = fresh_stamp();
  double area = 0.0;                 // reference area, times the factor of the thickness [m^2]
  ReferenceMetric<double> metric{};  // of these shape functions: the rest state has no strain
  std::vector<GatheredFunction> functions;
};

/// All functions of the uncut patch at parameter `p`; slots for rows that are `stride` apart.
std::vector<GatheredFunction> patch_functions(const Patch& patch, const Vec2& p, int stride);
void patch_functions(const Patch& patch, const Vec2& p, int stride, std::vector<GatheredFunction>& out);

/// Makes functions of a surface those of a point whose thickness varies by `factor` (RowTables::thickness).
inline void thicken(std::vector<GatheredFunction>& functions, double factor) {
  if (factor != 1.0)
    for (GatheredFunction& f : functions) f.n[3] *= factor, f.n[4] *= factor, f.n[5] *= factor;
}

/// What the layers of a point remember, and their laws; it stays as it is. Null: they do not weaken, or do not yield.
struct PointMemory {
  const PointDamage* damage = nullptr;
  double brittleness = 0.0;
  bool heals = true;
  const RowPlasticity* plastic = nullptr;
};

/// Force of one point on its derivatives, multiplied by `times`. Empty: the point exerts no force.
std::optional<Derivatives<double>> point_force(const RowTables& t, const GatheredPoint& point,
                                               const std::vector<double>& x, double times,
                                               const PointMemory& memory = {});
/// Adds direction k of such a force to the control points in `force`.
void spread(const RowTables& t, const GatheredPoint& point, const Derivatives<double>& of_point, int k,
            std::vector<double>& force);

/// Elastic energy of one point [J].
double point_energy(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                    const PointMemory& memory = {});
/// The same as if it were not weakened.
double full_energy(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                   const PointMemory& memory = {});
/// For damage without healing: sets the memory of a point as if it had reached these positions with its present shape
/// functions. The laws are those of `memory`.
void settle_damage(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                   const PointMemory& memory, PointDamage& damage);
/// The same for layers that yield. Returns the plastic work [J]. A linear point has no curvature, and its layers take
/// their mean state.
double settle_flow(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                   const PointMemory& memory);

/// First and second derivatives of the surface at a point.
Derivatives<double> gather(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x);

/// Stress of both faces of a point without damage [Pa]: 11 22 12 of the lower face, then of the upper. `plastic`:
/// states of layers that yield, as in RowPlasticity; null: none.
std::array<double, 6> undamaged_stress(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                                       const std::vector<double>* plastic = nullptr);

/// Largest principal stretch of the middle surface at a point, beyond the mean flow of its layers.
double largest_stretch(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                       const std::vector<double>* plastic = nullptr);

/// Stress of both faces [Pa] by resultants n [N/m] and m [N], each 11 22 12.
inline std::array<double, 6> linear_stress(const double* n, const double* m, const SectionFaces& section) {
  std::array<double, 6> faces{};
  for (int k = 0; k < 3; ++k) {
    const double mean = n[k] / section.thickness, bend = 6.0 * m[k] / section.squared;
    faces[k] = mean - bend, faces[3 + k] = mean + bend;
  }
  return faces;
}

}  // namespace sunder::shell
