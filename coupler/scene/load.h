#pragma once
// Reads a scene file, applies settings and checks the result. Every error says file:line:column, field, value and
// remedy.
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "coupler/core/error.h"
#include "coupler/core/vec.h"
#include "scene.pb.h"

namespace sunder::scene {

/// A scene with the places of its fields in the file.
class LoadedScene {
 public:
  LoadedScene();
  ~LoadedScene();
  LoadedScene(LoadedScene&&) noexcept;

  proto::Scene message;
  std::string path;
  std::string text;                   // the message as text, with settings and presets applied
  std::string hash;                   // SHA-256 of `text` and of the files that it names
  std::vector<std::string> settings;  // applied to the file's message, each as name.path=value

  /// Throws Error (bad_scene) at the place of `field` ("shells[0].plate.size_x_m"). Where the file does not have the
  /// field, the place is that of the nearest enclosing message.
  [[noreturn]] void fail(const std::string& field, const std::string& problem) const;
  /// fail() with the formatted text where `good` is false.
  template <class... Args>
  void check(bool good, const std::string& field, fmt::format_string<Args...> format, Args&&... args) const {
    if (!good) fail(field, fmt::format(format, std::forward<Args>(args)...));
  }
  /// Absolute path of the file that a field names. Throws Error where it is not in or below the scene's folder, or
  /// cannot be read.
  std::string file_beside(const std::string& field, const std::string& name) const;

 private:
  friend LoadedScene load(const std::string&, const std::vector<std::string>&);
  struct Places;
  std::unique_ptr<Places> places_;
};

/// Reads and checks a scene file. `settings`: name.path=value, as in bodies[ball].twist.linear.z=-20. Throws Error
/// (bad_scene, bad_setting, bad_input) with the remedy.
LoadedScene load(const std::string& path, const std::vector<std::string>& settings);

/// Applies one setting. Throws Error (bad_setting) with the nearest right names.
void apply_setting(proto::Scene& scene, const std::string& setting);

/// Checks all that needs no geometry: numbers, names, references, counts, paths. Throws Error (bad_scene).
void validate(const LoadedScene& scene);
/// Its part about schemes, windows, joints and seams.
void validate_coupling(const LoadedScene& scene);
/// Its part about soft bodies.
void validate_soft(const LoadedScene& scene);
/// Its part about bodies that follow a prescribed motion or change their shape.
void validate_motion(const LoadedScene& scene);
/// Its part about fibres of shells.
void validate_fibres(const LoadedScene& scene);
/// Its part about output and probes.
void validate_output(const LoadedScene& scene);
/// Its part about scenes in which nothing moves, and about load steps.
void validate_statics(const LoadedScene& scene);

/// Its part about mass that is added to small elements.
void validate_mass_scaling(const LoadedScene& scene);

/// Bounds of a factor of the strength [-], and of the product of all factors at a point. A factor of a thousand is
/// unbreakable in practice.
constexpr double kLeastFactor = 1e-6, kMostFactor = 1e6;

/// Degree of a shell's patch of any kind; 2 where the scene gives none.
int patch_degree(const proto::Shell& shell);

/// Least arc of a cylinder or cone that several patches make up [deg]; nearly half a turn is too much for one.
constexpr double kWideArc = 150.0;

/// Angle of a shell's arc [deg]: of an annulus, a cylinder or a cone; 0 for other shells.
double arc_deg(const proto::Shell& shell);

/// True for a shell of equal sectors, NAME.1, NAME.2 ...: an annulus, or a cylinder or cone with a wide arc.
bool has_sectors(const proto::Shell& shell);

/// True where the last sector is joined to the first.
bool is_closed(const proto::Shell& shell);

/// True where nothing moves: shells, no bodies, no time. A run then finds equilibria only.
bool is_static(const proto::Scene& scene);

inline Vec3 to_vec(const proto::Vec3& v) { return {v.x(), v.y(), v.z()}; }
/// The vector of a turn: along its axis, as long as its angle [rad].
inline Vec3 to_turn(const proto::AxisAngle& r) {
  const Vec3 axis = r.has_axis() ? Vec3(to_vec(r.axis()).normalized()) : Vec3(Vec3::UnitZ());
  return r.angle_deg() * std::numbers::pi / 180.0 * axis;
}
inline Quat to_quat(const proto::Pose& p) {
  if (p.has_rotation()) return rotation_from_vector(to_turn(p.rotation()));
  if (!p.has_orientation()) return Quat::Identity();
  const auto& q = p.orientation();
  return Quat(q.w(), q.x(), q.y(), q.z()).normalized();
}

}  // namespace sunder::scene
