#pragma once
// Stiffness of a shell against bodies that press on it.

#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {

/// Returns the stiffness [N/m] against each body, by index: 0 for bodies that are not `asked` for or have no
/// candidates. The control points under a body's candidate samples move together out of it, all others stay; the
/// stiffness is the difference of the force over the displacement. A control point under several bodies counts for the
/// first one only.
std::vector<double> contact_stiffness(const ShellModel& model, ShellState& state, const std::vector<Proxy>& bodies,
                                      const ContactCandidates& candidates, const std::vector<char>& asked, int threads);

}  // namespace sunder::shell
