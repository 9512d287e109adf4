#pragma once
// Probes of a scene: the columns of probes.csv.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// A point of a shell, or a body, that the scene asks to measure.
struct Probe {
  std::string name;
  int shell = -1;          // index; -1: the probe is on a body
  Vec2 at = Vec2::Zero();  // parameters [m]
  int body = -1;           // index; -1: the probe is on a shell
  bool soft = false;       // the body is soft
};

/// Returns the first line of probes.csv: time, displacement of each point, motion of each body, reaction of all
/// supports.
std::string probe_header(const std::vector<Probe>& probes);
/// Model and present state of a shell.
struct ShellView {
  const ShellModel* model;
  const ShellState* state;
};

/// Returns a row of probes.csv. `shells` are all shells of the scene, or empty: then their columns stay empty. The
/// reaction [N] is the force of supports on the shell at the state's forces: minus the sum over held or driven control
/// points, along each axis.
std::string probe_row(const std::vector<Probe>& probes, const std::vector<ShellView>& shells,
                      const std::vector<BodyMotion>& bodies, const std::vector<BodyMotion>& soft, double time,
                      const Vec3& gravity);

/// Displacement [m] of a material point, with the functions of the uncut patch.
Vec3 displacement(const ShellModel& model, const ShellState& state, const Vec2& at);
/// Area of the mid-surface [m^2] at rest and now, over Gauss points that bear stress and are not handed off.
std::pair<double, double> surface_area(const ShellModel& model, const ShellState& state);
/// Force of all supports on the shell [N].
Vec3 reaction(const ShellModel& model, const ShellState& state, const Vec3& gravity);

}  // namespace sunder::shell
