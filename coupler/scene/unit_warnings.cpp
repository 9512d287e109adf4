#include "coupler/scene/unit_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace sunder::scene {
namespace {

constexpr double kSoftest = 1e3;            // [Pa]: Young's modulus of soft gels
constexpr double kStrongest = 100.0;        // [Young's modulus]: rubber bears some tens of it
constexpr double kWeakest = 1e-7;           // [Young's modulus]: a hundredth of the weakest foams and clays
constexpr double kLightest = 5.0;           // [kg/m^3]: a few times air
constexpr double kHeaviest = 3e4;           // [kg/m^3]: osmium has 22,600
constexpr double kThickestOfWidth = 0.5;    // [width]
constexpr double kWidest = 100.0;           // [m]
constexpr double kFastest = 3e3;            // [m/s]: solids flow and melt in impacts that fast
constexpr double kGiga = 1e9, kMega = 1e6;  // [Pa] of a GPa and a MPa
constexpr double kMilli = 1e-3;             // [m] of a mm
// Fields that units decide, beside lengths (`_m`). `pose`: whether a body starts inside a shell.
constexpr std::array<std::string_view, 15> kDecided = {
    "density", "youngs_modulus", "strength",   "fracture_energy", "yield_stress", "surface_compression",
    "mode",    "contacts",       "hertz",      "stiffness",       "twist",        "motion",
    "pose",    "window_s",       "time_step_s"};
// What stops a run where its numbers do not go together.
constexpr std::array<std::string_view, 8> kStops = {"unstable", "compression", "equilibrium", "modes",
                                                    "hertz",    "fibres",      "substeps",    "soft_inverted"};

void of_material(const proto::Material& m, const std::string& field, std::vector<std::string>& out) {
  const double stiffness = m.youngs_modulus(), strength = m.strength(), density = m.density();
  if (m.has_youngs_modulus() && stiffness < kSoftest)
    out.push_back(fmt::format("{}.youngs_modulus is {:g} Pa, softer than a gel; {:g} GPa are {:g}", field, stiffness,
                              stiffness, kGiga * stiffness));
  else if (m.has_youngs_modulus() && strength > kStrongest * stiffness)
    out.push_back(fmt::format("{}.strength is {:g} Pa, and youngs_modulus {:g} Pa; {:g} MPa are {:g}", field, strength,
                              stiffness, stiffness, kMega * stiffness));
  else if (m.has_youngs_modulus() && m.has_strength() && strength > 0.0 && strength < kWeakest * stiffness)
    out.push_back(fmt::format("{}.strength is {:g} Pa, {:.1g} of youngs_modulus; {:g} MPa are {:g}", field, strength,
                              strength / stiffness, strength, kMega * strength));
  if (m.has_density() && density < kLightest)
    out.push_back(fmt::format("{}.density is {:g} kg/m^3, about that of air; {:g} g/cm^3 are {:g}", field, density,
                              density, 1e3 * density));
  if (density > kHeaviest)
    out.push_back(fmt::format("{}.density is {:g} kg/m^3, more than any metal has", field, density));
}

void of_plate(const proto::Shell& s, const std::string& field, std::vector<std::string>& out) {
  const double wide = std::max(s.plate().size_x_m(), s.plate().size_y_m());
  const double narrow = std::min(s.plate().size_x_m(), s.plate().size_y_m());
  if (s.thickness_m() > kThickestOfWidth * narrow)
    out.push_back(fmt::format("{}.thickness_m is {:g} m, and the plate is {:g} m wide; {:g} mm are {:g}", field,
                              s.thickness_m(), narrow, s.thickness_m(), kMilli * s.thickness_m()));
  if (wide > kWidest)
    out.push_back(fmt::format("{}.plate is {:g} m wide; {:g} mm are {:g}", field, wide, wide, kMilli * wide));
}

}  // namespace

std::vector<std::string> unit_warnings(const proto::Scene& scene) {
  std::vector<std::string> out;
  for (int i = 0; i < scene.materials_size(); ++i)
    of_material(scene.materials(i), fmt::format("materials[{}]", scene.materials(i).name()), out);
  for (int i = 0; i < scene.shells_size(); ++i)
    if (scene.shells(i).has_plate()) of_plate(scene.shells(i), fmt::format("shells[{}]", scene.shells(i).name()), out);
  for (int i = 0; i < scene.bodies_size(); ++i) {
    const auto& v = scene.bodies(i).twist().linear();
    if (const double speed = std::hypot(v.x(), v.y(), v.z()); speed > kFastest)
      out.push_back(
          fmt::format("bodies[{}].twist.linear is {:g} m/s; solids flow and melt in impacts that fast, which no "
                      "model here does",
                      scene.bodies(i).name(), speed));
  }
  return out;
}

bool may_be_by_units(const Error& error) {
  const auto among = [](const auto& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  if (error.status == Exit::kPhysics) return among(kStops, error.kind);
  if (error.status != Exit::kBadInput) return false;
  const std::string_view last = std::string_view(error.field).substr(error.field.rfind('.') + 1);
  return last.ends_with("_m") || last == "shortest_window_s" || among(kDecided, last);
}

}  // namespace sunder::scene
