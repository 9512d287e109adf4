#pragma once
// Checks that the parts of validate() share. Each refuses at the place of `field`, with the value.
#include <cmath>
#include <set>
#include <string>

#include "coupler/scene/load.h"

namespace sunder::scene {

/// What trims exclude, and why. A loop leaves some control points with a small part of their mass (kLeastMass).
inline constexpr const char* kTrimsAndFibres =
    "fibres, whose stable step needs control points of whole mass, and a loop leaves some little";
inline constexpr const char* kTrimsAndDamage =
    "fracture.mode DAMAGE, which would take cells beyond a loop as sound, so that cracks run along it";
inline constexpr const char* kTrimsAndGrid =
    "a transfer through the grid, which moves each control point by its mass: a loop leaves some without, which follow "
    "others";

/// A number that must be given and be above 0; `unit` is for the message.
inline void positive(const LoadedScene& s, const std::string& field, bool has, double value, const char* unit) {
  s.check(has, field, "is missing; give a positive number [{}]", unit);
  s.check(std::isfinite(value) && value > 0.0, field, "is {}; must be positive and finite [{}]", value, unit);
}

/// A factor of the strength: it must be given, and be within its limits.
inline void strength_factor(const LoadedScene& s, const std::string& f, bool has, double factor) {
  positive(s, f, has, factor, "-");
  s.check(factor >= kLeastFactor && factor <= kMostFactor, f, "is {}; {:.0g} to {:.0g} (a thousand is unbreakable)",
          factor, kLeastFactor, kMostFactor);
}

/// A number that must be 0 or more where it is given.
inline void not_negative(const LoadedScene& s, const std::string& field, bool has, double value) {
  s.check(!has || (std::isfinite(value) && value >= 0.0), field, "is {}; must be finite and not negative", value);
}

inline void finite(const LoadedScene& s, const std::string& field, const proto::Vec3& v) {
  s.check(to_vec(v).allFinite(), field, "is ({}, {}, {}); must be finite", v.x(), v.y(), v.z());
}

inline void finite(const LoadedScene& s, const std::string& field, const proto::ParameterPoint& p) {
  s.check(std::isfinite(p.u()) && std::isfinite(p.v()), field, "is ({}, {}); must be finite", p.u(), p.v());
}

/// A turn about an axis that has a direction, by a finite angle.
inline void turn(const LoadedScene& s, const std::string& field, const proto::AxisAngle& r) {
  finite(s, field + ".axis", r.axis());
  s.check(!r.has_axis() || to_vec(r.axis()).norm() > 1e-9, field + ".axis",
          "has no direction; give one, or leave it out: it is z then");
  s.check(std::isfinite(r.angle_deg()), field + ".angle_deg", "is {}; must be finite", r.angle_deg());
}

/// A finite position, and a turn: a quaternion of length 1, or axis and angle.
inline void pose(const LoadedScene& s, const std::string& field, const proto::Pose& p) {
  finite(s, field + ".position", p.position());
  if (p.has_rotation()) turn(s, field + ".rotation", p.rotation());
  if (!p.has_orientation()) return;
  const auto& q = p.orientation();
  const double norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  s.check(std::abs(norm - 1.0) < 1e-6, field + ".orientation",
          "has length {}; a quaternion w x y z has length 1; 'rotation' takes axis and angle", norm);
}

/// A snake_case name of fewer than 200 letters that is not in `taken` yet; adds it.
inline void unique_name(const LoadedScene& s, const std::string& field, const std::string& name,
                        std::set<std::string>& taken) {
  s.check(!name.empty() && name.size() < 200 &&
              name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos,
          field + ".name", "'{}' is no snake_case name", name);
  s.check(taken.insert(name).second, field + ".name", "'{}' is used twice; names are unique", name);
}

/// Whether a name is that of a shell, or NAME.1, NAME.2 ... of one that a file divides, or of a ring. How many there
/// are is known once the file is read (shell/io/part_names.h).
inline bool is_shell(const proto::Scene& m, const std::string& name) {
  const std::size_t dot = name.find('.');
  const std::string whole = name.substr(0, dot), number = dot == std::string::npos ? "" : name.substr(dot + 1);
  if (dot != std::string::npos && (number.empty() || number.size() > 6 ||
                                   number.find_first_not_of("0123456789") != std::string::npos || number[0] == '0'))
    return false;
  for (const proto::Shell& shell : m.shells())
    if (shell.name() == whole && (number.empty() || shell.has_cad() || shell.has_mesh() || has_sectors(shell)))
      return true;
  return false;
}

/// A surface that is a shell, its parts and its paint. `field` is the shell's (validate_mesh.cpp).
void validate_mesh(const LoadedScene& s, const std::string& field, const proto::Shell& shell);
/// Checks a ring or a wide arc, and that only rings have rims as edges.
void validate_annulus(const LoadedScene& s, const std::string& field, const proto::Shell& shell);

/// Whether any part of a shell is of a material for which `f` is true.
template <class F>
bool any_material_of(const proto::Scene& m, const proto::Shell& shell, F&& f) {
  const auto is_of = [&](const std::string& name) {
    if (name == shell.material()) return true;
    for (const proto::MeshPart& part : shell.mesh().parts())
      if (name == part.material()) return true;
    return false;
  };
  for (const proto::Material& material : m.materials())
    if (is_of(material.name()) && f(material)) return true;
  return false;
}

/// Cuts and trims of a shell, whose field is `field` (validate_cuts.cpp).
void validate_cuts(const LoadedScene& s, const std::string& field, const proto::Shell& shell);

/// Least and largest factor on the thickness of a shell.
constexpr double kThinnest = 0.01, kThickest = 100.0;
/// A factor on the thickness: it must be given, and be within its limits.
inline void thickness_factor(const LoadedScene& s, const std::string& f, bool has, double factor) {
  positive(s, f, has, factor, "-");
  s.check(factor >= kThinnest && factor <= kThickest, f, "is {}; {} to {} times thickness_m", factor, kThinnest,
          kThickest);
}
/// Law, map and paint of the thickness of a shell (validate_thickness.cpp).
void validate_thickness(const LoadedScene& s, const std::string& field, const proto::Shell& shell);

/// Regions, lines and map of strength of a shell (validate_strength.cpp).
void validate_strength(const LoadedScene& s, const std::string& field, const proto::Shell& shell);
/// Lines of strength in space, and the shells that they name.
void validate_strength_lines(const LoadedScene& s);

}  // namespace sunder::scene
