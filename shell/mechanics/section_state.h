#pragma once
// Stress, strain and resultants of one point of a shell, for output: in an orthonormal frame, at both faces and the
// middle. Nothing here is used to compute a run.
#include <array>
#include <optional>

#include "coupler/core/vec.h"
#include "shell/mechanics/gathered_point.h"

namespace sunder::shell {

/// What layers of a point remember; null: nothing.
struct SectionMemory {
  const Yielding* yielding = nullptr;            // with `plastic`
  const std::vector<double>* plastic = nullptr;  // states of all layers, as in RowPlasticity; they may be empty
  const PointDamage* damage = nullptr;
  double brittleness = 0.0;
  bool heals = true;
};

/// The core of a laminate: its tables, and its point with the functions of the uncut patch.
struct SectionCore {
  const RowTables& tables;
  const GatheredPoint& point;
};

enum SectionPlace { kOutside, kMiddle, kInside, kSectionPlaces };  // at +thickness/2, 0, -thickness/2

/// State of a section. Components 11 22 12 are those of `first` and `second`, orthonormal in the surface.
struct SectionState {
  Vec3 first, second, normal;
  std::array<Sym2<double>, kSectionPlaces> stress{};  // Cauchy stress [Pa]
  std::array<Sym2<double>, kSectionPlaces> strain{};  // Green's strain [-], turned with the surface
  std::array<double, kSectionPlaces> plastic{};       // equivalent plastic strain of the nearest layer [-]
  Sym2<double> force{}, moment{};  // for a present length [N/m], [N]; moment > 0 stretches the outside
  double thickness = 0.0;          // now [m]
};

/// Returns the state of a section at positions `x`, whose whole thickness at rest is `thickness` [m]. Stress between
/// and beyond layers follows a polynomial through the nearest ones, a straight line where they yield or weaken; there
/// it stays within the yield stress of the nearest layer. Nothing where the point bears no stress.
std::optional<SectionState> section_state(const RowTables& t, const GatheredPoint& point, const std::vector<double>& x,
                                          double thickness, const SectionMemory& memory = {},
                                          const SectionCore* core = nullptr);

/// Makes the state of a section of the layers' thickness that of one whose thickness is `factor` times that
/// (RowTables::thickness).
void thicken(SectionState& section, double factor);

}  // namespace sunder::shell
