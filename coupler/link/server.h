#pragma once
// The engine's side of a session, for any engine: a state machine over requests.
#include <functional>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/link/client.h"

namespace sunder::link {

/// What an engine does when asked; adapters fill these in.
struct RigidService {
  Peer peer;
  std::function<void(const RigidBody&)> add;
  std::function<void(const std::vector<ContactLaw>&)> set_contact_laws;
  std::function<void(double, const std::vector<Motion>&)> advance;
  std::function<std::vector<State>()> states;
};

/// Serves one session on `endpoint` and returns after Bye. Throws Error: peer_lost where the other
/// side is gone or says it failed, bad_message where it speaks out of turn (it is told so).
void serve(const std::string& endpoint, const RigidService& service);

}  // namespace sunder::link
