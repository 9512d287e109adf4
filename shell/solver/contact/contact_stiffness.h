#pragma once
// What a shell opposes to bodies that are pushed into it.

#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {

/// For each body, by index: force per displacement [N/m] where the control points under its candidate samples are moved
/// together out of it while all others stay, by differences of the force. 0 where it has no candidates. Bodies that
/// share control points share what is moved; the longest patch counts for both.
std::vector<double> contact_stiffness(const ShellModel& model, ShellState& state, const std::vector<Proxy>& bodies,
                                      const ContactCandidates& candidates, const std::vector<char>& asked, int threads);

}  // namespace sunder::shell
