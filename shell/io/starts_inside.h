#pragma once
// Refuses bodies that start inside a shell, and says how far to move what.
#include <string>

#include "shell/contact/proxy.h"
#include "shell/io/shell_setup.h"

namespace sunder::shell {

/// How deep a body is in the faces of a shell at rest, where it is deepest at a Gauss point.
struct StartDepth {
  double depth = 0.0;           // [m], negative outside
  double face = 0.0;            // distance of the shell's faces from its middle there [m]
  Vec3 outward = Vec3::Zero();  // normal of the body's surface there
  Vec3 normal = Vec3::Zero();   // of the shell there
};
StartDepth start_depth(const ShellModel& shell, const Proxy& body);

/// True where a body starts outside of the faces, up to round-off.
bool starts_outside(const StartDepth& found);

/// The shortest of the ways [m] that take the body out along the shell's normal, or along its own; zero where none
/// does.
Vec3 way_out(const ShellModel& shell, const Proxy& body, const StartDepth& found);

/// "'floor' starts 0.001 m inside shell 'pane', ...; move ...": with the way that takes it out.
std::string starts_inside(const StartDepth& found, const ShellModel& shell, const Proxy& body);

}  // namespace sunder::shell
