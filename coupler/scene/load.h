#pragma once
// Reads a scene file: text -> message, settings applied, everything checked; every error says
// file:line:column, field, value and remedy.
#include <memory>
#include <string>
#include <vector>

#include "coupler/core/error.h"
#include "coupler/core/vec.h"
#include "scene.pb.h"

namespace sunder::scene {

class LoadedScene {
 public:
  LoadedScene();
  ~LoadedScene();
  LoadedScene(LoadedScene&&) noexcept;

  proto::Scene message;
  std::string path;
  std::string hash;                   // SHA-256 of the message as text, settings included, and of files that it names
  std::vector<std::string> settings;  // name.path=value, that changed the file's message

  /// Throws Error (bad_scene) at the place of `field` ("shells[0].plate.size_x_m"), or at the nearest
  /// enclosing one that the file has.
  [[noreturn]] void fail(const std::string& field, const std::string& problem) const;
  template <class... Args>
  void check(bool good, const std::string& field, fmt::format_string<Args...> format, Args&&... args) const {
    if (!good) fail(field, fmt::format(format, std::forward<Args>(args)...));
  }
  /// The file that a field names, in or below the scene's folder. Throws Error where it is elsewhere or cannot be read.
  std::string file_beside(const std::string& field, const std::string& name) const;

 private:
  friend LoadedScene load(const std::string&, const std::vector<std::string>&);
  struct Places;
  std::unique_ptr<Places> places_;
};

/// `settings`: name.path=value, as in bodies[ball].twist.linear.z=-20.
LoadedScene load(const std::string& path, const std::vector<std::string>& settings);

/// Applies one setting; throws Error (bad_setting) with what there is instead.
void apply_setting(proto::Scene& scene, const std::string& setting);

/// What needs no geometry: numbers, names, references, counts, paths.
void validate(const LoadedScene& scene);
/// Its part about schemes, windows and joints.
void validate_coupling(const LoadedScene& scene);
/// Its part about soft bodies.
void validate_soft(const LoadedScene& scene);
/// Its part about fibres of shells.
void validate_fibres(const LoadedScene& scene);
/// Its part about output and probes.
void validate_output(const LoadedScene& scene);

/// Factors of the strength, one by one and multiplied; from a thousand on nothing breaks that did not before.
constexpr double kLeastFactor = 1e-6, kMostFactor = 1e6;

/// Degree of a shell's patch, whatever its kind: 2 where the scene gives none.
int patch_degree(const proto::Shell& shell);

inline Vec3 to_vec(const proto::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Quat to_quat(const proto::Pose& p) {
  if (!p.has_orientation()) return Quat::Identity();
  const auto& q = p.orientation();
  return Quat(q.w(), q.x(), q.y(), q.z()).normalized();
}

}  // namespace sunder::scene
