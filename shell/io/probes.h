#pragma once
// What a scene asks to be measured on a shell: probes.csv.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/solver/state.h"

namespace sunder::shell {

struct Probe {
  std::string name;
  int shell = -1;          // index; -1: of a body
  Vec2 at = Vec2::Zero();  // parameters [m]
  int body = -1;           // index; -1: of a shell
  bool soft = false;       // the body is a soft one
};

/// First line of probes.csv: time, displacement of each point and motion of each body, reaction of all supports.
std::string probe_header(const std::vector<Probe>& probes);
/// A shell as it stands.
struct ShellView {
  const ShellModel* model;
  const ShellState* state;
};

/// A row; what belongs to shells stays empty where `shells` is, else they are all of the scene's. The reaction [N] is
/// what supports exert on the shell, with the forces that the state holds: along each axis minus the sum over control
/// points that they hold or drive.
std::string probe_row(const std::vector<Probe>& probes, const std::vector<ShellView>& shells,
                      const std::vector<BodyMotion>& bodies, const std::vector<BodyMotion>& soft, double time,
                      const Vec3& gravity);

/// Displacement [m] of the material point, with the functions of the uncut patch.
Vec3 displacement(const ShellModel& model, const ShellState& state, const Vec2& at);
/// Area of the mid-surface at rest and now [m^2], of the Gauss points that bear and have not left.
std::pair<double, double> surface_area(const ShellModel& model, const ShellState& state);
/// Reaction of all supports [N].
Vec3 reaction(const ShellModel& model, const ShellState& state, const Vec3& gravity);

}  // namespace sunder::shell
