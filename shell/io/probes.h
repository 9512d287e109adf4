#pragma once
// Probes of a scene: the columns of probes.csv.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/io/fields.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A point of a shell, a body, or the contact of a shell with a body or another shell, that the scene asks to measure.
struct Probe {
  std::string name;
  int shell = -1;          // index; -1: the probe is on a body
  Vec2 at = Vec2::Zero();  // parameters [m]
  int body = -1;           // index; -1: the probe is on a shell
  bool soft = false;       // the body is soft
  FieldSet fields{};       // at the point
  int other = -1;          // index of the other shell of a pair
  bool is_pair() const { return shell >= 0 && (body >= 0 || other >= 0); }
};

/// Model and present state of a shell, and gravity on it [m/s^2].
struct ShellView {
  const ShellModel* model;
  const ShellState* state;
  Vec3 gravity = Vec3::Zero();
};

/// Contact of a shell since the last row.
struct ContactSince {
  ContactOverTime on_points{};     // as for fields
  std::vector<double> by_body{};   // impulse of each body on the shell [N s]; empty: none
  std::vector<double> by_shell{};  // the same of each other shell
};

/// What probes look at, at one moment.
struct ProbeMoment {
  double time = 0.0;                            // [s]
  const std::vector<ShellView>& shells;         // all shells of the scene, or none: then their columns stay empty
  const std::vector<ContactSince>& contacts;    // of each shell
  const std::vector<const RigidBody*>& bodies;  // of the scene
  const std::vector<BodyMotion>& soft;
};

/// Returns the first line of probes.csv: time; displacement of each point with its fields, motion of each body, contact
/// of each pair; reaction of all supports, reaction and impulse of each part of a support. `models` are all shells of
/// the scene.
std::string probe_header(const std::vector<Probe>& probes, const std::vector<const ShellModel*>& models);
/// Returns a row of probes.csv. A reaction [N] is the force of supports on the shell at the state's forces: minus the
/// sum over held or driven control points, along each axis. An impulse [N s] is what the part, or the body or other
/// shell of a pair, has given to the shell since the last row.
std::string probe_row(const std::vector<Probe>& probes, const std::vector<const ShellModel*>& models,
                      const ProbeMoment& now);

/// Displacement [m] of a material point, with the functions of the uncut patch.
Vec3 displacement(const ShellModel& model, const ShellState& state, const Vec2& at);
/// Area of the mid-surface [m^2].
struct SurfaceArea {
  double rest = 0.0, now = 0.0;  // of Gauss points that bear stress
  double torn = 0.0;             // at rest: of those that bear none, on pieces that are still there
  double gone = 0.0;             // at rest: of those that were handed off
  bool whole() const { return torn == 0.0 && gone == 0.0; }
  void operator+=(const SurfaceArea& o) { rest += o.rest, now += o.now, torn += o.torn, gone += o.gone; }
};
/// Area of one element, in this row of elements and lane.
SurfaceArea surface_area(const ShellModel& model, const ShellState& state, int row, int lane);
/// Area of all elements.
SurfaceArea surface_area(const ShellModel& model, const ShellState& state);
/// Force of one part of a support on the shell [N].
Vec3 reaction(const ShellModel& model, const ShellState& state, const Vec3& gravity, const Constraints::Part& part);
/// Force of all supports on the shell [N].
Vec3 reaction(const ShellModel& model, const ShellState& state, const Vec3& gravity);
/// Impulse that one part of a support has given to the shell since state.motion.support_impulse was zero [N s].
Vec3 support_impulse(const ShellState& state, const Constraints::Part& part);

}  // namespace sunder::shell
